"""Lockstep sessions for scripts: simulate, run on the packaged configuration or on a changed copy of it."""

import os
import pathlib
import re
import shutil
import subprocess
import sys

import raven2_session

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent


def program(name):
    """Path of one of our programs: next to this file (installed), or in the build of the source tree."""
    build = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build"))
    return HERE / name if (HERE / name).exists() else build / "devel/lib/raven2_trainer" / name


SIMULATE = program("simulate")


class LockstepError(Exception):
    """A session did not come about, or a file is not what was to be changed; the message says which and why."""


def require_program():
    """Ends the script, with the reason, if simulate is not built."""
    if not SIMULATE.exists():
        sys.exit(f"{pathlib.Path(sys.argv[0]).name}: {SIMULATE} is not built (scripts/test or scripts/run builds it)")


def copy_of_configuration(folder):
    """The package's configuration, URDF and meshes in `folder`. @return its root file."""
    for part in ("config", "urdf", "meshes"):
        shutil.copytree(ROOT / part, folder / part)
    return folder / "config/trainer.yaml"


def replace(file, pattern, text):
    """Replaces the one place of a file that the pattern matches; there must be exactly one."""
    changed, count = re.subn(pattern, text, file.read_text())
    if count != 1:
        raise LockstepError(f"{file.name}: {count} places match {pattern}, expected 1")
    file.write_text(changed)


def set_value(folder, hazard, value):
    """Gives the one `value:` of a scenario another number, in a copy of the configuration."""
    replace(folder / "config/faults" / f"{hazard}.yaml", r"(?m)^( +value:) \S+", rf"\g<1> {value}")


def simulate(output, *options, config=ROOT / "config/trainer.yaml", may_not_start=False):
    """One session. @return it, and whether it started: whether there was a pedal-down (false needs may_not_start)."""
    done = subprocess.run([SIMULATE, "--config", config, "--output", output, *map(str, options)], capture_output=True,
                          text=True)
    lines = done.stderr.strip().splitlines() or ["no word"]
    if done.returncode not in (0, 1) or not (output / "metrics.json").exists():
        raise LockstepError(f"{' '.join(map(str, options))}: {lines[-1]}")
    if done.returncode == 1 and not may_not_start:
        raise LockstepError(f"{' '.join(map(str, options))}: {lines[-1]}")
    return raven2_session.Session(output), done.returncode == 0
