#!/usr/bin/python3
"""Starts scripts/station and drives the robot through its pages, as a person with a mouse does.

    test/system/station_drive.py [--port N]

Needs the built programs. The last line says how far the robot's tip moved. Exit status: 0 it followed the hand, 1 not.
"""

import argparse
import asyncio
import os
import subprocess
import sys
import tempfile
import time

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from stack import ROOT, listens, wait_until  # noqa: E402
from station_rig import Page, drive, engage, start, stop  # noqa: E402

sys.path.insert(0, os.path.join(ROOT, "scripts"))
import raven2_session  # noqa: E402

HAND = 0.012  # [m] a message: 1.2 mm of the tool at scale 0.1


async def drive_once(url):
    """A session whose arms a page moves. @return its name."""
    async with Page(url) as page, Page(url, "trainee") as trainee:
        await start(page, driver="browser", exercise="none", hazard="none")
        assert (await trainee.ask("drive"))["ok"]
        await page.until(lambda: page.mode() == "pedal_up", 60, "the robot is ready")
        await engage(page, trainee)
        for sign in (1, -1):
            await drive(trainee, 30, move=[sign * HAND, 0, 0])
        name = page.newest["station"]["session"]
        await stop(page)
    return name


def robots_path(directory):
    """[mm] largest distance of the gold tip of the robot from its place at the first pedal-down."""
    log = raven2_session.SessionLog(os.path.join(directory, "session.rlog"))
    down = log.ticks[log.ticks["model"]["mode"] == log.names("tick", "model.mode").index("teleoperating")]
    tips = down["robot"]["arms"]["p_BT"][:, 0]
    return 1e3 * np.linalg.norm(tips - tips[0], axis=1).max()


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--port", type=int, default=8080, help="of the pages (default: %(default)s)")
    port = parser.parse_args().port
    with tempfile.TemporaryDirectory(prefix="raven2_drive_") as sessions:
        begun = time.monotonic()
        with subprocess.Popen([os.path.join(ROOT, "scripts/station"), "--port", str(port), "--sessions", sessions]) as station:
            try:
                wait_until(lambda: listens(port) or station.poll() is not None, 300, "the station answers", period=0.2)
                name = asyncio.run(drive_once(f"http://localhost:{port}"))
                print(f"driven {time.monotonic() - begun:.0f} s after the start", file=sys.stderr)
            finally:
                station.terminate()  # Ctrl-C is ignored where this script runs in the background
        moved = robots_path(os.path.join(sessions, name))
    print(f"the robot's tip moved {moved:.1f} mm")
    return 0 if moved > 10 else 1


if __name__ == "__main__":
    sys.exit(main())
