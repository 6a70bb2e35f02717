"""The tutorials of doc/tutorials as programs: their commands in order, and what each promises.

A fenced block below the line `<!-- run -->` is run, in one shell with all others of its page; `<!-- run: 300 s -->` gives it
so long (60 s without). The paragraph `Expected: ...;` below it says what must come of it: `output X` (X stands in what the
block printed), `file X` (X is there and not empty), `exit code N` (of the last command that failed; 0 unless said)."""

import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build"))
PAGES = sorted((ROOT / "doc/tutorials").glob("*.md"))
MARK = re.compile(r"<!-- run(?:: (\d+) s)? -->")
PORTS = (36000, 36001, 36002, 36010, 36100)  # config/network.yaml, named in tutorials and launch files
USUAL_TIME = 60.0


class Block:
    """Commands that are run together. line: of the fence, for messages."""

    def __init__(self, page, line, seconds, text):
        self.page, self.line, self.seconds, self.text = page, line, seconds, text
        self.outputs, self.files, self.code, self.promises = [], [], 0, 0

    def place(self):
        return f"{self.page.relative_to(ROOT)}:{self.line}"

    def expect(self, clause):
        """One clause of `Expected:`. Raises ValueError for one that cannot be checked."""
        match = re.fullmatch(r"output `(.+)`|file `(\S+)`|exit code (\d+)", clause)
        if not match:
            raise ValueError(f"{self.place()}: \"{clause}\" is none of: output `X`, file `X`, exit code N")
        self.promises += 1
        output, file, code = match.groups()
        self.outputs += [output] if output else []
        self.files += [file] if file else []
        self.code = int(code) if code else self.code


def fenced(lines, start):
    """(text, index behind it) of the fenced bash block at `start`."""
    if lines[start] != "```bash":
        raise ValueError(f"line {start + 1}: <!-- run --> stands above no bash block")
    end = lines.index("```", start)
    return "\n".join(lines[start + 1:end]) + "\n", end + 1


def clauses(lines, start):
    """Of the paragraph `Expected: ...` that begins at most one empty line below `start`; [] without one."""
    while start < len(lines) and not lines[start]:
        start += 1
    paragraph = []
    while start < len(lines) and lines[start]:
        paragraph.append(lines[start])
        start += 1
    text = " ".join(paragraph)
    if not text.startswith("Expected: "):
        return []
    return text[len("Expected: "):].rstrip(".").split("; ")


def blocks(page):
    """All that is to be run of a page, in order."""
    lines, found = page.read_text(encoding="utf-8").split("\n"), []
    for i, line in enumerate(lines):
        mark = MARK.fullmatch(line)
        if not mark:
            continue
        text, behind = fenced(lines, i + 1)
        block = Block(page, i + 2, float(mark.group(1) or USUAL_TIME), text)
        for clause in clauses(lines, behind):
            block.expect(clause)
        found.append(block)
    return found


def free_ports(count):
    """For UDP and TCP alike, below the range from which the system takes those of outgoing connections."""
    held, ports = [], []
    for port in range(20000 + os.getpid() % 5000, 32000):
        pair = socket.socket(), socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        held += pair
        try:
            for each in pair:
                each.bind(("127.0.0.1", port))
        except OSError:
            continue
        ports.append(port)
        if len(ports) == count:
            break
    for each in held:
        each.close()
    return ports


# Stand before ROS's own in PATH, so that what a page types meets ports that nobody else uses.
WRAPPERS = {
    "roscore": 'exec /usr/bin/roscore -p {master} "$@"',
    "roslaunch": 'exec /usr/bin/roslaunch "$@" robot_port:={robot} force_port:={force} sight_port:={sight} '
                 'master_port:={hands} state_port:={state}',
}


class Shell:
    """A shell in a folder of its own, beside which nobody uses its ports. Use as a context manager."""

    def __init__(self, folder):
        self.folder, self.log = folder / "work", folder / "log"
        for each in (self.folder, self.log):
            each.mkdir()
        for name, target in (("build", BUILD), ("scripts", ROOT / "scripts")):
            (self.folder / name).symlink_to(target)
        *numbers, self.master = free_ports(len(PORTS) + 1)
        self.ports = dict(zip(PORTS, numbers))
        self._share = self._copy_share(folder / "share")
        self._write_wrappers(folder / "bin")
        self.count = 0

    def _write_wrappers(self, target):
        target.mkdir()
        names = dict(zip(("robot", "force", "sight", "hands", "state"), (self.ports[port] for port in PORTS)))
        for name, text in WRAPPERS.items():
            (target / name).write_text("#!/bin/sh\n" + text.format(master=self.master, **names) + "\n", encoding="utf-8")
            (target / name).chmod(0o755)
        self._path = f"{target}:{os.environ.get('PATH', os.defpath)}"

    def _copy_share(self, target):
        for entry in ("config", "urdf", "meshes"):
            shutil.copytree(ROOT / entry, target / entry)
        network = target / "config/network.yaml"
        network.write_text(self.with_own_ports(network.read_text(encoding="utf-8")), encoding="utf-8")
        return target

    def with_own_ports(self, text):
        return re.sub(r"\b36\d{3}\b", lambda match: str(self.ports.get(int(match.group()), match.group())), text)

    def __enter__(self):
        home = self.log / "home"
        home.mkdir()
        environment = dict(os.environ, PATH=self._path, HOME=str(home), TMPDIR=str(self.folder), ROS_HOME=str(home),
                           ROS_LOG_DIR=str(home), ROS_IP="127.0.0.1",
                           ROS_MASTER_URI=f"http://127.0.0.1:{self.master}", RAVEN2_TRAINER_SHARE=str(self._share))
        self._bash = subprocess.Popen(["bash"], stdin=subprocess.PIPE, text=True, cwd=self.folder, env=environment,
                                      start_new_session=True)
        self._type("trap 'code=$?' ERR")  # of the last command that failed
        return self

    def _type(self, text):
        self._bash.stdin.write(text + "\n")
        self._bash.stdin.flush()

    def run(self, block):
        """(exit code, output, the folder it is in then). Raises TimeoutError."""
        self.count += 1
        base = self.log / str(self.count)
        base.with_suffix(".sh").write_text(self.with_own_ports(block.text), encoding="utf-8")
        self._type(f"code=0; source {base}.sh > {base}.out 2>&1 < /dev/null; "
                   f"pwd > {base}.pwd; echo $code > {base}.new; mv {base}.new {base}.code")
        end = time.monotonic() + block.seconds
        while not base.with_suffix(".code").exists():
            if time.monotonic() > end or self._bash.poll() is not None:
                raise TimeoutError(f"{block.place()}: not within {block.seconds:g} s; it printed:\n" + read(base))
            time.sleep(0.05)
        folder = base.with_suffix(".pwd").read_text(encoding="utf-8").rstrip("\n")
        return int(base.with_suffix(".code").read_text()), read(base), pathlib.Path(folder)

    def _is_alive(self):
        """Whether the shell, or what it started in the background, still runs."""
        self._bash.poll()
        try:
            os.killpg(self._bash.pid, 0)
        except ProcessLookupError:
            return False
        return True

    def __exit__(self, *_):
        for sign, seconds in ((signal.SIGTERM, 20.0), (signal.SIGKILL, 5.0)):
            end = time.monotonic() + seconds
            if self._is_alive():
                os.killpg(self._bash.pid, sign)
            while self._is_alive() and time.monotonic() < end:
                time.sleep(0.02)
        self._bash.stdin.close()


def read(base):
    return base.with_suffix(".out").read_text(encoding="utf-8", errors="replace")


def check(block, code, output, folder):
    """Raises AssertionError, with what was printed."""
    told = f"{block.place()}: {{}}; it printed:\n{output[-4000:]}"
    assert code == block.code, told.format(f"exit code {code}, expected {block.code}")
    for text in block.outputs:
        assert text in output, told.format(f"no \"{text}\" in the output")
    for name in block.files:
        path = folder / name
        assert path.is_file() and path.stat().st_size > 0, told.format(f"no {name}, or nothing in it")


def run(page, folder):
    with Shell(folder) as shell:
        for block in blocks(page):
            check(block, *shell.run(block))
