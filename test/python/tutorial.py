"""README and the pages of doc as programs: their commands in order, and the results that each block promises.

A block of bash or Python below the line `<!-- run -->` is run. All blocks of a page share one shell. The time limit is
60 s; `<!-- run: 300 s -->` sets another one. The paragraph `Expected: ...;` below the block lists the results. It may
be a comment. Its clauses are `output X` (the block prints X), `file X` (X exists and is not empty), and `exit code N`
or `N or M` (of the last command that failed; 0 unless given). A line `<!-- with: NAME -->` ends the shell. The next
blocks run in a new shell, in a new folder, after the commands of `BESIDE[NAME]`.

A block that is not run has the line `<!-- not run: REASON -->` above it, with one of REASONS."""

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
TUTORIALS = sorted((ROOT / "doc/tutorials").glob("*.md"))
PAGES = [*TUTORIALS, ROOT / "README.md", *sorted((ROOT / "doc").glob("*.md"))]
MARK = re.compile(r"<!-- run(?:: (\d+) s)? -->")
WITH = re.compile(r"<!-- with: (.+) -->")
NOT_RUN = re.compile(r"<!-- not run: (.+) -->")
REASONS = ("needs a real robot", "needs hardware that is not there", "needs recordings that are not shipped",
           "needs a package that is not in Debian", "needs a window with OpenGL", "changes the firewall", "takes hours",
           "runs this page itself", "runs until Ctrl-C")
LANGUAGES = ("bash", "python")
# Lines of a page that a reader types. They must be in blocks of bash.
COMMAND = re.compile(r" *(?:sudo |(?:ros(?:run|launch|service|topic|bag|param|test|core)|scripts/\w+|nft|cmake|podman)\b)")
TERMINAL = "source build/devel/setup.bash\n"
LIVE = TERMINAL + """(roslaunch raven2_trainer training.launch hazard:=none console:=false output:=$PWD/live > roslaunch.log 2>&1 &)
until rostopic echo -n 1 /diagnostics 2> /dev/null | grep -q 'raven2_trainer: robot'; do sleep 0.5; done
until rostopic echo -n 1 /robot/joint_states > /dev/null 2>&1; do sleep 0.5; done
"""
# Commands that run before a page's own; no reader types them. Subshells keep their jobs apart from the page's `wait`.
BESIDE = {
    "a terminal": TERMINAL,
    "a session": TERMINAL + "rosrun raven2_trainer simulate --seconds 2 --seed 1 --homing quick --output DIR\n",
    "the daemon": LIVE,
    "a ROS master": TERMINAL + "(roscore > roscore.log 2>&1 &)\nuntil rostopic list > /dev/null 2>&1; do sleep 0.2; done\n"
                               "rosrun raven2_trainer simulate --seconds 2 --seed 1 --homing quick --output DIR\n",
    "a display": "(Xvfb -displayfd 3 -screen 0 1400x900x24 -nolisten tcp 3> display 2> /dev/null &)\n"
                 "until [ -s display ]; do sleep 0.1; done; export DISPLAY=:$(cat display)\n",
    # Debian has no crtk_msgs. The client's two messages are made from their published text.
    "the daemon and crtk_msgs": LIVE + f"""mkdir -p python/crtk_msgs && touch python/crtk_msgs/__init__.py
ln -s {ROOT}/test/support/crtk_messages.py python/crtk_msgs/msg.py
export PYTHONPATH=$PWD/python:$PYTHONPATH
""",
}
PORTS = (36000, 36001, 26002, 36010, 26100)  # of config/network.yaml; tutorials and launch files name them
USUAL_TIME = 60.0
BEFORE_TIME = 120.0  # [s] of the commands in `BESIDE`


class Block:
    """Commands that run together. line: line of the fence, for messages; text: commands for bash."""

    def __init__(self, page, line, seconds, text):
        self.page, self.line, self.seconds, self.text = page, line, seconds, text
        self.outputs, self.files, self.codes, self.promises = [], [], {0}, 0

    def place(self):
        return f"{os.path.relpath(self.page, ROOT)}:{self.line}"

    def expect(self, clause):
        """Adds one clause of `Expected:`. Raises ValueError for a clause that cannot be checked."""
        match = re.fullmatch(r"output `(.+)`|file `(\S+)`|exit code (\d+)(?: or (\d+))?", clause)
        if not match:
            raise ValueError(f"{self.place()}: \"{clause}\" is none of: output `X`, file `X`, exit code N")
        self.promises += 1
        output, file, code, other = match.groups()
        self.outputs += [output] if output else []
        self.files += [file] if file else []
        self.codes = {int(each) for each in (code, other) if each} or self.codes


class Part:
    """Blocks of a page that share a shell. `beside` is a key of `BESIDE`, or empty."""

    def __init__(self, page, beside):
        self.page, self.beside, self.blocks = page, beside, []

    def place(self):
        return self.blocks[0].place()


def fenced(lines, start):
    """(commands for bash, index of the next line) of the fenced block at `start`."""
    language = lines[start][3:]
    if not lines[start].startswith("```") or language not in LANGUAGES:
        raise ValueError(f"line {start + 1}: <!-- run --> is above no block of {' or '.join(LANGUAGES)}")
    end = lines.index("```", start)
    text = "\n".join(lines[start + 1:end]) + "\n"
    return (f"/usr/bin/python3 - <<'END_OF_BLOCK'\n{text}END_OF_BLOCK\n" if language == "python" else text), end + 1


def clauses(lines, start):
    """Clauses of the paragraph `Expected: ...` below `start`, after empty lines at most. [] without that paragraph."""
    while start < len(lines) and not lines[start]:
        start += 1
    paragraph = []
    while start < len(lines) and lines[start]:
        paragraph.append(lines[start])
        start += 1
    text = re.sub(r"^<!-- (.*) -->$", r"\1", " ".join(paragraph))
    if not text.startswith("Expected: "):
        return []
    return text[len("Expected: "):].rstrip(".").split("; ")


def usual(page):
    """Default key of `BESIDE` for a page. Tutorials and README open their terminals themselves."""
    return "" if page in TUTORIALS or page.name == "README.md" else "a terminal"


def parts(page):
    """All parts of a page that have blocks to run, in order."""
    lines, found = page.read_text(encoding="utf-8").split("\n"), [Part(page, usual(page))]
    for i, line in enumerate(lines):
        if (beside := WITH.fullmatch(line)):
            found.append(Part(page, beside.group(1)))
        if not (mark := MARK.fullmatch(line)):
            continue
        text, behind = fenced(lines, i + 1)
        block = Block(page, i + 2, float(mark.group(1) or USUAL_TIME), text)
        for clause in clauses(lines, behind):
            block.expect(clause)
        found[-1].blocks.append(block)
    return [part for part in found if part.blocks]


def blocks(page):
    return [block for part in parts(page) for block in part.blocks]


def unmarked(name, text):
    """Complaints about commands of a page that no line marks as run or not run."""
    lines, wrong, inside = text.split("\n"), [], False
    for i, line in enumerate(lines):
        place, above = f"{name}:{i + 1}", lines[i - 1] if i else ""
        reason = NOT_RUN.fullmatch(line)
        if reason and reason.group(1) not in REASONS:
            wrong.append(f"{place}: \"{reason.group(1)}\" is no reason")
        if line.startswith("```"):
            inside = not inside and (line[3:] or "no language")
            if inside == "no language":
                wrong.append(f"{place}: a block without a language")
            if inside == "bash" and not MARK.fullmatch(above) and not NOT_RUN.fullmatch(above):
                wrong.append(f"{place}: neither <!-- run --> nor <!-- not run: REASON -->")
        elif (inside == "text" or not inside and line.startswith("    ")) and COMMAND.match(line):
            wrong.append(f"{place}: a command outside of a block of bash")
    return wrong


def free_ports(count):
    """Ports free for UDP and TCP, below the range that the system uses for outgoing connections."""
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


# Commands that come before ROS's own in PATH, so that the commands of a page use ports that nobody else uses.
WRAPPERS = {
    "roscore": 'exec /usr/bin/roscore -p {master} "$@"',
    "roslaunch": 'exec /usr/bin/roslaunch "$@" robot_port:={robot} force_port:={force} sight_port:={sight} '
                 'master_port:={hands} state_port:={state}',
}


class Shell:
    """A shell in a separate folder, with ports that nobody else uses. Use as a context manager."""

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
                           ROS_LOG_DIR=str(home), ROS_IP="127.0.0.1", PYTHONUNBUFFERED="1",  # as in a terminal
                           ROS_MASTER_URI=f"http://127.0.0.1:{self.master}", RAVEN2_TRAINER_SHARE=str(self._share))
        self._bash = subprocess.Popen(["bash"], stdin=subprocess.PIPE, text=True, cwd=self.folder, env=environment,
                                      start_new_session=True)
        self._type("trap 'code=$?' ERR")  # code of the last command that failed
        return self

    def _type(self, text):
        self._bash.stdin.write(text + "\n")
        self._bash.stdin.flush()

    def run(self, block):
        """(exit code, output, current folder afterwards). Raises TimeoutError."""
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
        """Whether the shell, or a program that it started in the background, still runs."""
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
    """Raises AssertionError with the output if the block broke a promise."""
    told = f"{block.place()}: {{}}; it printed:\n{output[-4000:]}"
    assert code in block.codes, told.format(f"exit code {code}, expected {' or '.join(map(str, sorted(block.codes)))}")
    for text in block.outputs:
        assert text in output, told.format(f"no \"{text}\" in the output")
    for name in block.files:
        path = folder / name
        assert path.is_file() and path.stat().st_size > 0, told.format(f"no {name}, or nothing in it")


def run(part, folder):
    with Shell(folder) as shell:
        if part.beside:
            before = Block(part.page, part.blocks[0].line, BEFORE_TIME, BESIDE[part.beside])
            check(before, *shell.run(before))
        for block in part.blocks:
            check(block, *shell.run(block))
