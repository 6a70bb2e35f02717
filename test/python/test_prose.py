"""The project's prose (scripts/check_prose): words of the list, long sentences, reading ease. Also README's drawing."""

import pathlib
import re
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
CHECK = ROOT / "scripts/check_prose"
FOLDERS = ("include", "src", "scripts", "python", "launch", "config")
PAGES = ["README.md", "CHANGELOG.md", "CONTRIBUTING.md", "urdf/README.md", *sorted(str(p.relative_to(ROOT)) for p in (ROOT / "doc").rglob("*.md"))]


def files_of(*folders):
    """Text files that people write, below these folders of the tree."""
    unwritten = {".json", ".rviz", ".pyc", ".csv", ".css", ".svg"}
    return sorted(str(p.relative_to(ROOT)) for folder in folders for p in (ROOT / folder).rglob("*")
                  if p.is_file() and "__pycache__" not in p.parts and p.suffix not in unwritten)


TESTS = [name for name in files_of("test") if name.endswith((".cpp", ".h", ".c", ".py", ".launch", ".test", ".sh", "CMakeLists.txt"))]
MOST_WORDS = 46000  # words of prose on all pages, as --table counts them


def check(*arguments):
    return subprocess.run([CHECK, *map(str, arguments)], capture_output=True, text=True, timeout=300, check=False)


def test_pages_and_sources_are_plain():
    result = check("--names", *(ROOT / name for name in PAGES + files_of(*FOLDERS)))
    assert (result.returncode, result.stdout) == (0, "")


def test_the_comments_of_tests_are_plain():
    result = check(*(ROOT / name for name in TESTS))
    assert (result.returncode, result.stdout) == (0, "")


def test_the_pages_do_not_grow():
    words = re.search(r"^all pages +(\d+) words", check("--table", *sorted(ROOT.glob("doc/**/*.md")), ROOT / "README.md").stdout, re.M)
    assert int(words.group(1)) <= MOST_WORDS


@pytest.mark.parametrize("text, found", [
    ("The robot is told to stop.", "told"),
    ("A number that is none comes.", "number that is"),
    ("It stands beside the console.", "stand"),
    ("What the masters moved moves nothing.", "name the thing"),
    ("Each page begins " + "with a word and " * 12 + "ends.", "sentence of"),
    ("Incomprehensibility notwithstanding, organisational responsibilities necessitate administrative documentation.", "reading ease"),
])
def test_what_is_not_plain_is_found(tmp_path, text, found):
    page = tmp_path / "page.md"
    page.write_text(text + "\n")
    result = check(page)
    assert result.returncode == 1 and found in result.stdout


@pytest.mark.parametrize("text", ["`told` and `stands` are keys.", "```bash\ntold anew\n```", "What is a drill? A hazard.",
                                  "ITP stands for a packet of hand motion."])
def test_what_is_plain_passes(tmp_path, text):
    page = tmp_path / "page.md"
    page.write_text(text + " It is short. So is this.\n")
    assert check(page).stdout == ""


def test_comments_messages_and_names_of_sources_are_read(tmp_path):
    source = tmp_path / "a.cpp"
    source.write_text('// It is told.\nint is_told = 0;  /* anew */\nconst char* text = "beside";\n')
    lines = check("--names", source).stdout.splitlines()
    assert [re.search(r"a.cpp:(\d+): (name|'\w+')", line).groups() for line in lines] == [
        ("1", "'told'"), ("2", "'anew'"), ("3", "'beside'"), ("2", "name")]


def test_the_texts_of_web_pages_are_read(tmp_path):
    page, script = tmp_path / "a.html", tmp_path / "a.js"
    page.write_text('<p class="told">It is\ntold.</p>\n<input title="stands here">\n')
    script.write_text('// It is told.\nconst a = `${anew} stands`, told = "beside";\n')
    lines = check(page, script).stdout.splitlines()
    assert [re.search(r"a.(?:html|js):(\d+): '(\w+)'", line).groups() for line in lines] == [
        ("2", "told"), ("3", "stands"), ("1", "told"), ("2", "stands"), ("2", "beside")]


def test_each_exception_has_a_reason():
    for line in (ROOT / "test/python/prose_allowed.txt").read_text(encoding="utf-8").splitlines():
        assert line.startswith("#") or len(line.split(" | ")) == 3, line


def test_the_drawing_is_what_its_script_draws():
    assert subprocess.run([ROOT / "scripts/make_drawing", "--check"], check=False, timeout=60).returncode == 0
