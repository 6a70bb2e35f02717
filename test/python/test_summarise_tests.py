"""scripts/summarise_tests: which tests it counts as passed, failed and skipped."""
import os
import pathlib
import subprocess
import sys

import pytest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "summarise_tests"
GOOD = '<testsuite><testcase classname="A" name="a"/><testcase classname="A" name="b"/></testsuite>'
BAD = '<testsuite><testcase classname="A" name="a"><failure/></testcase></testsuite>'
SKIPPED = '<testsuite><testcase classname="A" name="a"><skipped/></testcase></testsuite>'


def run(folder, status=0, log="", name="plain", **files):
    """Makes a folder with these files. Returns its --run option."""
    results = folder / name
    results.mkdir()
    for stem, text in files.items():
        (results / f"{stem}.xml").write_text(text)
    log_file = folder / f"{name}.log"
    log_file.write_text(log)
    return ["--run", name, str(results), str(status), str(log_file)]


def summarise(*runs, full=False):
    done = subprocess.run([sys.executable, str(SCRIPT), *sum(runs, [])], capture_output=True, text=True, check=False,
                          env={**os.environ, "RAVEN2_TRAINER_FULL": "1" if full else "0"})
    return done.returncode, done.stdout.splitlines()


def test_runs_are_added_up_and_failures_named_with_their_run(tmp_path):
    code, lines = summarise(run(tmp_path, core=GOOD, wire=SKIPPED), run(tmp_path, 8, name="asan", core=BAD))
    assert code == 1
    assert "failed: asan: A.a" in lines
    assert lines[-1] == "2 passed, 1 failed, 1 skipped"


def test_nothing_skipped_is_not_mentioned(tmp_path):
    code, lines = summarise(run(tmp_path, core=GOOD))
    assert (code, lines[-1]) == (0, "2 passed, 0 failed")
    assert [line for line in lines if line.startswith("slow: ")] == ["slow:    0.0 s A.b", "slow:    0.0 s A.a"]


@pytest.mark.parametrize("run_name,file,case,again", [
    ("plain", "core", '<testcase classname="A" name="a"><failure/></testcase>', "GTEST_FILTER='A.a' scripts/test -R '^core$'"),
    ("plain", "system_clock", '<testcase classname="test.system.test_link" name="test_x[1]"><failure/></testcase>',
     "PYTEST_ADDOPTS='-k test_x' scripts/test -R '^system_clock$'"),
    ("plain", "rosunit-plan", '<testcase classname="A" name="a"><failure/></testcase>', "scripts/test -R '^rostest_plan$'"),
    ("plain", "rosunit-replay_session_heard", '<testcase classname="A" name="a"><failure/></testcase>',
     "scripts/test -R '^rostest_replay_session$'"),
    ("asan", "core", '<testcase classname="A" name="a"><failure/></testcase>',
     "GTEST_FILTER='A.a' ctest --test-dir build/fuzz --output-on-failure -R '^core$'"),
    ("fuzz", "fuzz", '<testcase classname="fuzz" name="yaml"><failure/></testcase>', "scripts/fuzz --seconds 3 yaml"),
    ("learn", "learn", '<testcase classname="A" name="a"><failure/></testcase>', "scripts/test --full --only learn")])
def test_a_failure_names_the_command_that_repeats_it(tmp_path, run_name, file, case, again):
    lines = summarise(run(tmp_path, 8, name=run_name, **{file: f"<testsuite>{case}</testsuite>"}))[1]
    assert f"  again: {again}" in lines


@pytest.mark.parametrize("name, build", [("asan", "asan"), ("tsan", "tsan"), ("tsan_threaded", "tsan")])
def test_a_failure_under_a_sanitizer_of_a_full_run_is_repeated_in_its_build(tmp_path, name, build):
    lines = summarise(run(tmp_path, 8, name=name, core=BAD), full=True)[1]
    assert f"  again: GTEST_FILTER='A.a' ctest --test-dir build/{build} --output-on-failure -R '^core$'" in lines


def test_a_failure_says_why_in_few_lines(tmp_path):
    short = '<testcase classname="A" name="a"><failure message="core_test.cpp:7&#x0A;&#x0A;too high: 3&#x0A;4" type=""/></testcase>'
    long = f'<testcase classname="A" name="b"><error>{"x" * 500}{"&#x0A;line" * 50}</error></testcase>'
    lines = summarise(run(tmp_path, 8, core=f"<testsuite>{short}{long}</testsuite>"))[1]
    first = lines.index("failed: A.a")
    assert lines[first + 1:first + 4] == ["    core_test.cpp:7", "    too high: 3", "    4"]
    assert lines[first + 4].startswith("  again: ")
    text = lines[lines.index("failed: A.b") + 1:]
    text = text[:[line.startswith("  again: ") for line in text].index(True)]
    assert text == ["    " + "x" * 160] + ["    line"] * 7


def test_a_crash_counts_beside_a_failure_of_another_program(tmp_path):
    log = "The following tests FAILED:\n\t  1 - core (SEGFAULT)\n\t  2 - wire (Failed)\nErrors while running CTest\n"
    code, lines = summarise(run(tmp_path, 8, log, wire=BAD, net=GOOD))
    assert code == 1
    assert "failed: core ended without a result" in lines
    assert lines[-1] == "2 passed, 2 failed"


def test_a_crash_after_good_cases_counts(tmp_path):
    log = "The following tests FAILED:\n\t 12 - core (Subprocess aborted)\n"
    assert summarise(run(tmp_path, 8, log, core=GOOD))[1][-1] == "2 passed, 1 failed"


def test_a_failed_rostest_is_explained_by_its_own_files(tmp_path):
    log = "The following tests FAILED:\n\t 30 - rostest_plan (Failed)\n"
    assert summarise(run(tmp_path, 8, log, **{"rosunit-plan": BAD}))[1][-1] == "0 passed, 1 failed"


def test_a_run_that_fails_without_a_word_counts(tmp_path):
    code, lines = summarise(run(tmp_path, core=GOOD), run(tmp_path, 1, name="fuzz"))
    assert code == 1
    assert lines[-1] == "2 passed, 1 failed"


def test_a_broken_file_and_an_empty_run_fail(tmp_path):
    assert summarise(run(tmp_path, core="<testsuite>"))[0] == 1
    assert summarise(run(tmp_path, name="none"))[0] == 1
