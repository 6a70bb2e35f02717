"""The program kinematics: tables in, tables out. Needs the built program, in $RAVEN2_TRAINER_BUILD or build/."""

import csv
import io
import math
import os
import pathlib
import random
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build"))
PROGRAM = BUILD / "devel/lib/raven2_trainer/kinematics"

JOINTS = [f"J{i}" for i in range(1, 8)]
POSE = ["x", "y", "z"] + [f"r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)]
HOME = [math.pi / 6, math.pi / 2, 0.40, 0.0, 0.0, math.pi / 4, math.pi / 4]


def run(*arguments, text="", code=0):
    result = subprocess.run([PROGRAM, *arguments], input=text.encode(), capture_output=True, timeout=120, check=False)
    assert result.returncode == code, result.stderr.decode()
    return result


def table(columns, rows, end="\n"):
    return end.join([",".join(columns)] + [",".join(repr(v) for v in row) for row in rows]) + end


def convert(*arguments, columns, rows):
    out = run(*arguments, text=table(columns, rows)).stdout.decode()
    return list(csv.DictReader(io.StringIO(out)))


def numbers(row, columns):
    return [float(row[c]) for c in columns]


def random_joints(count):
    rng = random.Random(4)
    low = [0.0, 0.79, 0.23, -3.1, -1.2, -0.9, -0.9]
    high = [1.57, 2.35, 0.44, 3.1, 1.2, 0.9, 0.9]  # below the remote centre: no wrist within lw of it
    return [[rng.uniform(a, b) for a, b in zip(low, high)] for _ in range(count)]


def inverse_rows(arm, joints, current, *options):
    """Rows of inverse for the poses of `joints`."""
    poses = convert("forward", "--arm", arm, *options, columns=JOINTS, rows=joints)
    return [numbers(p, POSE) + [q[5] + q[6]] + now for p, q, now in zip(poses, joints, current)]


@pytest.mark.parametrize("arm,y", [("gold", -0.025266), ("green", 0.025266)])
def test_forward_gives_the_robots_published_home_pose(arm, y):
    row = convert("forward", "--arm", arm, columns=JOINTS, rows=[HOME])[0]
    assert numbers(row, ["x", "y", "z"]) == pytest.approx([-0.077947, y, 0.013226], abs=1e-6)
    assert numbers(row, ["r11", "r33"]) == pytest.approx([-0.939120, -0.203952], abs=1e-6)
    assert list(row) == POSE


@pytest.mark.parametrize("arm", ["gold", "green"])
@pytest.mark.parametrize("tool", ["raven_grasper", "da_vinci", "raven2_sim"])
def test_inverse_undoes_forward(arm, tool):
    joints = random_joints(500)
    rows = inverse_rows(arm, joints, joints, "--tool", tool)
    back = convert("inverse", "--arm", arm, "--tool", tool, columns=POSE + ["grasp"] + JOINTS, rows=rows)
    assert {row["status"] for row in back} == {"ok"}
    for row, q in zip(back, joints):
        assert numbers(row, JOINTS) == pytest.approx(q, abs=1e-9)


def test_tools_differ_by_the_wrist_length():
    tips = [numbers(convert("forward", "--arm", "gold", *o, columns=JOINTS, rows=[HOME])[0], ["x", "y", "z"])
            for o in ([], ["--tool", "raven_grasper"], ["--tool", "da_vinci"])]
    assert tips[0] == tips[1]
    assert math.dist(tips[1], tips[2]) == pytest.approx(0.004, abs=1e-12)


def test_an_unknown_tool_is_refused_with_the_known_ones():
    error = run("forward", "--arm", "gold", "--tool", "hook", code=1).stderr.decode()
    assert '"hook"' in error and "raven_grasper, da_vinci, raven2_sim" in error


def test_every_status_can_be_seen():
    def solve(q, current):
        rows = inverse_rows("gold", [q], [current])
        return convert("inverse", "--arm", "gold", columns=POSE + ["grasp"] + JOINTS, rows=rows)[0]

    def with_(**changes):
        return [changes.get(name, value) for name, value in zip(JOINTS, HOME)]

    assert solve(HOME, HOME)["status"] == "ok"
    clamped = solve(with_(J2=2.45), with_(J2=2.30))
    assert clamped["status"] == "clamped"
    assert float(clamped["J2"]) == pytest.approx(3 * math.pi / 4, abs=1e-12)
    far = solve(with_(J3=0.35), HOME)
    assert far["status"] == "too_far"
    assert numbers(far, JOINTS) == HOME, "the robot stays where it is"
    assert solve(with_(J3=0.475), with_(J3=0.48))["status"] == "singular_rcm"
    singular = with_(J3=0.47 + 0.013 / math.cos(0.9), J5=0.9)
    assert solve(singular, singular)["status"] == "singular_wrist"
    pose = [0.0, 0.001, 0.1, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    row = convert("inverse", "--arm", "gold", columns=POSE + ["grasp"] + JOINTS, rows=[pose + [0.0] + HOME])[0]
    assert row["status"] == "out_of_reach"


def test_jacobian_is_the_derivative_of_forward():
    step = 1e-6
    rows = [HOME]
    for j in range(7):
        for sign in (1, -1):
            rows.append([v + sign * step * (i == j) for i, v in enumerate(HOME)])
    poses = convert("forward", "--arm", "green", columns=JOINTS, rows=rows)
    J = convert("jacobian", "--arm", "green", columns=JOINTS, rows=[HOME])[0]
    assert list(J) == [f"j{i}{j}" for i in range(1, 7) for j in range(1, 8)]
    for j in range(7):
        a, b = poses[1 + 2 * j], poses[2 + 2 * j]
        for i, axis in enumerate("xyz", 1):
            assert float(J[f"j{i}{j + 1}"]) == pytest.approx((float(a[axis]) - float(b[axis])) / 2 / step, abs=1e-6)
    assert numbers(J, ["j43", "j53", "j63"]) == [0.0, 0.0, 0.0], "the insertion does not turn the tool"


def test_columns_are_found_by_name_whatever_else_there_is():
    plain = run("forward", "--arm", "gold", text=table(JOINTS, [HOME])).stdout
    columns = ["note"] + JOINTS[::-1] + ["t"]
    other = run("forward", "--arm", "gold", text=table(columns, [["left out"] + HOME[::-1] + [1]], end="\r\n")).stdout
    assert other == plain


@pytest.mark.parametrize("lines,message", [
    ([",".join(JOINTS[:6])], "stdin:1: column J7 is missing"),
    ([",".join(JOINTS), "0,1,0.4,0,0,0,0", "0,1,0.4,0,0,0"], "stdin:3: 6 cells, expected 7"),
    ([",".join(JOINTS), "0,1,0.4,0,0,0,0,9"], "stdin:2: 8 cells, expected 7"),
    ([",".join(JOINTS)] + ["0,1,0.4,0,0,0,0"] * 15 + ["0,1,nan,0,0,0,0"], 'stdin:17: J3 is "nan"'),
    ([",".join(JOINTS), "0,1,deep,0,0,0,0"], 'stdin:2: J3 is "deep"'),
    ([",".join(JOINTS), "0,1,,0,0,0,0"], 'stdin:2: J3 is ""'),
    ([",".join(JOINTS), "0,inf,0.4,0,0,0,0"], 'stdin:2: J2 is "inf"'),
    ([], "stdin:1: no header row"),
])
def test_wrong_tables_are_refused_with_their_line(lines, message):
    text = "".join(line + "\n" for line in lines)
    for operation in ("forward", "jacobian"):
        result = run(operation, "--arm", "gold", text=text, code=2)
        assert message in result.stderr.decode()
        if len(lines) == 17:
            assert result.stdout.count(b"\n") == 16, "header and the rows before the wrong one"


def test_a_matrix_that_is_no_rotation_is_refused():
    pose = [-0.08, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0]
    for bad in (pose, pose[:11] + [2.0]):
        text = table(POSE + ["grasp"] + JOINTS, [bad + [0.0] + HOME])
        assert "stdin:2: r11..r33 is not a rotation" in run("inverse", "--arm", "gold", text=text, code=2).stderr.decode()


def test_arguments_are_checked():
    for arguments in (["forward"], ["forward", "--arm", "blue"], ["backward", "--arm", "gold"], []):
        result = subprocess.run([PROGRAM, *arguments], stdin=subprocess.DEVNULL, capture_output=True, timeout=60,
                                check=False)
        assert result.returncode > 100
    help_text = run("--help").stdout.decode()
    for word in ("m, rad", "clamped", "singular_wrist", "J1..J7", "--tool"):
        assert word in help_text


def test_output_does_not_depend_on_the_locale():
    text = table(JOINTS, [HOME])
    plain = run("forward", "--arm", "gold", text=text).stdout
    result = subprocess.run([PROGRAM, "forward", "--arm", "gold"], input=text.encode(), capture_output=True, timeout=60,
                            env={**os.environ, "LC_ALL": "de_DE.UTF-8"}, check=True)
    assert result.stdout == plain
