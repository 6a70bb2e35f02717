"""scripts/check_layering.py: violations in small trees, each with its place."""
import pathlib
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import check_layering  # noqa: E402


def found_in(tree, files, monkeypatch):
    for name, text in files.items():
        path = tree / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    monkeypatch.setattr(check_layering, "ROOT", tree)
    sources = list(check_layering.sources())
    assert len(sources) == len(files)
    return [line for module, path in sources for line in check_layering.violations(module, path)] + \
        list(check_layering.impurities(sources)) + list(check_layering.seen_whole(sources))


HEADER = "include/raven2_trainer/"


@pytest.mark.parametrize("files, place, why", [
    ({"src/loop/a.cpp": "#include <thread>\n"}, "src/loop/a.cpp:1", "thread"),
    ({"src/physics/a.cpp": "\n#include <chrono>\n"}, "src/physics/a.cpp:2", "chrono"),
    ({"src/loop/a.cpp": "#include <cstdio>\n"}, "src/loop/a.cpp:1", "cstdio"),
    ({"src/raven/a.cpp": "#include <random>\n"}, "src/raven/a.cpp:1", "random"),
    ({"src/loop/a.cpp": '#include "raven2_trainer/model/a.h"\n', HEADER + "model/a.h": "#include <fstream>\n"},
     HEADER + "model/a.h:1", "fstream"),
    ({"src/loop/a.cpp": '#include "raven2_trainer/model/a.h"\n', HEADER + "model/a.h": "", "src/model/a.cpp": "#include <mutex>\n"},
     "src/model/a.cpp:1", "mutex"),
    ({HEADER + "physics/a.h": "#include <ode/ode.h>\n"}, HEADER + "physics/a.h:1", "ode/ode.h"),
    ({"src/kinematics/a.cpp": '#include "raven2_trainer/physics/a.h"\n'}, "src/kinematics/a.cpp:1", "may not include physics"),
    ({"src/planning/a.cpp": '#include "kinematics/a.h"\n'}, "src/planning/a.cpp:1", "a private header of kinematics"),
    ({"src/planning/a.cpp": '#include "../kinematics/a.h"\n', "src/kinematics/a.h": ""}, "src/planning/a.cpp:1",
     "a private header of kinematics"),
    ({"src/loop/a.cpp": "#include <ros/ros.h>\n"}, "src/loop/a.cpp:1", "ros/ros.h"),
    ({"src/loop/a.cpp": "#include SOMETHING\n"}, "src/loop/a.cpp:1", "cannot read"),
    ({"src/ros/crtk/a.cpp": '\n#include "raven2_trainer/daemon/a.h"\n', HEADER + "config/trainer_config.h": "",
      HEADER + "daemon/a.h": '#include "raven2_trainer/config/trainer_config.h"\n'}, "src/ros/crtk/a.cpp:2", "no composition root"),
])
def test_what_breaks_the_layers_is_named_with_its_place(tmp_path, monkeypatch, files, place, why):
    found = found_in(tmp_path, files, monkeypatch)
    assert found and all(line.startswith(place + ": ") for line in found), found
    assert any(why in line for line in found), found


def test_what_no_tick_runs_may_wait_and_read_files(tmp_path, monkeypatch):
    assert not found_in(tmp_path, {
        "src/physics/a.cpp": "#include <ode/ode.h>\n",
        "src/physics/ode_world.cpp": "#include <mutex>\n",
        "src/loop/a.cpp": '#include "raven2_trainer/planning/path_planner.h"\n#include <vector>\n',
        HEADER + "planning/path_planner.h": "",
        "src/planning/path_planner.cpp": "#include <chrono>\n",
        "src/net/a.cpp": "#include <thread>\n",
    }, monkeypatch)


def test_the_excused_files_exist_and_need_their_excuse():
    for name, headers in check_layering.EXCUSED.items():
        included = {header for _, header, _ in check_layering.includes(ROOT / name)}
        assert set(headers) <= included, name
    assert all((ROOT / name).is_file() for name in check_layering.OTHER_THREADS)
