"""Data sets of export_session --format lerobot, opened with the real library, each version in an environment from PyPI."""
import os
import pathlib
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAMS = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build")) / "devel/lib/raven2_trainer"
PYARROW = "pyarrow==18.1.0"  # the newest that works with Debian 12's numpy
LIBRARIES = {"2.1": "lerobot==0.3.3", "3.0": "lerobot==0.4.4"}
OPEN = """
import sys
from lerobot.datasets.lerobot_dataset import LeRobotDataset
data = LeRobotDataset("local/raven2", root=sys.argv[1])
assert (data.num_episodes, data.num_frames) == (2, 330), (data.num_episodes, data.num_frames)
for i in (0, 59, 60, 329):
    frame = data[i]
    assert frame["episode_index"] == (i >= 60) and tuple(frame["observation.images.endoscope"].shape) == (3, 120, 160)
    assert tuple(frame["action"].shape) == (14,) and frame["task"] == "teleoperation"
assert {data[i]["truth.phase"] for i in range(60, 330)} == {"nominal", "failure"}
print("opened", data.meta._version)
"""


def installed(folder, *options, packages):
    subprocess.run(["/usr/bin/python3", "-m", "venv", *options, folder], check=True, timeout=300)
    got = subprocess.run([folder / "bin/pip", "install", "--quiet", *packages], capture_output=True, text=True, timeout=3600, check=False)
    if got.returncode != 0:
        pytest.skip(f"{packages[0]} cannot be installed: {(got.stderr.strip().splitlines() or ['no reason given'])[-1]}")
    return folder


@pytest.fixture(scope="module", name="sessions")
def simulated(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sessions")
    for name, seconds, hazard in (("plain", 2, "none"), ("jump", 9, "sudden_jump")):
        subprocess.run([PROGRAMS / "simulate", "--hazard", hazard, "--seconds", str(seconds), "--homing", "quick", "--output", folder / name],
                       check=True, capture_output=True)
    return [folder / "plain", folder / "jump"]


@pytest.mark.parametrize("version", LIBRARIES)
def test_the_library_opens_the_data_set(version, sessions, tmp_path):
    exporting = installed(tmp_path / "export", "--system-site-packages", packages=[PYARROW])
    done = subprocess.run([PROGRAMS / "export_session", *sessions, "--format", "lerobot", "--lerobot", version, "--cameras", "endoscope",
                           "--size", "160x120", "--output", tmp_path / "data"], capture_output=True, text=True, check=False,
                          env={**os.environ, "VIRTUAL_ENV": str(exporting)})
    assert done.returncode == 0, done.stderr
    library = installed(tmp_path / "library", packages=[LIBRARIES[version]])
    opened = subprocess.run([library / "bin/python3", "-c", OPEN, tmp_path / "data"], capture_output=True, text=True, check=False,
                            env={**os.environ, "PYTHONPATH": "", "HF_HOME": str(tmp_path / "cache"), "HF_HUB_OFFLINE": "1"})
    assert opened.returncode == 0 and f"opened {version}" in opened.stdout, opened.stderr
