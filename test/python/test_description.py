"""The committed URDFs, meshes and roles equal the output of their parametric source. Files made by hand are kept."""

import pathlib
import shutil
import subprocess
import sys

import forked
import numpy  # noqa: F401  (loaded once, for all runs)
import pytest
import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
SOURCES = ["scripts/generate_description", "scripts/description", "meshes/dimensions.yaml", "meshes/scenes",
           "config/arms.yaml"]


def run(root, *arguments):
    return forked.run(root / "scripts/generate_description", *arguments)


@pytest.fixture
def package(tmp_path):
    """A package with the files that the script reads, without the files that it writes."""
    for name in SOURCES:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (shutil.copytree if (ROOT / name).is_dir() else shutil.copy)(ROOT / name, tmp_path / name)
    return tmp_path


def scene(package, elements):
    """Adds a scene of these elements to the package."""
    data = {"title": "a test", "source": "ours", "parking": False, "elements": elements, "points": {}, "regions": {}}
    (package / "meshes/scenes/probe.yaml").write_text(yaml.safe_dump(data))


def test_committed_description_equals_the_generated_one():
    result = subprocess.run([sys.executable, ROOT / "scripts/generate_description", "--check"], capture_output=True,
                            text=True)
    assert result.returncode == 0, result.stdout + result.stderr


def test_written_from_nothing_it_is_the_committed_one(package):
    assert run(package).returncode == 0
    for pattern in ("urdf/*.urdf", "urdf/*.srdf", "meshes/*.stl", "config/scenes/*.yaml"):
        names = {p.name for p in package.glob(pattern)}
        ours = {p.name for p in ROOT.glob(pattern) if b"Made by hand" not in p.read_bytes()}
        assert names == ours and names
        for path in package.glob(pattern):
            assert path.read_bytes() == (ROOT / path.relative_to(package)).read_bytes(), path.name


def test_what_was_made_by_hand_is_spared_and_what_is_no_longer_written_is_removed(package):
    scene(package, [{"kind": "plate"}])
    assert run(package).returncode == 0
    mine = {"urdf/mine.urdf": '<?xml version="1.0"?>\n<robot name="mine"><link name="world"/></robot>\n',
            "config/scenes/mine.yaml": "title: mine\n", "meshes/mine.stl": "solid mine\nendsolid mine\n"}
    for name, text in mine.items():
        (package / name).write_text(text)
    (package / "meshes/scenes/probe.yaml").unlink()
    assert "urdf/probe.urdf" in run(package, "--check").stdout
    assert run(package).returncode == 0
    assert {name: (package / name).read_text() for name in mine} == mine
    assert not (package / "urdf/probe.urdf").exists() and not (package / "config/scenes/probe.yaml").exists()
    assert run(package, "--check").returncode == 0


def test_an_element_has_the_dimensions_given_or_those_of_its_kind(package):
    scene(package, [{"kind": "tower", "name": "tower_a", "at": [0.01, 0.02], "colour": "tower_blue", "height": 0.05,
                     "mesh": "tall"},
                    {"kind": "tower", "name": "tower_b", "at": [0.03, 0.02], "colour": "tower_blue",
                     "breaks": {"force": 2.0, "moment": 0.1, "ticks": 3}}])
    assert run(package).returncode == 0
    roles = yaml.safe_load((package / "config/scenes/probe.yaml").read_text())
    assert roles["pegs"]["a"] == {"link": "tower_a", "base_W": [0.01, 0.02, 0], "height": 0.05, "radius": 0.004}
    assert roles["pegs"]["b"]["height"] == 0.026
    assert roles["breakables"] == [{"link": "tower_b", "force": 2, "moment": 0.1, "ticks": 3}]
    assert (package / "urdf/probe.urdf").read_text().count("<inertial>") == 1


@pytest.mark.parametrize("element,says", [
    ({"kind": "castle"}, "kind is castle"),
    ({"kind": "tower", "name": "t", "colour": "tower_blue"}, "at is missing"),
    ({"kind": "tower", "name": "t", "at": [0, 0], "colour": "tower_blue", "hight": 1}, "unknown key hight"),
    ({"kind": "round_ring", "name": "r", "at": [0, 0, 0], "colour": "mauve"}, "no colour is called mauve"),
    ({"kind": "tower", "name": "t", "at": [0, 0], "colour": "tower_blue", "height": 0.05, "mesh": "plate"},
     "are called plate"),
])
def test_wrong_elements_are_refused(package, element, says):
    scene(package, [{"kind": "plate"}, element])
    result = run(package)
    assert result.returncode != 0 and "probe.yaml" in result.stderr and says in result.stderr, result.stderr


def test_more_bodies_than_the_programs_have_room_for_are_refused(package):
    rings = [{"kind": "round_ring", "name": f"ring_{i}", "at": [0, 0, 0.01 * i], "colour": "ring_red"}
             for i in range(13)]
    scene(package, rings)
    assert "more than 12 bodies" in run(package).stderr
