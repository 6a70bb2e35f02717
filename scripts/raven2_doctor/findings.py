"""A finding, and what a check may know of the machine that it looks at."""

import os
import pathlib
import re
import shutil
import subprocess

OK, WARN, FAIL = "OK", "WARN", "FAIL"


class Finding:
    """One line of what is, and, unless it is well, one line of what to do."""

    def __init__(self, status, what, remedy=""):
        if (status == OK) == bool(remedy) or "\n" in what + remedy or status not in (OK, WARN, FAIL):
            raise ValueError(f"{status}: {what!r}, remedy {remedy!r}")
        self.status, self.what, self.remedy = status, what, remedy


def ok(what):
    return Finding(OK, what)


def warn(what, remedy):
    return Finding(WARN, what, remedy)


def fail(what, remedy):
    return Finding(FAIL, what, remedy)


class Machine:
    """Where things are. A check reads nothing of its surroundings that is not here, /proc, /sys and the system's own
    folders apart, so that a test can give it others."""

    def __init__(self, root, build, config, environ=None):
        """`root`: the source tree, None where the package is installed. `build`: the folder that holds devel/, or None.
        `config`: the root configuration file."""
        self.root, self.build, self.config = root, build, pathlib.Path(config)
        self.environ = dict(os.environ if environ is None else environ)

    def which(self, program):
        return shutil.which(program, path=self.environ.get("PATH", ""))

    def run(self, *command, timeout=20):
        """Status and both outputs, as one text. A program that is not there, or hangs, has status 127 or 124."""
        try:
            done = subprocess.run([str(word) for word in command], env=self.environ, stdin=subprocess.DEVNULL,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=timeout, check=False)
        except subprocess.TimeoutExpired:
            return 124, f"no answer within {timeout} s"
        except OSError as error:
            return 127, str(error)
        return done.returncode, done.stdout.decode(errors="replace")

    def program(self, name):
        """Path of one of ours, or None."""
        folder = self.build / "devel/lib/raven2_trainer" if self.build else pathlib.Path(__file__).parents[1]
        path = folder / name
        return path if os.access(path, os.X_OK) and path.is_file() else None

    def section(self, key):
        """File of the configuration that `key` of the root file names."""
        return self.config.parent / text_of(self.config, key, key + ".yaml")


def text_of(path, key, default):
    """Value of a key at the beginning of a line. All that these checks need of YAML, which Debian's Python lacks until
    a package is installed."""
    found = re.search(rf"^{key}: *\"?([^\s#\"]*)", path.read_text(), re.MULTILINE)
    return found.group(1) if found else default


def last_line(text):
    lines = [line for line in text.splitlines() if line.strip()]
    return lines[-1].strip() if lines else "no output"
