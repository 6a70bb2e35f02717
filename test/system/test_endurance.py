"""The promises that take long to test: scripts/soak and scripts/stress as a user runs them."""

import json
import os
import shutil
import subprocess

import pytest

from stack import ROOT, effort


def run(script, *arguments):
    """Runs a script with the system's python and prints its output. Returns its exit code."""
    command = ["/usr/bin/python3", os.path.join(ROOT, "scripts", script), *[str(word) for word in arguments]]
    done = subprocess.run(command, capture_output=True, text=True, timeout=3600, check=False)
    print(done.stdout, done.stderr[-2000:])
    return done.returncode


def test_a_session_with_everything_going_wrong_keeps_its_promises(tmp_path):
    """R11: bad network, cuts of the robot's link, repeated hazards. 12 s here, ten minutes in the long form."""
    code = run("soak", "--minutes", effort(0.2, 10), "--output", tmp_path)
    with open(tmp_path / "soak.json", encoding="utf-8") as file:
        figures = json.load(file)
    assert code == 0 and figures["held"], [row for row in figures["promises"] if not row["held"]]
    assert os.path.getsize(tmp_path / "soak.png") > 1000


@pytest.mark.skipif(effort(True, False), reason="four minutes next to bare threads and loads: in the long form only")
@pytest.mark.skipif(shutil.which("stress-ng") is None, reason="stress-ng is not installed")
def test_loads_and_pictures_and_plans_disturb_the_loops_no_more_than_bare_threads(tmp_path):
    """R1, R2, R9."""
    assert run("stress", "--json", tmp_path / "stress.json") == 0
