"""Tests how the station writes reports and renders videos after a session."""

import asyncio
import pathlib
import sys

import psutil
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from raven2_station import finisher  # noqa: E402


class Finishing:
    """A finisher whose report takes 0.5 s and whose video takes a minute."""

    def __init__(self, folder):
        (folder / "session").mkdir()
        self.session, self.said = folder / "session", []
        (folder / "session_report").write_text("import pathlib, sys, time\ntime.sleep(0.5)\n"
                                               "(pathlib.Path(sys.argv[1]) / 'report.html').touch()\n")
        (folder / "render_session").write_text("#!/bin/sh\nnice >\"$1/nice\"; sleep 60 & echo $! >\"$1/worker\"; wait\n")
        (folder / "render_session").chmod(0o755)
        self.finisher = finisher.Finisher(folder, folder, lambda *words: self.said.append(words[1:3]))

    async def worker(self):
        while not (self.session / "worker").is_file() or not (self.session / "worker").read_text():
            await asyncio.sleep(0.05)
        return psutil.Process(int((self.session / "worker").read_text()))


def test_a_report_is_finished_when_the_station_ends(tmp_path):
    async def run():
        work = Finishing(tmp_path)
        work.finisher.report(work.session)
        await asyncio.sleep(0)
        await work.finisher.end()
        assert (work.session / "report.html").is_file() and work.said[-1] == ("report", 1.0)

    asyncio.run(run())


def test_a_report_that_is_asked_for_again_is_written_again(tmp_path):
    async def run():
        work = Finishing(tmp_path)
        work.finisher.report(work.session)
        await asyncio.sleep(0.1)
        assert work.finisher.is_busy("session") and not work.finisher.is_busy("other")
        work.finisher.report(work.session)  # the session has ended meanwhile
        while work.said.count(("report", 1.0)) < 2:
            await asyncio.sleep(0.05)
        await asyncio.sleep(0)
        assert not work.finisher.is_busy("session")

    asyncio.run(asyncio.wait_for(run(), 30))


def test_a_report_does_not_wait_for_a_video(tmp_path):
    async def run():
        work = Finishing(tmp_path)
        work.finisher.video(work.session)
        await work.worker()
        work.finisher.report(work.session)
        while ("report", 1.0) not in work.said:
            await asyncio.sleep(0.05)
        await work.finisher.end()

    asyncio.run(asyncio.wait_for(run(), 30))


def test_a_video_ends_with_the_station_and_so_does_one_that_waits(tmp_path):
    async def run():
        work = Finishing(tmp_path)
        work.finisher.video(work.session)
        worker = await work.worker()
        assert (work.session / "nice").read_text() == "19\n", "the next session has the processor"
        (tmp_path / "other").mkdir()
        waiting = work.finisher.video(tmp_path / "other")
        await work.finisher.end()
        assert waiting.done() and not list((tmp_path / "other").iterdir())
        assert not worker.is_running() or worker.status() == psutil.STATUS_ZOMBIE

    asyncio.run(run())


# As ProgressBar (src/apps/common/command_line.cpp): a bar on a terminal, a line every 25 % elsewhere. It waits until each
# percentage on the terminal was reported.
RENDERER = """#!/usr/bin/python3
import pathlib, sys, time
seen = pathlib.Path(__file__).with_name("seen")

for percent in range(0, 100, 10):
    if sys.stderr.isatty():
        sys.stderr.write(f"\\rrender [##..] {percent:3d} % 1 min 20 s left\\033[K")
    elif percent % 50 == 0:
        sys.stderr.write(f"render {percent} %\\n")
    sys.stderr.flush()

    while sys.stderr.isatty() and f" {percent / 100} " not in seen.read_text():
        time.sleep(0.01)
sys.stderr.write("\\rrender: over\\033[K\\n")
if STATUS:
    sys.exit("\\033[1mno ffmpeg\\033[0m")
"""


@pytest.mark.parametrize("status", [0, 1])
def test_a_video_shows_its_progress_and_is_in_the_report_afterwards(tmp_path, status):
    async def run():
        work, texts = Finishing(tmp_path), []
        (tmp_path / "render_session").write_text(RENDERER.replace("STATUS", str(status)))
        (tmp_path / "seen").write_text("")

        def changed(_name, what, share, text):
            work.said.append((what, share))
            texts.append(text)
            if what == "video":
                (tmp_path / "seen").write_text((tmp_path / "seen").read_text() + f" {share} ")

        work.finisher = finisher.Finisher(tmp_path, tmp_path, changed)
        await work.finisher.video(work.session)
        shares = [share for what, share in work.said if what == "video"]
        assert list(dict.fromkeys(shares[:-1])) == [percent / 100 for percent in range(0, 100, 10)], shares
        assert shares[-1] == (None if status else 1.0)
        assert not status or "no ffmpeg" in texts
        assert work.finisher.is_busy("session") == (not status)
        while not status and ("report", 1.0) not in work.said:
            await asyncio.sleep(0.05)
        assert (work.session / "report.html").is_file() == (not status)

    asyncio.run(asyncio.wait_for(run(), 30))
