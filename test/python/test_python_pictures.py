"""Tests the pictures, depths and parts that a Simulation renders."""

import numpy as np
import pytest

from built_module import PICK, raven2_trainer


def test_a_picture_shows_the_motion_of_a_tool(ready):
    first = ready.render("endoscope", 320, 240)
    assert first.shape == (240, 320, 3) and first.dtype == np.uint8 and first.std() > 10
    assert np.array_equal(ready.render("endoscope", 320, 240), first), "the same state, the same pixels"
    ready.step({"gold": {"move": [0.01, 0, 0]}}, ticks=400)
    assert np.abs(ready.render("endoscope", 320, 240).astype(int) - first).max() > 50
    assert {"overview", "endoscope", "top"} <= set(ready.cameras)


def test_pictures_show_what_a_hazard_of_the_video_does():
    with raven2_trainer.Simulation(PICK) as simulation:
        simulation.start()
        clear = simulation.render("endoscope", 80, 60)
        simulation.inject("video_loss")
        simulation.step(ticks=100)
        assert simulation.state.hazard and not simulation.render("endoscope", 80, 60).any() and not simulation.render("top", 80, 60).any()
        simulation.clear_hazards()
        simulation.step(ticks=100)
        assert np.abs(simulation.render("endoscope", 80, 60).astype(int) - clear).max() < 100
        simulation.inject("video_freeze")
        simulation.step(ticks=50)
        frozen, before = simulation.render("endoscope", 80, 60), simulation.save()
        simulation.step({"gold": {"move": [0, 0, 0.02]}}, ticks=400)
        assert np.array_equal(simulation.render("endoscope", 80, 60), frozen)
        simulation.clear_hazards()
        simulation.step(ticks=100)
        assert not np.array_equal(simulation.render("endoscope", 80, 60), frozen), "the tool has moved"
        simulation.restore(before)
        assert np.array_equal(simulation.render("endoscope", 80, 60), frozen), "a snapshot has the frozen picture"


@pytest.mark.parametrize("arguments, says", [(("endoscop",), "endoscop"), (("top", 0, 10), "expected 1 to 4096"), (("top", 10, 5000), "expected 1 to 4096")])
def test_a_wrong_picture_is_refused(ready, arguments, says):
    with pytest.raises(ValueError, match=says):
        ready.render(*arguments)


def test_depth_and_parts_are_those_of_the_scene(ready):
    """Seen from above: the back-projected pixels of the ring are at the ring's position."""
    depth, part = ready.measure("top", 640, 480)
    assert depth.shape == part.shape == (480, 640) and depth.dtype == np.float32
    assert np.isinf(depth[part == 0]).all() and np.isfinite(depth[part > 0]).all()
    ring = part == ready.part_names.index(ready.object_names[0])
    assert ring.sum() > 10
    focal = 240 / np.tan(0.3)  # config/render.yaml: 1.5 m above the middle, vertical_fov 0.6, up is x of the world
    v, u = np.nonzero(ring)
    z = depth[ring]
    seen = np.stack([-(v - 239.5) * z / focal, -(u - 319.5) * z / focal, 1.5 - z])
    middle = (seen.min(axis=1) + seen.max(axis=1)) / 2
    assert middle[:2] == pytest.approx(ready.state.objects[0, :2], abs=0.004)
    assert abs(seen[2].mean() - ready.state.objects[0, 2]) < 0.03
    names = {ready.part_names[i] for i in np.unique(part)}
    assert any("_L" in name for name in names) and any("_R" in name for name in names), names
