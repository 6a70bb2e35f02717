"""README, doc/*.md and the tutorials name what there is: programs, their options, files, topics, services, arguments of launch
files, scenarios; and doc/interfaces.md names all of it. Options are those of --help where the programs are built, of the
sources else."""

import os
import pathlib
import re
import shlex
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "test/support"))
import interface_page  # noqa: E402

PROGRAMS = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build")) / "devel/lib/raven2_trainer"
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("doc/*.md"), *ROOT.glob("doc/tutorials/*.md"), ROOT / "urdf/README.md"])
TALKED = [page for page in PAGES if page.name != "CHANGELOG.md"]  # which tells of what is gone, too
# Of tools that are not ours, named alone in a text.
FOREIGN_OPTIONS = {"--array", "--constraint", "--gtest_filter", "--preset", "--build", "--test-dir", "--core"}
SEPARATORS = re.compile(r"\|\||&&|[|;&()]|\$\(")
# Options whose value is the name of a file of config.
FOLDERS = {"exercise": "exercises", "drill": "faults", "hazard": "faults", "impair": "impairments", "curriculum": "curricula",
           "profile": "impairments", "back-profile": "impairments"}
NO_FILE = {"none", "own"}


def sources(pattern):
    return "\n".join(path.read_text(encoding="utf-8") for path in sorted(ROOT.glob(pattern)))


def programs():
    """In C++, by CMakeLists.txt."""
    return set(re.findall(r"^raven2_program\((\w+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"), re.M))


def scripts():
    return {path.name for path in (ROOT / "scripts").iterdir() if path.is_file() and os.access(path, os.X_OK)}


def options_of(program, cache={}):
    """Of a program or script, from what it tells of itself."""
    if program not in cache:
        if program in scripts():
            text = (ROOT / "scripts" / program).read_text(encoding="utf-8") + " --help"
        elif (PROGRAMS / program).exists():
            text = subprocess.run([PROGRAMS / program, "--help"], capture_output=True, text=True, check=True).stdout
        else:
            text = sources(f"src/apps/{program}.cpp") + sources("src/apps/common/*.cpp") + " --help --version"
        cache[program] = set(re.findall(r"--[a-z][a-z0-9-]*", text)) | {"--help", "--version"}
    return cache[program]


def pieces(page):
    """[(line, text)]: each line of a fenced block, lines that end in a backslash with the next; each code span."""
    inside, begun = False, ""
    for number, line in enumerate(page.read_text(encoding="utf-8").split("\n"), 1):
        if re.match(r" *```", line):
            inside = not inside
        elif inside:
            begun += line.removesuffix("\\")
            if not line.endswith("\\"):
                yield number, begun
                begun = ""
        else:
            for span in re.findall(r"`([^`]+)`", line):
                yield number, span


def words(command):
    try:
        return shlex.split(command, comments=True)
    except ValueError:  # a quotation that goes on in the next line, an apostrophe
        return command.split()


def commands(page):
    """[(line, program, [word])] of our programs and scripts, wherever they are typed."""
    ours = programs() | scripts()
    for number, text in pieces(page):
        for part in SEPARATORS.split(text):
            typed = words(part.replace("[", " ").replace("]", " "))
            while typed and ("=" in typed[0] or typed[0] in ("timeout", "rosrun", "raven2_trainer", "sudo") or
                             typed[0].isdigit()):
                typed = typed[1:]
            if typed and typed[0].split("/")[-1] in ours and not typed[0].startswith("/"):
                yield number, typed[0].split("/")[-1], typed[1:]


def place(page, number):
    return f"{page.relative_to(ROOT)}:{number}"


def test_options_of_programs_are_there():
    wrong = [f"{place(page, number)}: {program} has no {word}" for page in TALKED for number, program, rest in commands(page)
             for word in re.findall(r"(?<![\w-])--[a-z][a-z0-9-]*", " ".join(rest)) if word not in options_of(program)]
    assert wrong == []


def test_options_that_are_named_alone_are_somebodys():
    known = set().union(*(options_of(each) for each in programs() | scripts())) | FOREIGN_OPTIONS
    wrong = [f"{place(page, number)}: {text}" for page in TALKED for number, text in pieces(page)
             if text.startswith("--") and not set(re.findall(r"^--[a-z0-9_-]+", text)) <= known]
    assert wrong == []


def test_programs_that_are_run_are_there():
    ours = programs() | scripts()
    wrong = [f"{place(page, number)}: {name}" for page in TALKED for number, text in pieces(page)
             for name in re.findall(r"rosrun raven2_trainer ([a-z][\w.]*)", text) if name not in ours]
    assert wrong == []


def test_scenarios_and_exercises_that_are_asked_for_are_there():
    wrong = []
    for page in TALKED:
        for number, text in pieces(page):
            for option, name in re.findall(r"(?:--)?\b(" + "|".join(FOLDERS) + r")(?: |:=)([a-z][a-z0-9_]*)\b", text):
                folder = ROOT / "config" / FOLDERS[option]
                if name not in NO_FILE and not (folder / f"{name}.yaml").exists() and f"--{option}" in text:
                    wrong.append(f"{place(page, number)}: {option} {name}")
    assert wrong == []


def test_arguments_of_launch_files_are_there():
    wrong = []
    for page in TALKED:
        for number, text in pieces(page):
            match = re.search(r"roslaunch raven2_trainer (\w+\.launch)([^#]*)", text)
            if match:
                path = ROOT / "launch" / match.group(1)
                known = set(re.findall(r'<arg name="(\w+)"', path.read_text(encoding="utf-8"))) if path.exists() else set()
                wrong += [f"{place(page, number)}: {path.name} {name}" for name in re.findall(r"(\w+):=", match.group(2))
                          if name not in known]
                wrong += [] if path.exists() else [f"{place(page, number)}: {path.name}"]
    assert wrong == []


def test_files_that_are_named_are_there():
    """Paths in the source tree; those with a placeholder in capitals, a star or braces are patterns."""
    begins = re.compile(r"^(config|scripts|launch|urdf|meshes|doc|include|src|test)/[\w./-]+$")
    wrong = [f"{place(page, number)}: {text}" for page in TALKED for number, text in pieces(page)
             for path in [text.split("#")[0].rstrip("/")]
             if begins.match(path) and not re.search(r"[A-Z]{3,}(?!\.md)", path) and not (ROOT / path).exists()]
    assert wrong == []


def known_of_ros():
    """Names on doc/interfaces.md, without leading slashes."""
    names = interface_page.names("ROS: topics of the daemon") | interface_page.names("ROS: services and the action of the daemon")
    names |= interface_page.names("ROS: other programs", 1)
    text = interface_page.section("ROS: topics of the daemon") + interface_page.section("ROS: services and the action of the daemon")
    return names | set(re.findall(r"(?:Heard: |, )`([\w/]+)` \(", text)) | set(re.findall(r"Action `(\w+)`", text))


def test_topics_and_services_that_are_called_are_there():
    used = re.compile(r"\b(?:rosservice (?:call|type|info)|rostopic (?:echo|hz|info|pub|type))((?: -+\w+(?: \d+)?)*) (/?[a-z][\w/]*)")
    wrong = [f"{place(page, number)}: {name}" for page in TALKED for number, text in pieces(page)
             for _, name in used.findall(text) if not interface_page.has(known_of_ros(), name)]
    assert wrong == []


def offered():
    """Topics and services by the sources of the module ros."""
    text = sources("src/ros/*.cpp")
    names = set(re.findall(r'(?:advertise<[^>]+>|advertiseService|subscribe(?:<[^>]+>)?)\(\s*"([^"]+)"', text))
    names |= {f"{arm}{rest}" for arm in ("gold", "green")
              for rest in re.findall(r'name\(arm\)\) \+ "(/\w+)"', text)}
    stereo = (ROOT / "src/ros/stereo_view.cpp").read_text(encoding="utf-8")
    names |= {f"camera/{side}{rest}" for side in ("left", "right") for rest in re.findall(r'topic \+ "(/[\w/]+)"', stereo)}
    kinds = (ROOT / "src/ros/training_services.cpp").read_text(encoding="utf-8")
    for block in re.findall(r"for \(const RequestKind kind :\s*\{([^}]*)\}\)\s*offer", kinds):
        names |= {re.sub(r"(?<!^)([A-Z])", r"_\1", kind).lower() for kind in re.findall(r"RequestKind::k(\w+)", block)}
    return names


def test_the_page_of_interfaces_names_what_is_offered():
    found = offered()
    assert {"start_hazard", "clear_stop", "gold/tool_change", "camera/left/camera_info", "/diagnostics"} <= found
    assert interface_page.unknown(known_of_ros(), found) == []


def test_the_page_of_interfaces_names_every_program():
    named = interface_page.names("Programs")
    assert programs() <= named
    assert {name for name in named if "/" not in name and "." not in name and "-" not in name} <= programs()
    installed = re.findall(r"scripts/(\w+(?:\.sbatch)?)(?= |\n|$|\))", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"))
    text = interface_page.section("Programs")
    assert [name for name in installed if (ROOT / "scripts" / name).is_file() and f"`{name}`" not in text] == []


def test_the_page_of_interfaces_names_every_environment_variable():
    shipped = sources("src/**/*.cpp") + sources("test/**/*.py") + sources("test/**/*.h") + "\n".join(
        (ROOT / "scripts" / name).read_text(encoding="utf-8") for name in scripts())
    read = set(re.findall(r"\bRAVEN2_(?:TRAINER|RUN|USB)_[A-Z_]+\b(?=\"|\'|:|\})", shipped)) - {"RAVEN2_TRAINER_SOURCE_DIR"}
    read |= set(re.findall(r'(?:getenv|environment)\("([A-Z_]+)"', sources("src/**/*.cpp")))
    assert {"RAVEN2_TRAINER_SHARE", "ROS_IP", "DISPLAY"} <= read
    assert sorted(read - interface_page.names("Environment variables")) == []


def test_the_readme_and_the_page_of_interfaces_agree():
    """Types of topics and services that both name."""
    def types(rows):
        return {name: cells[1].split(" ")[0].rstrip(";,") for cells in rows if len(cells) > 1
                for name in re.findall(r"`([^`]+)`", cells[0]) if "/" in cells[1]}
    readme = [[cell.strip() for cell in line.split("|")[1:-1]]
              for line in (ROOT / "README.md").read_text(encoding="utf-8").split("\n") if line.startswith("| `")]
    ours = types(interface_page.rows("ROS: topics of the daemon") + interface_page.rows("ROS: services and the action of the daemon"))
    theirs = types(readme)
    both = set(ours) & set(theirs)
    assert len(both) > 30
    assert {name: (ours[name], theirs[name]) for name in both if ours[name] != theirs[name]} == {}


@pytest.mark.parametrize("program", sorted(programs()))
def test_every_program_is_found_where_options_are_looked_up(program):
    assert len(options_of(program)) > 2 or program in ("fault_variables", "make_key", "recover_session")
