"""Tests recorded simulations: equal bytes from the program simulate, files of a session, and campaigns."""

import json
import pathlib
import subprocess
import tempfile

import numpy as np
import pytest

from built_module import BUILD, PICK, ROOT, raven2_trainer


def test_a_recorded_simulation_has_the_bytes_of_simulate(tmp_path):
    subprocess.run([BUILD / "devel/lib/raven2_trainer/simulate", "--exercise", PICK, "--motion", "expert", "--seed", "3", "--seconds", "2",
                    "--homing", "quick", "--output", tmp_path / "program"], check=True, capture_output=True)
    with raven2_trainer.Simulation(PICK, motion="expert", seed=3, output=tmp_path / "python") as simulation:
        while simulation.state.session_tick + 1 < 2000:
            simulation.step()
    assert (tmp_path / "python/session.rlog").read_bytes() == (tmp_path / "program/session.rlog").read_bytes()


def test_a_recorded_simulation_has_its_start_time_from_the_start_and_its_duration_at_the_end(tmp_path):
    def meta():
        return json.loads((tmp_path / "session/meta.json").read_text())

    simulation = raven2_trainer.Simulation(robot="none", output=tmp_path / "session")
    begun = meta()
    simulation.step(ticks=100)
    simulation.close()
    assert (begun["program"], begun["realtime"]) == ("python", "unknown: not ended cleanly")
    assert meta()["start_time_utc"] == begun["start_time_utc"] and meta()["realtime"] == "lockstep"
    assert meta()["wall_duration_s"] > begun["wall_duration_s"] >= 0


def test_simulate_does_the_recorded_commands_with_the_same_bytes(tmp_path):
    random = np.random.default_rng(4)
    with raven2_trainer.Simulation(PICK, hazard="sudden_jump", seed=5, output=tmp_path / "python") as simulation:
        simulation.start()
        for i in range(40):
            arms = {arm: {"move": random.uniform(-2e-3, 2e-3, 3), "turn": random.uniform(-0.1, 0.1, 3), "jaw": random.uniform(0.0, 1.0)}
                    for arm in ("gold", "green")}
            simulation.step({**arms, "pedal": i % 7 != 6}, ticks=int(random.integers(1, 80)))
        joints = np.array(simulation.state.joints)
        joints[:, 2] += 0.004
        simulation.step({"gold": {"joints": joints[0]}, "green": {"joints": joints[1]}}, ticks=300)
    subprocess.run([BUILD / "devel/lib/raven2_trainer/simulate", "--exercise", PICK, "--drill", "sudden_jump", "--seed", "5", "--homing", "quick",
                    "--motion", f"commands:{tmp_path / 'python/commands.csv'}", "--output", tmp_path / "program"], check=True, capture_output=True)
    assert (tmp_path / "python/session.rlog").read_bytes() == (tmp_path / "program/session.rlog").read_bytes()


def test_commands_that_end_before_the_robot_is_ready_are_done_alike(tmp_path):
    with raven2_trainer.Simulation(seed=5, output=tmp_path / "python") as simulation:
        simulation.step({"gold": {"move": [0, 0, 1e-3], "jaw": 0.6}}, ticks=100)
    subprocess.run([BUILD / "devel/lib/raven2_trainer/simulate", "--seed", "5", "--hazard", "none", "--motion",
                    f"commands:{tmp_path / 'python/commands.csv'}", "--output", tmp_path / "program"], check=True, capture_output=True)
    assert (tmp_path / "python/session.rlog").read_bytes() == (tmp_path / "program/session.rlog").read_bytes()


@pytest.mark.parametrize("options, says", [
    (["--homing", "full"], "without --homing full"), (["--replay", "x"], "without --homing full and --replay"),
    (["--reaction", "400"], "heeds no force")])
def test_simulate_refuses_what_would_change_the_commands(tmp_path, options, says):
    file = ROOT / "test/fuzz/seeds/recording/commands"
    ended = subprocess.run([BUILD / "devel/lib/raven2_trainer/simulate", "--motion", f"commands:{file}", *options, "--output", tmp_path / "x"],
                           check=False, capture_output=True, text=True)
    assert ended.returncode != 0 and says in ended.stderr and not (tmp_path / "x").exists()
    with pytest.raises(ValueError, match="only the program simulate"):
        raven2_trainer.Simulation(motion=f"commands:{file}")


def test_a_simulation_that_could_not_be_made_leaves_nothing_behind(tmp_path):
    raven2_trainer.Simulation(output=tmp_path / "session").close()
    for _ in range(3):
        with pytest.raises(raven2_trainer.SessionError, match="session"):
            raven2_trainer.Simulation(output=tmp_path / "session")
        with raven2_trainer.Simulation(robot="none") as simulation:
            simulation.step(ticks=5)
            assert np.isfinite(simulation.state.joints).all()


def test_a_recording_ends_where_it_began_and_says_so_if_it_cannot(tmp_path, monkeypatch):
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path)
    simulation = raven2_trainer.Simulation(output="made")
    simulation.start()
    simulation.step(ticks=50)
    monkeypatch.chdir(tmp_path / "elsewhere")
    simulation.close()
    assert (tmp_path / "made/metrics.json").exists() and not list((tmp_path / "elsewhere").iterdir())
    lost = raven2_trainer.Simulation(output=tmp_path / "lost")
    lost.start()
    (tmp_path / "lost").rename(tmp_path / "away")
    for _ in range(2):
        with pytest.raises(raven2_trainer.SessionError, match="lost"):
            lost.close()


def test_one_exception_is_for_sessions_that_cannot_be_read_or_written(tmp_path):
    (tmp_path / "file").touch()
    for use in (lambda: raven2_trainer.Session(tmp_path / "none"),
                lambda: raven2_trainer.Simulation(output=tmp_path / "file" / "session")):
        with pytest.raises(raven2_trainer.SessionError) as refused:
            use()
        assert isinstance(refused.value, RuntimeError) and str(tmp_path) in str(refused.value)


def test_a_session_is_read_as_arrays(tmp_path):
    with raven2_trainer.Simulation(motion="scripted", robot="virtual", output=tmp_path / "session") as simulation:
        while simulation.state.session_tick < 300:
            simulation.step(ticks=10)
        last = simulation.state.joints.copy()
    session = raven2_trainer.Session(str(tmp_path / "session"))
    ticks = session.log.ticks
    assert np.array_equal(ticks["model"]["arms"]["q"][-1], last)
    table = session.table()
    assert [table[f"model.arms.1.q.{joint}"][-1] for joint in range(7)] == last[1].tolist()
    assert all(column.shape == ticks.shape and column.dtype.names is None for column in table.values())
    assert len(session.table("commands")["command.sequence"]) == len(session.log.commands) > 0


def test_a_campaign_is_defined_run_and_read(tmp_path):
    fault = {"host": "robot", "site": "put_usb_packet", "variable": "dac", "kind": "stuck_at", "arm": ["gold", "green"], "channel": "shoulder",
             "value": [-20000, 0], "start": {"trigger": "pedal_down", "first_tick": 300}, "duration_ticks": 100}
    campaign = raven2_trainer.Campaign({
        "name": "four", "title": "Four", "source": "none", "plant": "identified", "homing": "quick", "arm_contacts": False, "cpu_limit": 20,
        "horizon_ticks": {"homing": 300, "pedal_down": 400}, "limits": {"masked": 1e-4, "jump": 1e-3, "still": 3e-4, "moved": 1e-3, "force": 0.05},
        "scenarios": [{"scenario": "dac", "injection": 0, "number": 0, "observed": "none", "published": [], "phase": "pedal_down",
                       "repetitions": 1, "faults": [fault]}]})
    rows = campaign.run(tmp_path / "out", seed=2)
    assert [row["run"] for row in rows] == [1, 2, 3, 4]
    assert {row["outcome"] for row in rows if row["value"] == -20000} <= {"estop", "unsafe_jump"}
    assert raven2_trainer.outcomes(tmp_path / "out") == rows
    for other in (campaign, raven2_trainer.Campaign("no_such_campaign")):
        with pytest.raises(RuntimeError, match="holds a campaign|no campaign|no_such"):
            other.run(tmp_path / "out", seed=99)
    assert [path.name for path in tmp_path.iterdir()] == ["out"], "nothing is left next to it"
    (tmp_path / "out/outcomes.csv").write_text("run,outcome\n")
    assert campaign.run(tmp_path / "out", seed=2, resume=True) == rows, "the finished runs are read, the table is written again"
    elsewhere = raven2_trainer.Campaign({"name": "../elsewhere", "cpu_limit": np.int64(3)})
    with pytest.raises(RuntimeError, match="name holds a /"):
        elsewhere.run(tmp_path / "none")
    assert not list(pathlib.Path(tempfile.gettempdir()).glob("elsewhere*"))
    with pytest.raises(RuntimeError, match="no campaign|nowhere"):
        raven2_trainer.Campaign("nowhere").run(tmp_path / "none")


def test_a_relative_configuration_outlives_a_change_of_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(ROOT)
    simulation = raven2_trainer.Simulation(config="config/trainer.yaml", robot="none", output=tmp_path / "s")
    monkeypatch.chdir(tmp_path)
    simulation.start()
    simulation.close()
    session = raven2_trainer.Session("s")
    assert session.meta["realtime"] == "lockstep"
    monkeypatch.chdir("/")
    assert session.file("commands.csv")


@pytest.mark.parametrize("record, field", [("ticks", "model.mode"), ("tick", "model.mood"), ("tick", "model.tick")])
def test_a_name_that_a_log_does_not_have_is_said(tmp_path, record, field):
    raven2_trainer.Simulation(robot="none", output=tmp_path / "s").close()
    log = raven2_trainer.Session(tmp_path / "s").log
    with pytest.raises(ValueError, match="ticks|mood|model.tick"):
        log.names(record, field)


def test_a_campaigns_wrong_seed_is_said(tmp_path):
    for seed in (-1, 2**64, 1.5, True, "1"):
        with pytest.raises(ValueError, match="seed is"):
            raven2_trainer.Campaign({"name": "x"}).run(tmp_path / "out", seed=seed)
