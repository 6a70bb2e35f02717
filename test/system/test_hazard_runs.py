"""The same scenario and seed give the same session, byte for byte. Another seed gives another session. In every
scenario, the force comes when the tips part."""
import hashlib
import os
import pathlib
import re
import subprocess
import sys

import pytest
import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "test/system"))
SIMULATE = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build")) / "devel/lib/raven2_trainer/simulate"
IS_LONG = os.environ.get("RAVEN2_TRAINER_FULL", "0") == "1"
# The library's scenarios begin 2 to 8 s after the first pedal-down, those of SHORT within 2 s.
SECONDS = 10 if IS_LONG else 4
# Random values, streams, a bad network, every host. The long form takes the first twenty scenarios of the library.
SHORT = ["usb_garbage", "intent_reorder_delay", "net_loss_30", "master_sluggish"]


def scenarios():
    if not IS_LONG:
        return SHORT
    library = [yaml.safe_load(file.read_text()) for file in (ROOT / "config/faults").glob("*.yaml")]
    return [s["name"] for s in sorted(library, key=lambda s: (s["number"], s["name"]))][:20]


def test_the_force_comes_at_most_a_tick_after_the_tips_part():
    """scripts/measure_hazards judges every crossing of the force's threshold. The long form takes the whole library."""
    which = [] if IS_LONG else ["--hazard", ",".join(SHORT)]
    done = subprocess.run([ROOT / "scripts/measure_hazards", "--seconds", str(SECONDS), *which], capture_output=True,
                          text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    crossings, sessions, late = map(int, re.search(
        r"(\d+) crossings of 3 mm in (\d+) sessions: the force comes (\d+) ticks later at most", done.stdout).groups())
    assert sessions == (len(list((ROOT / "config/faults").glob("*.yaml"))) if IS_LONG else len(SHORT))
    assert crossings > 0 and late <= 1, done.stdout


@pytest.fixture(name="first", scope="module")
def first_of_two(tmp_path_factory):
    """The session of the first short scenario and seed 1."""
    return digest(tmp_path_factory.mktemp("first") / "1", SHORT[0], 1)


def digest(folder, name, seed):
    subprocess.run([SIMULATE, "--hazard", name, "--homing", "quick", "--seed", str(seed), "--seconds", str(SECONDS),
                    "--output", folder], check=True, capture_output=True)
    log = hashlib.sha256((folder / "session.rlog").read_bytes()).hexdigest()
    return log + hashlib.sha256((folder / "faults.json").read_bytes()).hexdigest()


@pytest.mark.parametrize("name", scenarios())
def test_the_same_seed_is_the_same_session(name, first, tmp_path):
    digests = {digest(tmp_path / str(i), name, 1) for i in range(3 if IS_LONG else 1 if name == SHORT[0] else 2)}
    if name == SHORT[0]:
        digests.add(first)
    assert len(digests) == 1


def test_another_seed_is_another_session(first, tmp_path):
    assert digest(tmp_path / "2", SHORT[0], 2) != first
