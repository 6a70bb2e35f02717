"""The learning examples of doc/examples, run as doc/python.md says."""
import os
import pathlib
import re
import subprocess

import pytest

from test_data_sets import ROOT, installed

GYMNASIUM = "gymnasium==1.4.0"
LEARNERS = {"learn_reach.py": ("cma==4.5.0", 95, 100), "clone_pick_ring.py": ("scikit-learn==1.9.1", 30, 50)}
MOST_SECONDS = 1200  # on two cores


@pytest.mark.parametrize("name", LEARNERS)
def test_a_learner_succeeds_with_seeds_it_has_not_seen(name, tmp_path):
    package, least, tried = LEARNERS[name]
    library = installed(tmp_path / "library", "--system-site-packages", packages=[GYMNASIUM, package])
    done = subprocess.run([library / "bin/python", ROOT / "doc/examples" / name], capture_output=True, text=True, check=False,
                          env={**os.environ, "PYTHONPATH": os.pathsep.join([str(python_path()), os.environ.get("PYTHONPATH", "")])})
    assert done.returncode == 0, done.stderr
    print(done.stdout)
    successes, of = map(int, re.search(r"success (\d+) of (\d+) unseen seeds", done.stdout).groups())
    assert of == tried and successes >= least, done.stdout
    assert int(re.findall(r"after (\d+) s", done.stdout)[-1]) <= MOST_SECONDS, done.stdout


def python_path():
    build = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build"))
    return build / "devel/lib/python3/dist-packages"
