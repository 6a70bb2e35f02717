"""The commands in README and the pages of doc have the results that the pages promise. RAVEN2_TRAINER_FULL=1 runs all
marked commands. Without it, only those run that need neither ROS nor a clock, and less than a minute."""

import os
import shutil

import pytest
import tutorial

FULL = os.environ.get("RAVEN2_TRAINER_FULL") == "1"
BUILT = (tutorial.BUILD / "devel/lib/raven2_trainer/simulator").exists()
SHORT = ("researcher.md", "python.md")
PARTS = [part for page in tutorial.PAGES for part in tutorial.parts(page)]
RUN = [part for part in PARTS if FULL or part.page.name in SHORT]


def test_there_is_one_for_each_kind_of_user():
    assert [page.stem for page in tutorial.TUTORIALS] == ["educator", "engineer", "researcher", "surgeon_assistant"]


@pytest.mark.parametrize("page", tutorial.TUTORIALS, ids=lambda page: page.stem)
def test_each_has_commands(page):
    assert len(tutorial.blocks(page)) >= 5


def test_each_block_says_what_its_commands_come_to():
    assert [block.place() for part in PARTS for block in part.blocks if not block.promises] == []


def test_what_stands_beside_a_page_is_known():
    assert [part.place() for part in PARTS if part.beside and part.beside not in tutorial.BESIDE] == []


@pytest.mark.parametrize("page", tutorial.PAGES, ids=lambda page: page.stem)
def test_each_command_is_run_or_says_why_not(page):
    assert tutorial.unmarked(page.name, page.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize("text, complaint", [
    ("```bash\nls\n```", "page.md:1: neither"), ("\n```\nls\n```", "page.md:2: a block without a language"),
    ("<!-- not run: -->\n```bash\nls\n```", "page.md:2: neither"),
    ("<!-- not run: too much work -->\n```bash\nls\n```", "page.md:1: \"too much work\" is no reason"),
    ("<!-- run -->\n\n```bash\nls\n```", "page.md:3: neither"), ("```text\nrostopic list\n```", "page.md:2: a command outside"),
    ("So:\n\n    scripts/doctor\n", "page.md:3: a command outside")])
def test_commands_without_a_word_are_noticed(text, complaint):
    wrong = tutorial.unmarked("page.md", text)
    assert len(wrong) == 1 and wrong[0].startswith(complaint)


@pytest.mark.parametrize("text", ["```yaml\na: 1\n```", "<!-- run: 9 s -->\n```bash\nls\n```", "```text\na ──► b\n```",
                                  "<!-- not run: takes hours -->\n```bash\nls\n```", "    J = eta1 c\n"])
def test_what_is_marked_or_no_command_is_left_alone(text):
    assert tutorial.unmarked("page.md", text) == []


def page_of(folder, text):
    page = folder / "page.md"
    page.write_text(text, encoding="utf-8")
    return page


def test_a_page_is_cut_where_something_else_is_beside_it(tmp_path):
    block = "<!-- run -->\n```bash\necho\n```\n"
    found = tutorial.parts(page_of(tmp_path, f"{block}\n{block}\n<!-- with: a session -->\n{block}"))
    assert [(part.beside, len(part.blocks)) for part in found] == [("a terminal", 2), ("a session", 1)]


def test_a_block_of_python_is_run_by_python(tmp_path):
    text = "<!-- run -->\n```python\nimport sys\nprint(6 * 7, '$HOME', sys.executable)\n```\n\nExpected: output `42 $HOME /usr`.\n"
    part = tutorial.parts(page_of(tmp_path, text))[0]
    part.beside = ""
    (tmp_path / "shell").mkdir()
    tutorial.run(part, tmp_path / "shell")


def typed(folder, text, **expected):
    """Runs one block with these commands and checks its results."""
    block = tutorial.Block(tutorial.TUTORIALS[0], 1, expected.pop("seconds", 20.0), text)
    for name, value in expected.items():
        setattr(block, name, value)
    with tutorial.Shell(folder) as shell:
        tutorial.check(block, *shell.run(block))


def test_a_command_that_fails_is_noticed(tmp_path):
    with pytest.raises(AssertionError, match="exit code 3, expected 0"):
        typed(tmp_path, "(exit 3)\necho behind it\n")


def test_a_failure_that_is_told_is_none(tmp_path):
    typed(tmp_path, "false || true\n(exit 3)\necho behind it\n", codes={3}, outputs=["behind it"])


def test_one_of_two_exit_codes_is_enough(tmp_path):
    block = tutorial.Block(tutorial.TUTORIALS[0], 1, 20.0, "(exit 4)\n")
    block.expect("exit code 0 or 4")
    with tutorial.Shell(tmp_path) as shell:
        tutorial.check(block, *shell.run(block))
    assert block.codes == {0, 4}


def test_what_is_not_printed_is_noticed(tmp_path):
    with pytest.raises(AssertionError, match='no "yes" in the output'):
        typed(tmp_path, "echo no\n", outputs=["yes"])


def test_a_file_with_nothing_in_it_is_noticed(tmp_path):
    with pytest.raises(AssertionError, match="nothing in it"):
        typed(tmp_path, "touch empty\n", files=["empty"])


def test_a_file_is_looked_for_where_the_commands_have_gone(tmp_path):
    typed(tmp_path, "mkdir below; cd below; echo x > it\n", files=["it"])


def test_a_command_that_hangs_ends(tmp_path):
    with pytest.raises(TimeoutError, match="not within 1 s; it printed:\nbefore"):
        typed(tmp_path, "echo before\nsleep 60\n", seconds=1.0)


def test_ports_are_its_own(tmp_path):
    with tutorial.Shell(tmp_path) as shell:
        code, output, _ = shell.run(tutorial.Block(tutorial.TUTORIALS[0], 1, 20.0,
                                                   "echo 36010; grep '^master_port' $RAVEN2_TRAINER_SHARE/config/network.yaml"))
        assert code == 0 and "36010" not in output and output.count(str(shell.ports[36010])) == 2


def test_a_clause_that_cannot_be_checked_is_refused():
    with pytest.raises(ValueError, match="is none of"):
        tutorial.Block(tutorial.TUTORIALS[0], 1, 1.0, "").expect("that it works")


@pytest.mark.skipif(not BUILT, reason="the programs are not built")
@pytest.mark.parametrize("part", RUN, ids=lambda part: part.place())
def test_its_commands_do_what_it_says(part, tmp_path):
    if part.beside == "a display" and not shutil.which("Xvfb"):
        pytest.skip("Xvfb is not installed")
    tutorial.run(part, tmp_path)
