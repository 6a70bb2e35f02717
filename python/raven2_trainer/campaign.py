"""Campaigns of fault injections from Python: the program run_campaign, and its table (doc/campaign.md)."""

import csv
import json
import os
import pathlib
import subprocess
import tempfile

from .plain import as_plain, whole_number

ERROR = "raven2_trainer: "  # begins the last line of a program that refused
HELP = "Run with --help for more information."  # follows what is wrong with an option
PROGRAM = pathlib.Path(__file__).parents[3] / "raven2_trainer/run_campaign"


class Campaign:
    """A grid of injections: a name of config/campaigns, the path of a file, or a dict with the keys of such a file."""

    def __init__(self, definition):
        if not isinstance(definition, (str, os.PathLike, dict)):
            raise TypeError(f"campaign is {definition!r}, expected a name, a path or a dict")
        if isinstance(definition, dict) and not isinstance(definition.get("name"), str):
            raise ValueError("the campaign has no name")
        self.definition = definition

    def run(self, output, seed=1, jobs=None, resume=False):
        """Runs it on `jobs` processors (None: all). @return its outcomes, a list of rows.

        A fault that never acted, a run without an outcome, or an outcome that is neither published nor explained is no error here:
        see the rows. RuntimeError has the program's text for what is wrong with the campaign itself.
        """
        output = pathlib.Path(output)
        seed = whole_number("seed", seed, 0, 2**64 - 1)
        with tempfile.TemporaryDirectory(prefix="raven2_campaign_") as folder:
            command = [PROGRAM, self._file(folder), "--output", output, "--seed", str(seed), "--jobs",
                       str(len(os.sched_getaffinity(0)) if jobs is None else whole_number("jobs", jobs)), *(["--resume"] if resume else [])]
            done = subprocess.run(command, capture_output=True, text=True, check=False)
        said = done.stderr.strip().splitlines() or [f"run_campaign ended with {done.returncode}"]
        is_refused = done.returncode not in (0, 1) or said[-1].startswith(ERROR)
        if is_refused or not (output / "outcomes.csv").exists():
            said = [line for line in said if line != HELP] or said
            raise RuntimeError(said[-1].removeprefix(ERROR))
        return outcomes(output)

    def _file(self, folder):
        """A dict is written to a file in `folder`."""
        if not isinstance(self.definition, dict):
            return os.fspath(self.definition)
        path = pathlib.Path(folder) / "campaign.yaml"
        path.write_text(json.dumps(self.definition, indent=1, default=as_plain), encoding="utf-8")  # JSON is YAML
        return os.fspath(path)


def outcomes(directory):
    """The rows of outcomes.csv: dicts by column; numbers as numbers, empty cells as None."""
    with open(pathlib.Path(directory) / "outcomes.csv", encoding="utf-8", newline="") as file:
        return [{key: _value(text) for key, text in row.items()} for row in csv.DictReader(file)]


def _value(text):
    if text == "":
        return None
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
