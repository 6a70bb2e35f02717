"""Tests the settings and the configuration of a Simulation, and the texts that refuse wrong ones."""

import shutil
import subprocess

import numpy as np
import pytest

from built_module import BUILD, ROOT, raven2_trainer


def test_wrong_settings_are_refused_with_the_programs_texts():
    with pytest.raises(raven2_trainer.ConfigError, match="did you mean"):
        raven2_trainer.Simulation("pick_hand_over_plase")
    with pytest.raises(raven2_trainer.ConfigError, match="did you mean"):
        raven2_trainer.Simulation(hazard="suden_jump")
    for settings in ({"robot": "real"}, {"seed": -1}, {"seed": 1.5}):
        with pytest.raises(ValueError):
            raven2_trainer.Simulation(**settings)
    for settings in ({"output": "/tmp/a\0b"}, {"output": b"/tmp/a\0b"}, {"config": "config\0/trainer.yaml"}):
        with pytest.raises(ValueError, match="null characters"):
            raven2_trainer.Simulation(**settings)
    with pytest.raises(ValueError, match="output is .* null characters"):
        raven2_trainer.VectorSimulation(2, output="/tmp/a\0b")
    for settings in ({"link": "wan\0.yaml"}, {"plant": "more_friction\0"}):
        with pytest.raises(ValueError, match="null characters"):
            raven2_trainer.Simulation(**settings)
    for settings in ({"output": False}, {"output": 3}, {"config": []}):
        with pytest.raises(TypeError):
            raven2_trainer.Simulation(**settings)
    for seed in (True, "1", None, 2**64, 1.5):
        with pytest.raises(ValueError, match="seed is"):
            raven2_trainer.Simulation(seed=seed)
        with pytest.raises(ValueError, match="seed is"):
            raven2_trainer.VectorSimulation(2, seed=seed)
    with pytest.raises(ValueError, match="seed is"):
        raven2_trainer.VectorSimulation(2, seed=2**64 - 1)
    for name in ("n", "threads"):
        for value in (0, -1, True, 2.5, "2", 2**32):
            with pytest.raises(ValueError, match=f"{name} is"):
                raven2_trainer.VectorSimulation(**{"n": 2, name: value})


def moved(**options):
    """Joints after a short fast motion of the gold arm, and after a rest."""
    with raven2_trainer.Simulation(**options) as simulation:
        simulation.start()
        simulation.step({"gold": {"move": [0, 0.02, 0]}}, ticks=100)
        fast = simulation.state.joints[0].copy()
        simulation.step(ticks=400)
        return fast, simulation.state.joints[0].copy(), simulation.state.robot_joints[0].copy()


def test_settings_plant_and_link_change_what_they_name():
    usual = moved()
    sticky = moved(settings={"model/coulomb_friction": np.array([4.0, 4.0, 9.0, 0, 0, 0, 0])})
    assert np.abs(sticky[0] - usual[0])[:2].min() > 0.01, "both joints lag by their friction"
    worn = moved(plant="more_friction")
    assert np.abs(worn[2] - usual[2])[:3].max() > 1e-4
    late = moved(link="wan")
    assert np.abs(late[0] - usual[0]).max() > 1e-4 and np.array_equal(late[1], moved(link="wan")[1])


def test_a_link_is_that_of_the_own_configuration(tmp_path):
    for part in ("config", "urdf", "meshes"):
        (tmp_path / part).symlink_to(ROOT / part) if part != "config" else shutil.copytree(ROOT / part, tmp_path / part)
    path = tmp_path / "config/impairments/wan.yaml"
    path.write_text(path.read_text().replace("constant_ms: 40.0", "constant_ms: 400.0"))

    def late(**options):
        with raven2_trainer.Simulation(robot="none", link="wan", **options) as simulation:
            simulation.start()
            before = simulation.state.desired_joints.copy()
            simulation.step({"gold": {"move": [0, 0, 0.005]}}, ticks=50)
            simulation.step(ticks=100)
            return np.array_equal(simulation.state.desired_joints, before)

    assert late(config=tmp_path / "config/trainer.yaml") and not late()


def test_settings_that_are_not_good_are_refused_with_their_key():
    for settings, says in (({"model/contact_mo": 1}, r"model/contact_mo|contact_mo"), ({"model/contact_mu": -1}, r"contact_mu"),
                           ({"model/contact_mu": float("nan")}, "contact_mu"), ({"injection/enable": False}, "files alone"),
                           ({"model/viscous_friction": [1, 2]}, "viscous_friction")):
        with pytest.raises(raven2_trainer.ConfigError, match=says):
            raven2_trainer.Simulation(settings=settings)
    for options in ({"plant": "wood"}, {"link": "string"}, {"motion": "expert"}, {"motion": "clumsy:bear"}, {"motion": "dance"}):
        with pytest.raises(raven2_trainer.ConfigError, match="wood|string|needs an exercise|dance"):
            raven2_trainer.Simulation(**options)
    with pytest.raises(ValueError, match="robot is 'none'"):
        raven2_trainer.Simulation(robot="none", plant="worn_tool")


def test_what_is_wrong_with_a_model_is_said_as_by_the_program(tmp_path):
    for part in ("config", "urdf"):
        shutil.copytree(ROOT / part, tmp_path / part)
    (tmp_path / "meshes").symlink_to(ROOT / "meshes")
    scene = tmp_path / "urdf/frs_trainer.urdf"
    scene.write_text(scene.read_text().replace('<collision name="', '<collision name="wooden_', 1))
    root = tmp_path / "config/trainer.yaml"
    with pytest.raises(raven2_trainer.ModelError, match="expected a material of config/model.yaml") as refused:
        raven2_trainer.Simulation(config=root)
    done = subprocess.run([BUILD / "devel/lib/raven2_trainer/simulate", "--config", root, "--seconds", "1", "--output", tmp_path / "session"],
                          capture_output=True, text=True, check=False)
    assert done.returncode == 1 and str(refused.value).split(": ", 1)[1] in done.stderr
    robot = tmp_path / "urdf/raven2.urdf"
    robot.write_text(robot.read_text().replace("</robot>", ""))
    with pytest.raises(raven2_trainer.ModelError, match="raven2.urdf"):
        raven2_trainer.Planner(config=root)
