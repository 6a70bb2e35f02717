"""plot_detector and plot_convergence: rates, intervals and orders, against published numbers and runs made by hand."""
import importlib.machinery
import importlib.util
import math
import pathlib
import sys

import pytest

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parents[2]


def load(name):
    loader = importlib.machinery.SourceFileLoader(name, str(ROOT / "scripts" / name))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader))
    loader.exec_module(module)
    return module


plot = load("plot_detector")


def run(unsafe=0, size=0.0, alarm=-1, stopped=-1, decided=-1, harmed=-1, departure=0.0, jump=0.0):
    return {"scenario": "torque", "unsafe": unsafe, "departure_size": size, "published_size": 2 * size,
            "departure_alarm_ms": alarm, "published_alarm_ms": -1, "stopped_ms": stopped, "decided_ms": decided,
            "harmed_ms": harmed, "departure_m": departure, "jump_2ms_m": jump}


RUNS = [run(1, 1.5, alarm=10, decided=8, harmed=20, departure=0.0025, jump=0.0015),
        run(1, 1.0, alarm=14, stopped=12, decided=10, harmed=15, departure=0.0015),
        run(1, 0.2, stopped=13, decided=10, departure=0.002),
        run(1, 3.0, alarm=30, decided=9, harmed=25, departure=0.004),
        run(size=0.5), run(size=1.2, alarm=5), run(size=0.9, departure=0.0007), run(size=2.0, stopped=50)]


def test_runs_are_unsafe_safe_or_stopped_before_harm():
    assert [len(group) for group in plot.classes(RUNS)] == [4, 3, 1]


def test_rates_are_percent_of_safe_and_unsafe_runs():
    assert plot.rates(RUNS, "departure") == pytest.approx((100 / 3, 50.0)), "a size of 1 is at the limit, not beyond"
    assert plot.rates(RUNS, "published") == pytest.approx((200 / 3, 75.0))
    assert plot.rates(RUNS, "departure", 1.3) == pytest.approx((0.0, 50.0))
    assert all(math.isnan(rate) for rate in plot.rates([], "departure"))


def test_the_robot_s_own_check_counts_up_to_two_milliseconds_behind_the_decision():
    assert plot.robots_own(RUNS) == pytest.approx((25.0, 25.0, 50.0))


def test_the_curve_goes_from_nothing_to_everything():
    points = plot.roc(RUNS, "departure")
    assert points[0] == (0.0, 0.0) and points[-1] == (100.0, 100.0)
    assert all(a[0] <= b[0] and a[1] <= b[1] for a, b in zip(points, points[1:]))


@pytest.mark.parametrize("found, of, low, high", [(81, 263, 25.53, 36.62), (15, 148, 6.24, 16.05), (0, 20, 0.0, 16.11),
                                                  (1, 29, 0.61, 17.18)])
def test_the_interval_is_wilson_s(found, of, low, high):
    """Newcombe, Statistics in Medicine 17:857, 1998, table I, method 3."""
    assert plot.interval(100.0 * found / of, of) == pytest.approx((low, high), abs=0.01)


def test_alarms_are_timed_behind_the_decision_and_before_harm(capsys):
    """Those of the unsafe runs with an alarm: 10, 14 and 30 ms; decided at 8, 10 and 9, harmed at 20, 15 and 25."""
    plot.describe("made", "torque", RUNS)
    line = next(line for line in capsys.readouterr().out.splitlines() if line.strip().startswith("departure:"))
    assert "alarm after it was decided: median 4, 99 % 21, most 21 ms; before harm: median 1, least -5 ms" in line


def test_the_definition_of_truth_is_in_millimetres(capsys):
    plot.sensitivity("torque", RUNS)
    lines = capsys.readouterr().out.splitlines()
    assert [line.split(": ")[1].split(";")[0] for line in lines] == ["5 unsafe, 2 safe", "4 unsafe, 3 safe",
                                                                   "2 unsafe, 3 safe", "1 unsafe, 4 safe",
                                                                   "1 unsafe, 4 safe"]
    assert "departure 50.0 / 33.3" in lines[1], "an alarm after the harm comes too late"


def test_a_plant_is_fitted_to_the_first_part_of_a_recording_alone():
    """The published error is that of the rest (scripts/identify_plant)."""
    fit = load("identify_plant")
    plant, asked = object.__new__(fit.Plant), []

    def errors(x, name, start, end, *_):
        asked.append((start, end))
        return [[0.0, horizon, *[0.1] * 6] for horizon in fit.HORIZONS]

    plant.errors = lambda *words: fit.np.array(errors(*words))
    plant.residuals(fit.np.zeros(len(fit.KEYS)))
    assert asked == [(0.002, fit.TRAINING - 0.01)] and 0.5 < fit.TRAINING < 0.9


@pytest.mark.parametrize("order", [1, 2, 4])
def test_an_order_is_that_of_the_longest_steps(order):
    steps = [1.0, 0.5, 0.25]
    assert load("plot_convergence").slope(steps, [3 * h**order for h in steps[:2]] + [1.0]) == pytest.approx(order)
