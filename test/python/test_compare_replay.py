"""Tests of scripts/compare_replay and, through it, of virtual_raven --replay: against a trace computed here from the
published axis map and increments, and against the recording of the real software where RAVEN2_TRAINER_DATA names the
folder that holds it.
"""

import csv
import gzip
import importlib.machinery
import importlib.util
import os
import pathlib
import subprocess
import sys

import numpy as np
import pytest

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "scripts/compare_replay"
PROGRAM = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build")) / "devel/lib/raven2_trainer/virtual_raven"


def load_script():
    loader = importlib.machinery.SourceFileLoader("compare_replay", str(SCRIPT))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("compare_replay", loader))
    loader.exec_module(module)
    return module


compare_replay = load_script()

HOME = np.array([np.radians(30), np.radians(90), 0.40, 0, 0, np.radians(45), np.radians(45)])
HEADER = (["t_s", "last_seq", "runlevel", "sublevel"] + [f"pos_d{k}" for k in range(6)] +
          [f"ori_d{k}" for k in range(18)] + [f"jpos_d{k}" for k in range(16)] + ["grasp_d0", "grasp_d1"])


def write(path, header, rows):
    with (gzip.open if str(path).endswith(".gz") else open)(path, "wt", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows(rows)


def run(replay, recording):
    return subprocess.run([SCRIPT, replay, recording], capture_output=True, text=True, check=False)


def synthetic_rows(count=200):
    """A recording of both arms turning their elbows, with joints and poses that agree."""
    rows = []
    for k in range(count):
        level = 3 if 20 <= k < count - 20 else 2
        q = HOME.copy()
        q[1] += np.radians(0.02 * max(0, k - 20))
        pos, ori, jpos = [], [], []
        for arm in (0, 1):
            pose = compare_replay.forward(arm, q[None])[0]
            pos += [int(round(v)) for v in pose[:3, 3] * 1e6]
            ori += [f"{v:.6f}" for v in pose[:3, :3].ravel()]
            jpos += [f"{np.degrees(q[j]):.5f}" if j is not None else "0" for j in (0, 1, 2, None, 3, 4, 5, 6)]
        rows.append([f"{k / 1000:.6f}", k + 1, level, 3, *pos, *ori, *jpos, "1.57000", "1.57000"])
    return rows


def test_forward_kinematics_gives_the_published_vectors():
    # raven2.md 2.4: 45, 100, 0.45, 30, 20, -15
    q = np.array([[np.radians(45), np.radians(100), 0.45, np.radians(30), np.radians(20), np.radians(15),
                   np.radians(-15)]])
    assert np.allclose(compare_replay.forward(0, q)[0, :3, 3], [-0.026873, -0.013929, 0.011894], atol=1e-6)
    assert np.allclose(compare_replay.forward(1, q)[0, :3, 3], [-0.028202, 0.014267, 0.007665], atol=1e-6)
    assert np.allclose(compare_replay.forward(0, q)[0, 0, :3], [-0.685219, -0.727957, 0.023512], atol=1e-6)


def test_a_recording_equals_itself_and_another_start(tmp_path):
    rows = synthetic_rows()
    write(tmp_path / "real.csv.gz", HEADER, rows)
    result = run(tmp_path / "real.csv.gz", tmp_path / "real.csv.gz")
    assert result.returncode == 0, result.stdout + result.stderr
    assert "DIFFERENT" not in result.stdout


def change(row, column, value):
    row = list(row)
    row[HEADER.index(column)] = value
    return row


@pytest.mark.parametrize("column, value, named", [
    ("pos_d4", lambda v: int(v) + 1, "displacement of pos_d green"),
    ("pos_d1", lambda v: "nan", "displacement of pos_d gold"),
    ("ori_d1", lambda v: float(v) + 0.01, "rotation of ori_d gold"),
    ("ori_d1", lambda v: "nan", "rotation of ori_d gold"),
    ("grasp_d0", lambda v: "1.56900", "grasp_d gold"),
    ("grasp_d1", lambda v: "nan", "grasp_d green"),
    ("jpos_d9", lambda v: float(v) + 0.02, "jpos_d by forward kinematics green"),
    ("runlevel", lambda v: 0, "run levels"),
    ("last_seq", lambda v: int(v) + 500, "packets used")])
def test_a_difference_is_found_and_named(tmp_path, column, value, named):
    rows = synthetic_rows()
    write(tmp_path / "real.csv", HEADER, rows)
    changed = [change(row, column, value(row[HEADER.index(column)])) if 100 <= k < 110 else row
               for k, row in enumerate(rows)]
    write(tmp_path / "ours.csv", HEADER, changed)
    result = run(tmp_path / "ours.csv", tmp_path / "real.csv")
    assert result.returncode == 1, result.stdout + result.stderr
    assert any(line.startswith(named) and "DIFFERENT" in line for line in result.stdout.splitlines()), result.stdout


@pytest.fixture(scope="module", name="recorded")
def recorded_rows():
    return synthetic_rows()


def compared(tmp_path, rows, column, shift, capsys):
    """Returns the names of the differences if a column is shifted in some rows after a pedal-down."""
    write(tmp_path / "real.csv", HEADER, rows)
    index = HEADER.index(column)
    write(tmp_path / "ours.csv", HEADER, [change(row, column, f"{float(row[index]) + shift:.6f}")
                                          if 100 <= k < 110 else row for k, row in enumerate(rows)])
    failed = compare_replay.compare(*(compare_replay.Trace(tmp_path / f"{name}.csv") for name in ("ours", "real")))
    lines = [line for line in capsys.readouterr().out.splitlines() if "DIFFERENT" in line]
    assert failed == bool(lines)
    return [line[:34].rstrip() for line in lines]


@pytest.mark.parametrize("strange", ["ours", "real"])
def test_a_packet_that_only_one_of_them_saw_is_found_whichever_it_is(tmp_path, recorded, strange, capsys):
    for name in ("ours", "real"):
        write(tmp_path / f"{name}.csv", HEADER, [change(row, "last_seq", 900) if k == 100 and name == strange else row
                                                 for k, row in enumerate(recorded)])
    assert compare_replay.compare(*(compare_replay.Trace(tmp_path / f"{name}.csv") for name in ("ours", "real")))
    assert "far from any common one: [900]" in capsys.readouterr().out


@pytest.mark.parametrize("sign", [-1, 1])
@pytest.mark.parametrize("arm, name", [(0, "gold"), (1, "green")])
def test_either_arm_is_compared_in_every_column_and_to_both_sides(tmp_path, recorded, arm, name, sign, capsys):
    joints = f"jpos_d by forward kinematics {name}"
    for k in range(3):  # the pose that jpos_d leads to is pos_d and ori_d, so that it differs, too
        assert compared(tmp_path, recorded, f"pos_d{3 * arm + k}", 2 * sign, capsys) == [
            f"displacement of pos_d {name}", joints]
    for k in range(9):
        assert f"rotation of ori_d {name}" in compared(tmp_path, recorded, f"ori_d{9 * arm + k}", 0.01 * sign, capsys)
    assert compared(tmp_path, recorded, f"grasp_d{arm}", 0.001 * sign, capsys) == [f"grasp_d {name}"]
    for k in (0, 1, 2, 4, 5, 6, 7):  # the fourth value is not a joint
        assert compared(tmp_path, recorded, f"jpos_d{8 * arm + k}", 0.5 * sign, capsys) == [joints], k
    assert compared(tmp_path, recorded, f"jpos_d{8 * arm + 3}", 0.5 * sign, capsys) == []


def test_what_is_below_the_last_digit_is_equal(tmp_path, recorded, capsys):
    for arm in (0, 1):
        for column, shift in ((f"pos_d{3 * arm}", 0.4), (f"ori_d{9 * arm}", 2e-6), (f"grasp_d{arm}", -4e-4)):
            assert compared(tmp_path, recorded, column, shift, capsys) == [], column


def test_a_place_is_counted_around_the_end_of_its_32_bits():
    turn, half = 2.0**32, 2.0**31
    assert compare_replay.wrapped(np.array([0.0, 5.0, -5.0, turn + 3, -turn - 3, half, -half])).tolist() == [
        0, 5, -5, 3, -3, -half, -half]


def test_an_angle_is_that_between_two_attitudes():
    for degrees in (0.0, 1e-4, 0.5, 60.0, 179.0):
        a = np.radians(degrees)
        about_x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
        assert compare_replay.angle_deg(np.array([about_x, about_x.T])) == pytest.approx([degrees] * 2, abs=1e-9)


def test_a_file_that_is_no_trace_is_refused(tmp_path):
    (tmp_path / "empty.csv").write_text("")
    (tmp_path / "short.csv").write_text("t_s,last_seq,runlevel\n1,2\n")
    for name in ("empty.csv", "short.csv", "missing.csv"):
        result = run(tmp_path / name, tmp_path / name)
        assert result.returncode == 2
        assert "Traceback" not in result.stderr


ITP = ("t_s,sequence,delx0,delx1,dely0,dely1,delz0,delz1,Qx0,Qx1,Qy0,Qy1,Qz0,Qz1,Qw0,Qw1,buttonstate0,buttonstate1,"
       "grasp0,grasp1,surgeon_mode,checksum,size,pactyp,version").split(",")
# raven2.md 1.4
MAP = (np.array([[0, 0, -1], [-1, 0, 0], [0, 1, 0]]), np.array([[0, 0, -1], [1, 0, 0], [0, -1, 0]]))


def trace_and_expectation():
    """Returns increments of both arms, with a duplicate, a gap, a short and a long datagram and a numbering reset. Also
    returns the rows that the published rules give, in the columns that can be computed without a robot."""
    rng = np.random.default_rng(3)
    packets, expected = [], []
    last, used = 0, 111
    pos = np.zeros((2, 3), int)
    for k in range(1600):
        number, size = k + 1, 124
        if k == 300:
            number = 300                      # duplicate
        if 400 <= k < 1500:
            number = k + 11                   # a gap: the robot drops the packet after it, too
        if k == 450:
            size = 123
        if k == 470:
            size = 134
        if k >= 1500:
            number = k - 1400                 # more than a thousand back
        dp = rng.integers(-20, 21, (2, 3)) if k >= 50 else np.zeros((2, 3), int)
        grasp = 3 if 100 <= k < 200 else 0
        packets.append([f"{5 + k / 1000:.6f}", number, dp[0, 0], dp[1, 0], dp[0, 1], dp[1, 1], dp[0, 2], dp[1, 2],
                        0, 0, 0, 0, 0, 0, 1, 1, 0, 0, grasp, grasp, 1, 0, size, 0, 0])
        in_order = size >= 124 and number == last + 1
        if size >= 124 and (number > last or number < last - 1000):
            last = number
        if in_order:
            used = number
            pos += np.array([MAP[arm] @ dp[arm] for arm in (0, 1)])
        opening = 1.57 - 0.003 * min(100, max(0, k - 99))
        expected.append([f"{5 + k / 1000:.6f}", used, 3 if k >= 4 else 2, 3, *pos.ravel(), *[""] * 34,
                         f"{opening:.5f}", f"{opening:.5f}"])
    return packets, expected


@pytest.mark.skipif(not PROGRAM.exists(), reason="virtual_raven is not built")
def test_replay_follows_the_published_rules(tmp_path):
    packets, expected = trace_and_expectation()
    write(tmp_path / "in.csv.gz", ITP, packets)
    os.rename(tmp_path / "in.csv.gz", tmp_path / "in.csv")  # gzip is recognised by content, not by name
    write(tmp_path / "real.csv", HEADER, expected)
    subprocess.run([PROGRAM, "--replay", tmp_path / "in.csv", "--output", tmp_path / "out.csv.gz", "--skip-homing"],
                   check=True, capture_output=True)
    result = run(tmp_path / "out.csv.gz", tmp_path / "real.csv")
    assert result.returncode == 0, result.stdout + result.stderr


@pytest.mark.skipif(not PROGRAM.exists(), reason="virtual_raven is not built")
def test_replay_names_file_and_line_of_a_bad_field(tmp_path):
    packets, _ = trace_and_expectation()
    packets[7][ITP.index("dely0")] = "12x"
    write(tmp_path / "in.csv", ITP, packets[:20])
    result = subprocess.run([PROGRAM, "--replay", tmp_path / "in.csv", "--output", tmp_path / "out.csv"],
                            capture_output=True, text=True, check=False)
    assert result.returncode == 1
    assert f"{tmp_path / 'in.csv'}:9: dely0 is \"12x\"" in result.stderr


@pytest.mark.skipif("RAVEN2_TRAINER_DATA" not in os.environ,
                    reason="RAVEN2_TRAINER_DATA does not name the folder with raven_software_traces")
@pytest.mark.skipif(not PROGRAM.exists(), reason="virtual_raven is not built")
@pytest.mark.parametrize("options", [["--skip-homing"], ["--homing", "full"]])
def test_replay_equals_the_real_software(tmp_path, options):
    folder = pathlib.Path(os.environ["RAVEN2_TRAINER_DATA"]) / "raven_software_traces"
    subprocess.run([PROGRAM, "--replay", folder / "T3.itp.csv.gz", "--output", tmp_path / "out.csv", *options],
                   check=True, capture_output=True)
    result = run(tmp_path / "out.csv", folder / "T3.state.csv.gz")
    assert result.returncode == 0, result.stdout + result.stderr
