"""plot_paths on a folder written by hand: which runs it draws, where it draws the scene, and that it makes pictures."""

import importlib.machinery
import importlib.util
import pathlib
import shutil

import numpy as np
import pytest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
HEADER = "samples,run,seed,success,reason,planning_time_s,tracking_time_s,waypoints,cost,planner,eta_length," \
         "eta_acceleration,eta_clearance,time_limit_s,path\n"


def load(path=ROOT / "scripts" / "plot_paths"):
    loader = importlib.machinery.SourceFileLoader("plot_paths", str(path))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("plot_paths", loader))
    loader.exec_module(module)
    return module


plot = load()


def track(folder, stem, bow):
    s = np.linspace(0, 1, 50)
    points = np.stack([0.05 - 0.04 * s, 0.035 * (1 - s), 0.02 + bow * s * (1 - s)], axis=1)
    lines = ["time_s,waypoint,x_m,y_m,z_m"] + [f"{0.002 * i:.3f},0,{p[0]},{p[1]},{p[2]}" for i, p in enumerate(points)]
    (folder / "paths" / (stem + ".csv")).write_text("\n".join(lines) + "\n")


def run(samples, number, cost, eta_clearance=0.0, planner="FMTstar", eta=(0.1, 0.5), success=1, limit=5):
    path = f"n{samples}_c{eta_clearance:g}_e{eta[0]:g}_t{limit:g}_r{number}" if success else ""
    cells = [samples, number, number, success, "success" if success else "no_path", 0.1, 3 if success else "",
             4 if success else "", cost if success else "", planner, *eta, eta_clearance, limit, path]
    return ",".join(map(str, cells)) + "\n", path


def write(folder, name, runs):
    (folder / "paths").mkdir(exist_ok=True)
    (folder / name).write_text(HEADER + "".join(line for line, _ in runs))
    for i, path in enumerate(path for _, path in runs if path):
        track(folder, path, 0.02 + 0.01 * i)


def test_the_run_in_the_middle_is_drawn_and_failures_are_not(tmp_path):
    write(tmp_path, "runs.csv", [run(200, 1, 9.0), run(200, 2, 0.0, success=0), run(200, 3, 5.0), run(200, 4, 7.0),
                                 run(500, 1, 2.0), run(500, 2, 1.0), run(500, 1, 0.5, eta_clearance=0.1),
                                 run(1000, 1, 0.0, success=0)])
    rows = plot.read_rows(tmp_path / "runs.csv")
    chosen = plot.by_samples(rows)
    assert {n: row["cost"] for n, row in chosen.items()} == {200: 7.0, 500: 1.0}
    assert plot.median_run([rows[1]]) is None
    assert rows[1]["cost"] is None and rows[1]["reason"] == "no_path"


def test_of_several_times_the_longest_is_drawn(tmp_path):
    write(tmp_path, "runs.csv", [run(200, 1, 9.0, limit=0.1), run(200, 2, 8.5, limit=0.1), run(200, 1, 7.0, limit=10),
                                 run(200, 2, 6.0, limit=10), run(200, 3, 5.0, limit=10), run(500, 1, 4.0, limit=0.1),
                                 run(500, 1, 0.0, limit=10, success=0),
                                 run(200, 1, 1.0, planner="BITstar", limit=10)])
    chosen = plot.by_samples(plot.read_rows(tmp_path / "runs.csv"))
    assert {n: (row["cost"], row["time_limit_s"]) for n, row in chosen.items()} == {200: (6.0, 10.0)}


def test_planners_without_samples_are_named_instead(tmp_path):
    write(tmp_path, "runs.csv", [run(200, 1, 9.0), run(500, 1, 8.0, planner="FMT"), run(200, 1, 7.0, planner="BITstar")])
    rows = plot.read_rows(tmp_path / "runs.csv")
    labels = [plot.figure8_label(int(row["samples"]), row) for row in rows]
    assert labels == ["n = 200, cost 9", "n = 500, cost 8", "BITstar, cost 7"]


def test_pictures_come_of_a_study(tmp_path, capsys):
    write(tmp_path, "runs.csv", [run(200, 1, 9.0), run(500, 1, 5.0)])
    write(tmp_path, "figure7.csv", [run(500, 1, 3.0, eta=(1, 0)), run(500, 1, 2.0, eta=(0, 1))])
    track(tmp_path, "straight", 0.0)
    (tmp_path / "comparison.csv").write_text(
        "planner,samples,time_s,runs,success_percent,cost_mean,cost_deviation,cost_median\n"
        "FMTstar,500,0.1,20,95,0.09,0.01,0.089\nFMTstar,500,1,20,100,0.09,0.01,0.089\n"
        "BITstar,,0.1,20,0,,,\nBITstar,,1,20,100,0.1,0.02,0.099\n")
    assert plot.main([str(tmp_path)]) == 0
    pictures = [f"{tmp_path}/{name}.png" for name in ("figure7", "figure8", "comparison")]
    assert capsys.readouterr().out.splitlines() == pictures
    for picture in pictures:
        assert pathlib.Path(picture).read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
        assert pathlib.Path(picture).stat().st_size > 20000


def test_each_path_has_the_name_of_its_cost(tmp_path, monkeypatch):
    write(tmp_path, "figure7.csv", [run(500, 1, 3.0, eta=(1, 0)), run(500, 1, 2.0, eta=(0, 1))])
    drawn = []
    monkeypatch.setattr(plot, "draw_paths", lambda plt, title, tracks, *rest: drawn.extend(label for _, _, label in tracks))
    plot.figure7(None, str(tmp_path), [])
    assert drawn == ["shortest path, 4 waypoints", "smoothest path, 4 waypoints"]


def test_several_studies_make_one_picture(tmp_path, capsys):
    folders = []
    for name in ("easy", "hard", "impossible"):
        folders.append(tmp_path / name)
        folders[-1].mkdir()
        write(folders[-1], "runs.csv", [run(200, 1, 9.0, success=int(name != "impossible"))])
    picture = tmp_path / "all.png"
    assert plot.main([*map(str, folders), "--together", str(picture)]) == 0
    assert capsys.readouterr().out.splitlines() == [str(picture)]
    assert picture.stat().st_size > 20000
    assert not list(folders[0].glob("*.png"))


def test_a_study_without_success_is_told_and_no_error(tmp_path, capsys):
    write(tmp_path, "runs.csv", [run(200, 1, 0.0, success=0)])
    assert plot.main([str(tmp_path)]) == 0
    assert "nothing to draw" in capsys.readouterr().err
    assert not list(tmp_path.glob("*.png"))


@pytest.mark.parametrize("spoil", [lambda folder: (folder / "runs.csv").unlink(),
                                   lambda folder: (folder / "runs.csv").write_text("a,b\n1,2\n"),
                                   lambda folder: next((folder / "paths").iterdir()).unlink()])
def test_what_is_missing_is_told_in_a_line(tmp_path, capsys, spoil):
    write(tmp_path, "runs.csv", [run(200, 1, 9.0)])
    spoil(tmp_path)
    assert plot.main([str(tmp_path)]) == 1
    assert capsys.readouterr().err.startswith("plot_paths: ")


def test_the_scene_is_where_the_urdf_says(tmp_path):
    scene = tmp_path / "scene.urdf"
    scene.write_text("""<robot name="s"><link name="world"/><link name="a"/>
      <link name="peg">
      <collision><origin xyz="0 0 0.1" rpy="0 1.570796326794897 0"/>
      <geometry><cylinder radius="0.01" length="0.2"/></geometry></collision>
      <collision><geometry><box size="2 4 6"/></geometry></collision></link>
      <joint name="j" type="fixed"><parent link="world"/><child link="a"/><origin xyz="1 0 0"/></joint>
      <joint name="k" type="fixed"><parent link="a"/><child link="peg"/>
      <origin xyz="0 2 0" rpy="0 0 1.570796326794897"/></joint></robot>""")
    lines = plot.scene_lines(scene)
    assert {link for link, _ in lines} == {"peg"} and len(lines) == 1 + 12
    # the cylinder's axis: z of its shape is x of the link, which is y of W
    assert np.allclose(sorted(lines[0][1].tolist()), [[1, 1.9, 0.1], [1, 2.1, 0.1]])
    edges = np.array([line for _, line in lines[1:]])
    assert np.allclose(edges.reshape(-1, 3).min(axis=0), [-1, 1, -3])  # rotated: 4 along x of W, 2 along y
    assert np.allclose(edges.reshape(-1, 3).max(axis=0), [3, 3, 3])
    lengths = sorted(np.linalg.norm(edges[:, 0] - edges[:, 1], axis=1).round(9))
    assert lengths == [2] * 4 + [4] * 4 + [6] * 4


def test_a_scene_that_cannot_be_read_is_told(tmp_path, capsys):
    write(tmp_path, "runs.csv", [run(200, 1, 9.0)])
    assert plot.main([str(tmp_path), "--scene", str(tmp_path / "none.urdf")]) == 1
    assert "none.urdf" in capsys.readouterr().err


def test_the_shipped_scene_has_its_parts():
    links = {link for link, _ in plot.scene_lines(plot.SCENE)}
    assert {"dome_wall", "dome_lid", "wire_left", "wire_right", "ring", "ring_stand"} <= links
    assert not links & plot.HIDDEN


def test_the_installed_program_finds_the_scene(tmp_path, monkeypatch):
    """As the package has them: lib/raven2_trainer/plot_paths, share/raven2_trainer/urdf."""
    monkeypatch.setattr("sys.dont_write_bytecode", True)
    program, scene = tmp_path / "lib/raven2_trainer/plot_paths", tmp_path / "share/raven2_trainer/urdf/frs_trainer.urdf"
    for file, source in ((program, ROOT / "scripts/plot_paths"), (scene, ROOT / "urdf/frs_trainer.urdf")):
        file.parent.mkdir(parents=True)
        shutil.copy(source, file)
    assert pathlib.Path(load(program).SCENE).resolve() == scene.resolve()
