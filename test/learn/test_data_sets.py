"""Data sets of export_session --format lerobot and hdf5, opened with the real libraries, each in an environment from PyPI."""
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
assert {data[i]["truth.phase"] for i in range(60, 330)} == {"nominal", "failure", "recovery"}
assert [i for i in range(330) if data[i]["next.done"]] == [59, 329] and data[329]["next.reward"] == 0
print("opened", data.meta._version)
"""
ROBOMIMIC = "robomimic==0.3.0"  # without what its environments need
OF_ROBOMIMIC = ("torch", "torchvision", "h5py", "tqdm", "psutil", "termcolor", "tensorboard", "tensorboardX", "imageio", "matplotlib", "wheel")
SEQUENCES = """
import sys
import robomimic.utils.obs_utils
from robomimic.utils.dataset import SequenceDataset
robomimic.utils.obs_utils.initialize_obs_utils_with_obs_specs({"obs": {"low_dim": ["state", "objects"], "rgb": ["endoscope_image"]}})
def opened(split):
    return SequenceDataset(hdf5_path=sys.argv[1], obs_keys=("state", "objects", "endoscope_image"), dataset_keys=("actions", "rewards", "dones"),
                           frame_stack=1, seq_length=10, hdf5_cache_mode="low_dim", load_next_obs=True, filter_by_attribute=split)
data = opened(None)
first = data[0]
assert (len(data), len(opened("nominal")), len(opened("recovery"))) == (330, 60, 270), len(data)
assert first["actions"].shape == (10, 14) and first["obs"]["endoscope_image"].shape[1:] == (120, 160, 3), first["obs"]["endoscope_image"].shape
assert (first["next_obs"]["state"][:-1] == first["obs"]["state"][1:]).all() and first["next_obs"]["endoscope_image"].shape[0] == 10
print("opened")
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


def test_robomimic_opens_the_hdf5_file(sessions, tmp_path):
    done = subprocess.run([PROGRAMS / "export_session", *sessions, "--format", "hdf5", "--cameras", "endoscope", "--size", "160x120",
                           "--output", tmp_path / "data.hdf5"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    library = installed(tmp_path / "library", packages=OF_ROBOMIMIC)
    subprocess.run([library / "bin/pip", "install", "--quiet", "--no-deps", ROBOMIMIC], check=True, capture_output=True, timeout=600)
    environment = {**os.environ, "PYTHONPATH": ""}
    for words in (["-c", SEQUENCES, tmp_path / "data.hdf5"],
                  ["-m", "robomimic.scripts.get_dataset_info", "--dataset", tmp_path / "data.hdf5"]):  # raises if it is not as it should be
        opened = subprocess.run([library / "bin/python3", *words], capture_output=True, text=True, check=False, env=environment)
        assert opened.returncode == 0, opened.stderr
