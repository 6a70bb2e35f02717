"""--help of every program and script returns 0 and explains the purpose, every option and the exit status. The tab key
completes the programs' names.

Needs the built programs, in $RAVEN2_TRAINER_BUILD or build/.
"""

import os
import pathlib
import re
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build"))
FOLDER = BUILD / "devel/lib/raven2_trainer"
PROGRAMS = re.findall(r"^raven2_program\((\w+)", (ROOT / "CMakeLists.txt").read_text(), re.MULTILINE)
SCRIPTS = sorted(path for path in (ROOT / "scripts").iterdir()
                 if path.is_file() and os.access(path, os.X_OK))
VERDICTS = ["campaign_report", "check_layering.py", "check_package", "check_fresh_debian", "check_slurm", "compare_replay",
            "describe_hazards", "doctor", "fuzz", "generate_description", "make_bands", "make_dataset", "measure_drills", "measure_hazards",
            "run",
            "session_report", "session_sums", "soak", "stress", "summarise_tests", "test"]  # exit status is a result
CLI11_COLUMN = 28  # descriptions begin here; one blank separates a name that ends just before
COMPLETION = pathlib.Path("/usr/share/bash-completion/completions/rosrun")


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """A home folder for all runs, because matplotlib keeps a cache in it."""
    return tmp_path_factory.mktemp("home")


def ask(program, home):
    """Output of --help in a minimal environment."""
    environment = {"PATH": "/usr/bin:/bin:/usr/sbin:/sbin", "COLUMNS": "150", "HOME": str(home), "LANG": "C.UTF-8"}
    result = subprocess.run([program, "--help"], capture_output=True, text=True, timeout=120, env=environment,
                            check=False)
    assert result.returncode == 0, result.stderr
    assert result.stderr == ""
    return result.stdout


def purpose(text):
    """First line of a help text; for argparse, the first line after the usage."""
    paragraphs = text.split("\n\n")
    return paragraphs[1 if paragraphs[0].startswith("usage:") else 0].splitlines()[0]


def entries(text):
    """[(name, description)] of the options and arguments that argparse and CLI11 list."""
    found, current = [], None
    is_list = is_cli11 = False
    for line in text.splitlines():
        if re.match(r"^(options|positional arguments|Options|Arguments|Network ports|Accepted, without effect here|Subcommands):$", line):
            is_list, is_cli11 = True, line[0].isupper()
        elif line and not line.startswith(" "):
            is_list = False
        elif is_list and re.match(r"^  \S", line):
            name, _, rest = line.strip().partition("  ")
            if is_cli11 and line[CLI11_COLUMN - 1:CLI11_COLUMN] == " ":
                name, rest = line[:CLI11_COLUMN].strip(), line[CLI11_COLUMN:]
            current = [name, rest.strip()]
            found.append(current)
        elif is_list and current and line.strip():
            current[1] += " " + line.strip()
    return [(name, text.strip()) for name, text in found]


def says_what_it_does(text):
    line = purpose(text)
    assert re.match(r"^[A-Z]\S* \S+", line) and len(line) > 20, line
    assert not line.lower().startswith(("usage", "options"))


@pytest.mark.parametrize("name", PROGRAMS)
def test_programs_explain_themselves(name, home):
    text = ask(FOLDER / name, home)
    says_what_it_does(text)
    assert re.search(r"Exit (status|code)", text)
    listed = entries(text)
    assert len(listed) >= 2 and any(name.startswith("-h,--help") for name, _ in listed)
    for option, description in listed:
        words = re.sub(r"^(Needs|Excludes): \S+", "", description).strip()
        assert len(words) > 5, f"{option} has no description"


def names_in_source(path):
    """Long options that a script takes, in argparse's calls or in the labels of a shell's case."""
    text = path.read_text()
    if text.startswith("#!/usr/bin/python3"):
        return re.findall(r"add_argument\(\s*(?:[\"']-\w[\"'],\s*)?[\"'](--[\w-]+)", text)
    labels = re.findall(r"^\s*((?:-[\w-]+ ?\|? ?(?:\\\n\s*)?)+)\)", text, re.MULTILINE)
    return [word for label in labels for word in re.findall(r"--[\w-]+", label) if word != "--help"]


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.name)
def test_scripts_explain_themselves(path, home):
    text = ask(path, home)
    says_what_it_does(text)
    for option, description in entries(text):
        assert len(description) > 5, f"{option} has no description"
    for option in names_in_source(path):
        assert option in text, f"--help does not mention {option}"
    if path.name in VERDICTS:
        assert re.search(r"\b[Ee]xit", text), "--help does not explain the exit status"


def test_options_are_found_in_sources_and_in_lists():
    assert {"--exercise", "--no-video", "--arm-contacts"} <= set(names_in_source(ROOT / "scripts/run"))
    assert names_in_source(ROOT / "scripts/soak") == ["--minutes", "--seed", "--profile", "--output"]
    text = "usage: x\n\nDoes it all.\n\noptions:\n  --one   first\n  --two\n          second\n  --three X\n\nlast words\n"
    assert entries(text) == [("--one", "first"), ("--two", "second"), ("--three X", "")]
    assert purpose(text) == "Does it all."
    text = "Does it all.\nUsage: x\n\nOptions:\n" + "  --friction on|off         What it is\n" + "  --no-words TEXT\n"
    assert entries(text) == [("--friction on|off", "What it is"), ("--no-words TEXT", "")]


def test_scripts_with_a_verdict_are_there():
    assert set(VERDICTS) <= {path.name for path in SCRIPTS}


COMPLETE = """
source "$1/devel/setup.bash" || exit 1
source "$2" || exit 1
COMP_WORDS=(rosrun raven2_trainer "$3") COMP_CWORD=2
_roscomplete_exe
printf '%s\\n' "${COMPREPLY[@]}"
"""


def complete(word):
    environment = {key: value for key, value in os.environ.items() if not key.startswith(("ROS", "CMAKE_PREFIX"))}
    result = subprocess.run(["bash", "-c", COMPLETE, "bash", BUILD, COMPLETION, word], capture_output=True, text=True,
                            timeout=120, env=environment, check=False)
    assert result.returncode == 0, result.stderr
    return set(result.stdout.split())


@pytest.mark.skipif(not COMPLETION.exists(), reason="rosbash is not installed")
def test_the_tab_key_knows_every_program():
    assert set(PROGRAMS) <= complete("")
    assert complete("simu") >= {"simulate", "simulator"}
    assert all(name.startswith("simu") for name in complete("simu"))
