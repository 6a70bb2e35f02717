"""All programs, options, files, topics, services, arguments of launch files and scenarios that README, doc/*.md and the
tutorials name exist. doc/interfaces.md names all of them. The options come from --help where the programs are built,
otherwise from the sources."""

import collections
import os
import pathlib
import re
import shlex
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "test/support"), str(ROOT / "test/system")]
import interface_page  # noqa: E402
import test_ros_master  # noqa: E402

PROGRAMS = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build")) / "devel/lib/raven2_trainer"
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("doc/*.md"), *ROOT.glob("doc/tutorials/*.md"), ROOT / "urdf/README.md"])
TALKED = [page for page in PAGES if page.name != "CHANGELOG.md"]  # CHANGELOG.md also names what was removed
# Options of tools that are not ours, named in a text without the tool.
FOREIGN_OPTIONS = {"--array", "--constraint", "--gtest_filter", "--preset", "--build", "--test-dir", "--core"}
SEPARATORS = re.compile(r"\|\||&&|[|;&()]|\$\(")
# Options whose value is the name of a file in a folder of config.
FOLDERS = {"exercise": "exercises", "drill": "faults", "hazard": "faults", "impair": "impairments", "curriculum": "curricula",
           "profile": "impairments", "back-profile": "impairments"}
NO_FILE = {"none", "own"}


def sources(pattern):
    return "\n".join(path.read_text(encoding="utf-8") for path in sorted(ROOT.glob(pattern)))


def programs():
    """Names of the C++ programs in CMakeLists.txt."""
    return set(re.findall(r"^raven2_program\((\w+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"), re.M))


def scripts():
    return {path.name for path in (ROOT / "scripts").iterdir() if path.is_file() and os.access(path, os.X_OK)}


def options_of(program, cache={}):
    """Options from a script's source, or from a program's --help or, where it is not built, its source."""
    if program not in cache:
        if program in scripts():
            text = (ROOT / "scripts" / program).read_text(encoding="utf-8") + " --help"
            text += sources(f"scripts/raven2_{program}/{program}")  # what it starts
        elif (PROGRAMS / program).exists():
            text = subprocess.run([PROGRAMS / program, "--help"], capture_output=True, text=True, check=True).stdout
        else:
            text = sources(f"src/apps/{program}.cpp") + sources("src/apps/common/*.cpp") + " --help --version"
        cache[program] = set(re.findall(r"--[a-z][a-z0-9-]*", text)) | {"--help", "--version"}
    return cache[program]


def spans(lines, first):
    """[(line, text)] of the code spans of a paragraph. A span may continue in the next line."""
    text = "\n".join(lines)
    return [(first + text.count("\n", 0, match.start()), match.group(1).replace("\n", " "))
            for match in re.finditer(r"`([^`]+)`", text)]


def pieces(page):
    """[(line, text)]: code spans, and lines of fenced blocks. A line that ends in a backslash includes the next."""
    paragraph, inside, begun = [], False, ""
    for number, line in enumerate([*page.read_text(encoding="utf-8").split("\n"), ""], 1):
        is_fence = bool(re.match(r" *```", line))
        if not inside and (is_fence or not line):
            yield from spans(paragraph, number - len(paragraph))
            paragraph = []
        elif not inside:
            paragraph.append(line)
        elif not is_fence:
            begun += line.removesuffix("\\")
            if not line.endswith("\\"):
                yield number, begun
                begun = ""
        inside = inside != is_fence


def words(command):
    try:
        return shlex.split(command, comments=True)
    except ValueError:  # a quotation that continues in the next line, or an apostrophe
        return command.split()


def commands(page):
    """[(line, program, [word])] of each command in a page that starts one of our programs or scripts."""
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
    return f"{os.path.relpath(page, ROOT)}:{number}"


def test_options_are_found():
    assert {"--seed", "--motion", "--from-log"} <= options_of("simulate") and "--camera" in options_of("render_session")
    assert "--together" in options_of("plot_paths") and "--only" in options_of("test")


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
    options = "|".join(FOLDERS)
    asked = re.compile(rf"(?:--({options})[ =]|\b({options}):=)([a-z][a-z0-9_]*)\b(?!\.yaml)")
    found = [(place(page, number), first or second, name) for page in TALKED for number, text in pieces(page)
             for first, second, name in asked.findall(text) if name not in NO_FILE]
    assert len(found) > 20, len(found)
    assert [each for each in found if not (ROOT / "config" / FOLDERS[each[1]] / f"{each[2]}.yaml").exists()] == []


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
    """Paths in the source tree; those with a placeholder (NAME, x) are patterns."""
    begins = re.compile(r"(?:config|scripts|launch|urdf|meshes|doc|include|src|test)/[\w./-]*\w")
    found = [(place(page, number), word) for page in TALKED for number, text in pieces(page)
             for word in re.split(r"[\s,;()|\"']+", text) if begins.fullmatch(word) and not re.search(r"[A-Z]{3,}(?!\.md)|_x\.", word)]
    assert len(found) > 100
    assert [each for each in found if not (ROOT / each[1]).exists()] == []


def test_keys_of_configuration_that_are_named_are_there():
    """Example: in "`live: slowest` in `config/render.yaml`", `live` must be a key of that file."""
    said = re.compile(r"`([a-z_0-9]+)(?:[:/][^`]*)?` (?:in|of|from) `(?:config/)?([a-z_]+\.yaml)`")
    found = [(page.name, *match) for page in TALKED
             for match in said.findall(page.read_text(encoding="utf-8").replace("\n", " "))]
    assert len(found) > 10
    assert [each for each in found
            if not re.search(rf"\b{each[1]}:", (ROOT / "config" / each[2]).read_text(encoding="utf-8"))] == []


def test_commands_of_promises_are_there():
    text = (ROOT / "doc/reliability.md").read_text(encoding="utf-8")
    system = set(re.findall(r"`SYS (\w+)`", text)) - {"x"}
    built = (ROOT / "test/CMakeLists.txt").read_text(encoding="utf-8")
    assert len(system) > 5 and [name for name in system if not (ROOT / f"test/system/test_{name}.py").exists()] == []
    assert [name for name in re.findall(r"`BIN (\w+)_test", text) if f"raven2_test({name} " not in built] == []


def test_sections_of_the_robot_s_facts_that_comments_cite_are_there():
    """Each number of a citation such as `raven2.md 3.1, 6.2` is a heading of doc/raven2.md."""
    headings = set(re.findall(r"^#+ (\d(?:\.\d)?) ", (ROOT / "doc/raven2.md").read_text(encoding="utf-8"), re.M))
    cited = collections.defaultdict(list)
    for folder in ("config", "doc", "include", "meshes", "scripts", "src", "test", "urdf"):
        for path in (ROOT / folder).rglob("*"):
            if path.suffix in (".cpp", ".h", ".md", ".py", ".urdf", ".yaml") and path.is_file():
                for numbers in re.findall(r"raven2\.md\"? ((?:\d(?:\.\d+)?(?:, | and )?)+)", path.read_text(encoding="utf-8")):
                    for number in re.findall(r"\d(?:\.\d+)?", numbers):
                        cited[number].append(path.name)
    assert len(cited) > 25
    assert {number: names[:3] for number, names in cited.items() if number not in headings} == {}


def test_headers_that_are_named_are_there():
    """Headers are named as in #include: core/frames.h."""
    found = [(place(page, number), text) for page in TALKED for number, text in pieces(page)
             if re.fullmatch(r"(?!include/|src/|test/)[a-z0-9_]+/[a-z0-9_]+\.h", text)]
    assert len(found) > 10
    folders = (ROOT / "include/raven2_trainer", ROOT / "src", ROOT / "include")
    assert [each for each in found if not any((folder / each[1]).exists() for folder in folders)] == []


DAEMON = ("ROS: topics of the daemon", "ROS: services and the action of the daemon")


def known_of_daemon():
    """Names on doc/interfaces.md: in the tables, after "Subscribed:", and the action."""
    names = set().union(*(interface_page.names(title) for title in DAEMON))
    topics, services = map(interface_page.section, DAEMON)
    subscribed = topics[topics.index("\nSubscribed: "):].replace("\n", " ")
    return names | set(re.findall(r"`([\w/]+)` \(sensor_msgs", subscribed)) | set(re.findall(r"\nAction `(\w+)`", services))


def known_of_ros():
    return known_of_daemon() | interface_page.names("ROS: other programs", 1)


def test_topics_and_services_that_are_called_are_there():
    used = re.compile(r"\b(?:rosservice (?:call|type|info)|rostopic (?:echo|hz|info|pub|type))((?: -+\w+(?: \d+)?)*) (/?[a-z][\w/]*)")
    wrong = [f"{place(page, number)}: {name}" for page in TALKED for number, text in pieces(page)
             for _, name in used.findall(text) if not interface_page.has(known_of_ros(), name)]
    assert wrong == []


def test_the_page_of_interfaces_names_what_the_running_daemon_has_and_nothing_else():
    """test_ros_master compares the running daemon with these lists."""
    running = test_ros_master.DAEMON_TOPICS | test_ros_master.DAEMON_HEARS | test_ros_master.DAEMON_SERVICES
    running = {name for name in running if not name.startswith(("/move_arm/", "/raven2_simulator/"))} | {"/move_arm"}
    assert interface_page.unknown(known_of_daemon(), running) == []
    assert interface_page.gone(known_of_daemon(), running) == []


def test_the_page_of_interfaces_names_topics_of_other_programs_by_their_names():
    text = sources("src/ros/*/*.cpp") + sources("src/apps/*.cpp") + sources("launch/*.launch") + sources(
        "scripts/raven2_station/*.py")
    names = interface_page.names("ROS: other programs", 1) - {"--topic"}
    assert "/ravenstate" in names and [name for name in names if f'"{name}"' not in text] == []


def test_the_page_of_interfaces_names_every_program():
    named = interface_page.names("Programs")
    assert programs() <= named
    assert {name for name in named if "/" not in name and "." not in name and "-" not in name} <= programs()


def test_the_page_of_interfaces_tells_where_a_script_is():
    """The sentence lists all installed scripts before the semicolon, and scripts of the source tree after it."""
    text = interface_page.section("Programs")
    sentence = text[text.index("\nScripts that a user starts"):text.index(" in the source tree alone")]
    installed, others = (set(re.findall(r"`([\w.]+)`", half)) for half in sentence.split(" or by `rosrun`: ")[1].split("; and "))
    listed = re.search(r"install\(PROGRAMS (.*?)DESTINATION", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"), re.S)
    assert installed == set(re.findall(r"scripts/([\w.]+)", listed.group(1)))
    assert "run" in others and others <= scripts() - installed


def test_the_page_of_interfaces_names_parameters_and_descriptions():
    parameters = set(re.findall(r'<param name="(\w+)"', sources("launch/*.launch")))
    assert parameters and parameters <= interface_page.names("ROS: other programs", 1)
    described = {f"urdf/{path.name}" for path in (ROOT / "urdf").glob("*.*df")}
    assert "urdf/raven2.srdf" in described and interface_page.unknown(interface_page.names("Files"), described) == []


def test_scripts_with_a_verdict_have_it_on_the_page_of_interfaces():
    """Exit status 1 of these installed scripts is a result, not an error."""
    told = " ".join(cells[1] for cells in interface_page.rows("Exit codes") if cells[0] == "1")
    for name in ("doctor", "campaign_report", "compare_replay"):
        assert f"`{name}`" in told, name


def test_the_page_of_interfaces_tells_where_launch_files_write():
    folders = set(re.findall(r'name="output" default="\$\(env HOME\)/(\w+)/', sources("launch/*.launch")))
    assert len(folders) == 1
    assert all(f"`~/{folder}/`" in text for folder in folders
               for text in (interface_page.section("Launch files"), (ROOT / "README.md").read_text(encoding="utf-8")))


def test_the_page_of_interfaces_names_every_launch_file():
    assert interface_page.names("Launch files") == {path.name for path in (ROOT / "launch").glob("*.launch")}


def test_the_page_of_interfaces_names_every_environment_variable():
    shipped = sources("src/**/*.cpp") + sources("test/**/*.py") + sources("test/**/*.h") + "\n".join(
        (ROOT / "scripts" / name).read_text(encoding="utf-8") for name in scripts())
    read = set(re.findall(r"\bRAVEN2_(?:TRAINER|RUN|USB)_[A-Z_]+\b(?=\"|\'|:|\})", shipped)) - {"RAVEN2_TRAINER_SOURCE_DIR"}
    read |= set(re.findall(r'(?:getenv|environment)\("([A-Z_]+)"', sources("src/**/*.cpp")))
    assert {"RAVEN2_TRAINER_SHARE", "ROS_IP", "DISPLAY"} <= read
    assert interface_page.unknown(interface_page.names("Environment variables"), read) == []


def types_of_interfaces():
    """{name: [type]} of topics and services; cells of several names have several types."""
    return {name: set(re.findall(r"\b[A-Z][A-Za-z]{2,}\b", cells[1])) for title in DAEMON for cells in interface_page.rows(title)
            for name in re.findall(r"`([^`]+)`", cells[0])}


def types_of_code():
    """{name: type} of the topics and services that the daemon's sources advertise by name."""
    text = sources("src/ros/*/*.cpp") + sources("src/ros/*/*.h")
    told = {name: kind for kind, name in re.findall(r'advertise<(?:\w+::)?(\w+)>\(\s*"(/?\w[\w/]*)"', text)}
    for name, method in re.findall(r'advertiseService\(\s*"([\w/]+)", &\w+::(\w+)', text):
        told[name] = re.search(rf"\b{method}\((?:\w+::)?(\w+)::Request", text).group(1)
    others = {"/clock", "/ravenstate", "/joint_states", "virtual_raven/press_start"}  # of other programs
    return {name: kind for name, kind in told.items() if name not in others}


def test_types_on_the_page_of_interfaces_are_those_of_the_code():
    known, code = types_of_interfaces(), types_of_code()
    assert len(code) > 25 and code["plan"] == "PlanPath" and code["/tf"] == "TFMessage"
    own = {name: kind for name, kind in code.items() if known[name]}  # the other cells refer to another row
    assert len(own) > 25 and {name: kind for name, kind in own.items() if kind not in known[name]} == {}


def types_that_are_told(page):
    """[(line, name, type)] of tables, which have names in the first column and a type in another one, and of
    `name` (package/Type) in a text."""
    for number, line in enumerate(page.read_text(encoding="utf-8").split("\n"), 1):
        names = re.findall(r"`([^`]+)`", line.split("|")[1]) if line.startswith("| `") else []
        yield from ((number, name, kind) for name in names for kind in re.findall(r"(?<=\| )\w+/([A-Z]\w+)", line))
        yield from ((number, name, kind) for name, kind in re.findall(r"`(/?[a-z][\w/]*)` \(\w+_\w+/([A-Z]\w+)", line))


def test_types_on_other_pages_are_those_of_the_page_of_interfaces():
    known = {name.lstrip("/"): kinds for name, kinds in types_of_interfaces().items()}
    told = [(place(page, number), name.lstrip("/"), kind) for page in TALKED if page.name != "interfaces.md"
            for number, name, kind in types_that_are_told(page)]
    told = [each for each in told if known.get(each[1])]
    assert len({name for _, name, _ in told}) >= 10 and len(known) > 40
    assert [each for each in told if each[2] not in known[each[1]]] == []


def test_tables_of_topics_and_services_are_on_one_page():
    rows = {page.name: sum(line.startswith("| `") and bool(re.search(r"\| \w+/[A-Z]\w+", line))
                           for line in page.read_text(encoding="utf-8").split("\n")) for page in (ROOT / "README.md", ROOT / "doc/ros.md")}
    assert rows == {"README.md": 0, "ros.md": 0}


@pytest.mark.parametrize("text, check", [
    ("`simulate --no-such`", test_options_of_programs_are_there),
    ("```\nscripts/run --video \\\n  --no-such\n```", test_options_of_programs_are_there),
    ("with `--no-such` beside", test_options_that_are_named_alone_are_somebodys),
    ("`rosrun raven2_trainer no_such DIR`", test_programs_that_are_run_are_there),
    ("`simulate --hazard no_such`", test_scenarios_and_exercises_that_are_asked_for_are_there),
    ("`roslaunch raven2_trainer training.launch exercise:=no_such`", test_scenarios_and_exercises_that_are_asked_for_are_there),
    ("`roslaunch raven2_trainer training.launch no_such:=1`", test_arguments_of_launch_files_are_there),
    ("a span that goes\non: `config/faults/\nno_such`, `config/no_such.yaml`", test_files_that_are_named_are_there),
    ("`core/no_such.h`", test_headers_that_are_named_are_there),
    ("`no_such: 3` in `config/runtime.yaml`", test_keys_of_configuration_that_are_named_are_there),
    ("`rosservice call /no_such`", test_topics_and_services_that_are_called_are_there),
    ("`rostopic pub -r 20 /no_such`", test_topics_and_services_that_are_called_are_there),
    ("| `mode` | raven2_trainer/NoSuch | |", test_types_on_other_pages_are_those_of_the_page_of_interfaces),
    ("`mode` (raven2_trainer/NoSuch)", test_types_on_other_pages_are_those_of_the_page_of_interfaces),
])
def test_what_is_not_there_is_noticed(text, check, tmp_path, monkeypatch):
    page = tmp_path / "page.md"
    page.write_text(f"# Page\n\n{text}\n", encoding="utf-8")
    monkeypatch.setitem(globals(), "TALKED", [page, *TALKED])
    with pytest.raises(AssertionError, match="no.?such|NoSuch"):
        check()


CITED = re.compile(r"\b(\w+)\.md((?:(?:,|,? and)?(?:\s|\n\s*(?://|\*|#)\s*)+\d+(?:\.\d+)*(?![\d,]*\s*(?:words|lines)))+)")


def citations(text):
    """[(page, section)] of `raven2.md 3.4, 5.1`."""
    return [(name, number) for name, numbers in CITED.findall(text) for number in re.findall(r"\d+(?:\.\d+)*", numbers)]


def test_sections_that_are_cited_are_there():
    found = 0
    for folder in ("include", "src", "config", "test", "urdf", "launch", "scripts", "doc"):
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix not in {".h", ".cpp", ".py", ".yaml", ".md", ".launch"} or path.name == "test_documents.py":
                continue
            for name, number in citations(path.read_text(encoding="utf-8")):
                page = ROOT / "doc" / f"{name}.md"
                heading = rf"^#+ {re.escape(number)}\b(?!\.\d)"
                assert page.exists() and re.search(heading, page.read_text(encoding="utf-8"), re.M), f"{path}: {name}.md {number}"
                found += 1
    assert found > 200


def test_citations_are_read_over_line_breaks():
    assert citations("// (raven2.md\n// 3.4, 5.1)") == [("raven2", "3.4"), ("raven2", "5.1")]
    assert citations("doc/model.md says 3 things") == []


def test_each_file_to_touch_has_the_example_of_its_row():
    """CONTRIBUTING: `git grep -niE EXAMPLE FILES` shows a newcomer where the lines go."""
    table = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").split("| you want to add |")[1].split("\n\n")[0]
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in table.splitlines()[2:]]
    assert len(rows) == 18
    for what, files, example in (row for row in rows if row[2]):
        named = re.findall(r"`([^` ]+/[^` ]+\.\w+)`", files)
        assert len(named) >= 3, what
        for name in named:
            path = next(path for path in (ROOT / name, ROOT / "include/raven2_trainer" / name) if path.exists())
            assert re.search(example.strip("`"), name + path.read_text(encoding="utf-8"), re.I), (what, name, example)
