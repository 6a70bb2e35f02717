"""doc/tutorials: what they tell a reader to type does what they say. All are run with RAVEN2_TRAINER_FULL=1, one without."""

import os

import pytest
import tutorial

FULL = os.environ.get("RAVEN2_TRAINER_FULL") == "1"
BUILT = (tutorial.BUILD / "devel/lib/raven2_trainer/simulator").exists()
NAMES = [page.stem for page in tutorial.PAGES]
RUN = NAMES if FULL else ["researcher"]  # which needs neither ROS nor a clock, and half a minute


def test_there_is_one_for_each_kind_of_user():
    assert NAMES == ["educator", "engineer", "researcher", "surgeon_assistant"]


@pytest.mark.parametrize("page", tutorial.PAGES, ids=NAMES)
def test_each_says_what_its_commands_come_to(page):
    told = tutorial.blocks(page)
    assert len(told) >= 5
    assert [block.place() for block in told if not block.promises] == []


def typed(folder, text, **expected):
    """What becomes of one block with these commands."""
    block = tutorial.Block(tutorial.PAGES[0], 1, expected.pop("seconds", 20.0), text)
    for name, value in expected.items():
        setattr(block, name, value)
    with tutorial.Shell(folder) as shell:
        tutorial.check(block, *shell.run(block))


def test_a_command_that_fails_is_noticed(tmp_path):
    with pytest.raises(AssertionError, match="exit code 3, expected 0"):
        typed(tmp_path, "(exit 3)\necho behind it\n")


def test_a_failure_that_is_told_is_none(tmp_path):
    typed(tmp_path, "false || true\n(exit 3)\necho behind it\n", code=3, outputs=["behind it"])


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
        code, output, _ = shell.run(tutorial.Block(tutorial.PAGES[0], 1, 20.0,
                                                   "echo 36010; grep '^master_port' $RAVEN2_TRAINER_SHARE/config/network.yaml"))
        assert code == 0 and "36010" not in output and output.count(str(shell.ports[36010])) == 2


def test_a_clause_that_cannot_be_checked_is_refused():
    with pytest.raises(ValueError, match="is none of"):
        tutorial.Block(tutorial.PAGES[0], 1, 1.0, "").expect("that it works")


@pytest.mark.skipif(not BUILT, reason="the programs are not built")
@pytest.mark.parametrize("name", RUN)
def test_its_commands_do_what_it_says(name, tmp_path):
    tutorial.run(tutorial.PAGES[NAMES.index(name)], tmp_path)
