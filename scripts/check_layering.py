#!/usr/bin/python3
"""Checks who includes whom: the layers of doc/architecture.md, read from the #include lines.

Exits 1 and names file, line and rule for every include that a module may not have. --junit FILE writes the result as
JUnit XML for the test summary.
"""
import argparse
import pathlib
import re
import sys
from xml.sax.saxutils import escape

ROOT = pathlib.Path(__file__).resolve().parent.parent

# module: (modules of ours it may include, foreign headers it may include)
PURE = r"Eigen/"
RULES = {
    "core": ([], None),
    "kinematics": (["core"], PURE),
    "control": (["core", "kinematics"], PURE),
    "haptics": (["core"], PURE),
    "faults": (["core"], None),
    "detector": (["core", "kinematics"], PURE),
    "wire": (["core"], r"zlib\.h|sodium\.h"),
    "impair": (["core"], None),
    "config": (["core", "kinematics", "control", "haptics", "faults", "detector", "wire", "impair", "model", "net", "session",
                "raven", "console", "physics", "training", "planning", "render", "threads", "loop"], r"yaml-cpp/"),
    "model": (["core", "kinematics"], PURE + r"|urdf_|urdf_model/|urdf_parser/|assimp/|tinyxml|console_bridge/"),
    "net": (["core", "wire"], r"sys/|arpa/|netinet/|netdb\.h|fcntl\.h|unistd\.h|poll\.h|sodium\.h"),
    "session": (["core"], r"zlib\.h|zstd\.h|nlohmann/|sys/|fcntl\.h|unistd\.h"),
    "raven": (["core", "kinematics", "control", "faults", "detector", "wire"], PURE),
    "preload": (["core", "config", "faults", "wire", "raven"],
                r"nlohmann/|sys/|netinet/|dlfcn\.h|fcntl\.h|poll\.h|pthread\.h|time\.h|unistd\.h"),
    "console": (["core", "kinematics", "control", "haptics", "wire"], PURE),
    "physics": (["core", "kinematics", "control", "model"], PURE + r"|ode/"),
    "plant": (["core", "kinematics", "model", "raven", "physics"], PURE),
    "training": (["core", "kinematics", "haptics", "model", "session"],
                 PURE + r"|nlohmann/|sys/file\.h|fcntl\.h|unistd\.h"),
    "planning": (["core", "kinematics", "control", "model", "physics"], PURE + r"|ompl/|fcl/|emmintrin\.h"),
    "render": (["core", "kinematics", "control", "haptics", "model", "session", "training"],
               PURE + r"|GL/|dlfcn\.h|sys/|unistd\.h|fcntl\.h|sched\.h|signal\.h|spawn\.h|poll\.h"),
    "loop": (["core", "kinematics", "control", "haptics", "faults", "wire", "impair", "model", "physics", "planning",
              "training"], PURE),
    "threads": (["core", "net"],
                r"pthread\.h|semaphore\.h|sched\.h|malloc\.h|linux/capability\.h|sys/|unistd\.h|time\.h"),
    "recording": (["core", "control", "config", "loop", "model", "planning", "raven", "session", "training", "render"],
                  PURE + r"|link\.h|nlohmann/"),
    "lockstep": (["core", "config", "wire", "impair", "model", "session", "raven", "console", "plant", "loop", "recording"], PURE),
    "robot": (["core", "config", "wire", "model", "net", "raven", "plant", "threads"], PURE),
    "daemon": (["core", "config", "wire", "model", "net", "session", "console", "physics", "render", "loop", "threads", "recording"],
               PURE),
    "studies": (["core", "config", "kinematics", "control", "detector", "wire", "model", "session", "raven", "console", "physics",
                 "plant", "planning", "loop", "recording", "lockstep"], PURE + r"|sys/wait\.h|unistd\.h"),
    "proxy": (["core", "wire", "impair", "net"], None),
    "campaign": (["core", "kinematics", "config", "session", "console", "lockstep"],
                 PURE + r"|nlohmann/|sys/|fcntl\.h|unistd\.h|poll\.h"),
    "ros": (["core", "kinematics", "control", "wire", "config", "console", "faults", "model", "net", "render", "session",
             "raven", "loop", "threads", "robot", "daemon"],
            PURE + r"|ros/|actionlib/|xmlrpcpp/|topic_tools/|boost/array\.hpp|netdb\.h|poll\.h|sys/socket\.h|unistd\.h|turbojpeg\.h|[a-z0-9_]+_msgs/|std_srvs/|raven2_trainer/(BeginReplay|CancelPlan|ExecutePlan|MoveArm[A-Z][a-z]+|Exercise(EventStamped|Progress)|Plan(Path|Execution|ning(Mode|Progress))|RepeatTrial|SessionConfiguration|StartHazard|TrainerMode)\.h"),
    "python": (["core", "kinematics", "control", "config", "model", "session", "console", "physics", "planning", "render", "loop", "recording",
                "lockstep"], PURE + r"|ode/|pthread\.h|pybind11/|sys/(mman|types)\.h|unistd\.h"),
    "apps": (None, None),  # anything
}
# System headers that the modules of the 1 kHz ticks must not reach, neither through a header of ours nor through the
# source that belongs to it: clocks, threads, files, sockets, ROS. ODE is known to physics' sources alone.
PURE_MODULES = {"core", "kinematics", "control", "haptics", "faults", "detector", "wire", "impair", "raven", "loop", "physics"}
# Includes of code that no tick runs.
EXCUSED = {
    "src/model/mesh.cpp": ("filesystem", "fstream"),  # reads the meshes, at set-up
    "src/model/raven_model.cpp": ("sstream",),        # messages of set-up
    "src/physics/ode_runtime.cpp": ("mutex", "cstdio"),  # starts ODE, once, and makes its messages texts
    "src/physics/ode_world.cpp": ("mutex",),          # in the destructor, after a step that was cut off
}
OTHER_THREADS = {"include/raven2_trainer/planning/path_planner.h"}  # plans in the planner's thread: its source may wait
IMPURE = re.compile(r"(chrono|thread|mutex|shared_mutex|condition_variable|future|fstream|filesystem|iostream|istream|ostream|sstream|ios|ctime|csignal|semaphore|latch|barrier|stop_token|cstdio|random)$"
                    r"|(pthread|semaphore|sched|time|signal|unistd|fcntl|poll|netdb|dlfcn|stdio)\.h$"
                    r"|(sys|linux|arpa|net|netinet|ros|ode)/")

# All of the configuration is seen where a whole is put together, and nowhere else.
WHOLE = "raven2_trainer/config/trainer_config.h"
ROOTS = re.compile(r"(include/raven2_trainer|src)/(config|daemon|lockstep|robot|recording|studies|campaign|python|apps)/"
                   r"|src/ros/bridge/|include/raven2_trainer/ros/session_replay\.h")

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
OTHER_INCLUDE = re.compile(r"^\s*#\s*(include|import|include_next)\b")


def violations(module, path):
    allowed, foreign = RULES[module]
    if allowed is None:
        return
    for number, header, quoted in includes(path):
        if header is None:
            yield f"{path.relative_to(ROOT)}:{number}: an include that this check cannot read"
            continue
        if quoted and (path.parent / header).is_file():  # a private header next to its source, or another module's
            header = whole_path((path.parent / header).resolve())
            if header.startswith(module + "/"):
                continue
        reason = judge(module, header, quoted, allowed, foreign)
        if reason:
            yield f"{path.relative_to(ROOT)}:{number}: {header}: {reason}"


def whole_path(path):
    """As an include of any file names it."""
    folder = "include" if path.is_relative_to(ROOT / "include") else "src"
    return str(path.relative_to(ROOT / folder))


def judge(module, header, quoted, allowed, foreign):
    if foreign and re.match(foreign, header):
        return None
    public = re.match(r"raven2_trainer/([a-z]+)/", header)
    private = re.match(r"([a-z]+)/", header) if quoted and not public else None
    if public or private:
        used = (public or private).group(1)
        if used != module and used not in allowed:
            return f"{module} may not include {used}"
        return None if public or used == module else f"a private header of {used}"
    if quoted:
        return "use the full path of the header"
    is_standard = re.fullmatch(r"[a-z_]+", header) is not None
    return None if is_standard else f"{module} may not include this"


def includes(path):
    for number, line in enumerate(path.read_text().splitlines(), 1):
        match = INCLUDE.match(line)
        if match:
            yield number, match.group(2), match.group(1) == '"'
        elif OTHER_INCLUDE.match(line):
            yield number, None, False


def resolved(path, header):
    found = [folder / header for folder in (path.parent, ROOT / "include", ROOT / "src") if (folder / header).is_file()]
    return found[0].resolve() if found else None


def seen_whole(files):
    """Lists files that see all of the configuration, also through other headers, and put no whole together."""
    sees = {(ROOT / "include" / WHOLE).resolve(): 1}  # file: line of the include
    ours = {path: {resolved(path, header): number for number, header, quoted in includes(path) if header and quoted}
            for path in (path.resolve() for _, path in files)}
    while True:
        more = {path: number for path, headers in ours.items() if path not in sees
                for header, number in headers.items() if header in sees}
        if not more:
            break
        sees.update(more)
    for path, number in sorted(sees.items()):
        name = str(path.relative_to(ROOT.resolve()))
        if not ROOTS.match(name):
            yield f"{name}:{number}: {WHOLE}: no composition root"


def source_of(path):
    """The source that defines what a header of ours declares, or None."""
    found = (ROOT / "src" / whole_path(path).removeprefix("raven2_trainer/")).with_suffix(".cpp")
    return found.resolve() if path.suffix == ".h" and found.is_file() else None


def impurities(files):
    """Lists forbidden headers that pure modules reach through our headers, and through the sources of those headers."""
    queue = sorted(path.resolve() for module, path in files if module in PURE_MODULES)
    root, why = ROOT.resolve(), {path: f"of {path.parent.name}" for path in queue}
    while queue:
        path = queue.pop()
        name = str(path.relative_to(root))
        for number, header, quoted in includes(path):
            ours = resolved(path, header) if header and quoted else None
            if ours:
                meet(ours, name, why, queue)
            elif header and IMPURE.match(header) and not is_excused(name, header):
                yield f"{name}:{number}: {header}: no threads, clocks, files or sockets here, {why[path]}"
        source = None if name in OTHER_THREADS else source_of(path)
        if source:
            meet(source, name, why, queue)


def meet(path, name, why, queue):
    if path not in why:
        why[path] = f"reached by {name}"
        queue.append(path)


def is_excused(name, header):
    return header in EXCUSED.get(name, ()) or (name.startswith("src/physics/") and header.startswith("ode/"))


def sources():
    for base in ("include/raven2_trainer", "src"):
        for module in sorted(RULES):
            for path in sorted((ROOT / base / module).rglob("*")):
                if path.suffix in (".h", ".cpp"):
                    yield module, path


def write_junit(file, count, found):
    text = "\n".join(found)
    body = f"<failure>{escape(text)}</failure>" if found else ""
    pathlib.Path(file).write_text(
        f'<testsuite name="layering" tests="1" failures="{1 if found else 0}">'
        f'<testcase name="includes_of_{count}_files" classname="layering">{body}</testcase></testsuite>\n')


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--junit", metavar="FILE", help="write the result as JUnit XML")
    args = parser.parse_args()
    files = list(sources())
    found = [line for module, path in files for line in violations(module, path)] + list(impurities(files)) + list(seen_whole(files))
    found += [f"src/{folder.name}: has no rule" for folder in (ROOT / "src").iterdir() if folder.is_dir() and folder.name not in RULES]
    print("\n".join(found) if found else f"{len(files)} files keep the layers")
    if not files:
        found = ["no files found"]
    if args.junit:
        write_junit(args.junit, len(files), found)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
