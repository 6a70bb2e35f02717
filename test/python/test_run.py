"""scripts/run with other programs, which only note how they were started."""

import os
import pathlib
import shutil
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
COMMON = """ROOT={folder} LOGS={folder}/logs BUILD={folder}/build
step() {{ :; }}; configure_and_build() {{ :; }}; source_ros() {{ :; }}; say() {{ :; }}
fail() {{ echo "$*" >&2; exit 1; }}
free_port() {{ echo $((25000 + $(ls {folder}/ports | wc -l))); touch {folder}/ports/$(ls {folder}/ports | wc -l); }}
"""
PROGRAM = """#!/bin/sh
echo "$*" > {folder}/{name}.words
case {name} in simulator | session_report) ;; *) exec sleep 60 ;; esac
"""


@pytest.fixture(name="run")
def fixture_run(tmp_path):
    """Runs scripts/run. @return {program: {option: value}}."""
    for folder in ("scripts", "logs", "ports", "build/devel/lib/raven2_trainer"):
        (tmp_path / folder).mkdir(parents=True)
    shutil.copy(ROOT / "scripts/run", tmp_path / "scripts/run")
    (tmp_path / "scripts/common.sh").write_text(COMMON.format(folder=tmp_path))
    programs = ["virtual_raven", "impair", "master_console", "simulator"]
    for name, place in {"rosmaster": ".", "session_report": "scripts", **dict.fromkeys(programs, "build/devel/lib/raven2_trainer")}.items():
        (tmp_path / place / name).write_text(PROGRAM.format(folder=tmp_path, name=name))
        (tmp_path / place / name).chmod(0o755)

    def call(*words):
        # The simulator ends at once, and the others start at the same time.
        simulator = tmp_path / "build/devel/lib/raven2_trainer/simulator"
        waits = " ".join(f"{tmp_path}/{name}.words" for name in programs[:3] if name != "impair" or "--impair" in words)
        simulator.write_text(PROGRAM.format(folder=tmp_path, name="simulator").replace(
            "case", f"for i in $(seq 200); do ls {waits} >/dev/null 2>&1 && break; sleep 0.05; done\ncase"))
        done = subprocess.run(["bash", str(tmp_path / "scripts/run"), "--no-video", "--output", str(tmp_path / "session"), *words], text=True,
                              capture_output=True, timeout=120, check=False, env={**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}"})
        assert done.returncode == 0, done.stderr
        said = {name: (tmp_path / f"{name}.words").read_text().split() for name in programs if (tmp_path / f"{name}.words").exists()}
        return {name: dict(zip(words, words[1:])) for name, words in said.items()}

    return call


@pytest.mark.parametrize("link", [(), ("--impair", "wifi")])
def test_what_is_asked_for_reaches_each_program(run, link):
    seen = run("--seed", "7", "--reaction", "400", "--hazard", "fk_pos", "--duration", "1", *link)
    assert sorted(seen) == sorted(["virtual_raven", "master_console", "simulator", *(["impair"] if link else [])])
    assert {words["--seed"] for words in seen.values()} == {"7"}
    assert seen["master_console"]["--reaction"] == "400" and seen["simulator"]["--duration"] == "1"
    assert {words["--hazard"] for name, words in seen.items() if name != "impair"} == {"fk_pos"}
    near, far = seen["simulator"]["--master-port"], seen["master_console"]["--master-port"]
    assert (near == far) != bool(link), "over a bad link the console sends to it"
    if link:
        assert seen["impair"]["--profile"] == "wifi" and seen["impair"]["--udp"].count(":127.0.0.1:") == 1
