"""Tests that signals, threads, forks and wrong arguments neither end nor block the Python interpreter."""

import copy
import os
import pickle
import subprocess
import sys

import pytest

from built_module import BUILD, ROOT

FULL = os.environ.get("RAVEN2_TRAINER_FULL") == "1"


def alone(program, folder, *arguments):
    """The end of a program in another Python: it could end this one."""
    return subprocess.run([sys.executable, "-c", "import os, signal, sys, threading, time\nimport numpy as np\nimport raven2_trainer\n" + program, *arguments],
                          cwd=folder, capture_output=True, text=True, timeout=120, check=False,
                          env=dict(os.environ, PYTHONPATH=str(BUILD / "devel/lib/python3/dist-packages")))


CLEARED = """
many = raven2_trainer.VectorSimulation(2, robot="none")
stepping = threading.Thread(target=lambda: many.step(ticks=5000))
stepping.start()
time.sleep(0.1)
many.simulations.clear()
stepping.join()
"""


CHANGED = """
class Array:
    def __array__(self, *_):
        many.simulations[0] = None
        return np.zeros((2, 7))
many = raven2_trainer.VectorSimulation(2, robot="none")
many.step([Array(), Array()])
class Key(str):
    def __str__(self):
        command.clear()
        return "move"
    __hash__ = str.__hash__
command = {Key("move"): [0.0, 0.0, 0.0]}
raven2_trainer.Simulation(robot="none").step({"gold": command})
"""


@pytest.mark.parametrize("program", [CLEARED, CHANGED])
def test_what_a_caller_takes_away_meanwhile_ends_nothing(program, tmp_path):
    done = alone(program, tmp_path)
    assert done.returncode == 0, done.stderr


def test_ctrl_c_ends_a_long_step(tmp_path):
    done = alone("""
simulation = raven2_trainer.Simulation(robot="none")
try:
    threading.Timer(1.0, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    simulation.step(ticks=1000000)
except KeyboardInterrupt:
    print(simulation.state.tick < 1000000)
simulation.step(ticks=5)
""", tmp_path)
    assert (done.returncode, done.stdout) == (0, "True\n"), done.stderr


def test_ctrl_c_ends_many_long_steps(tmp_path):
    done = alone("""
many = raven2_trainer.VectorSimulation(3, robot="none", threads=2)
try:
    threading.Timer(1.0, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    many.step(ticks=1000000)
except KeyboardInterrupt:
    print(bool((many.tick < 1000000).all()))
many.step(ticks=5)
""", tmp_path)
    assert (done.returncode, done.stdout) == (0, "True\n"), done.stderr


@pytest.mark.parametrize("call", ["in_collision", "clearance"])
def test_ctrl_c_ends_a_call_for_many_rows(tmp_path, call):
    done = alone("""
planner = raven2_trainer.Planner()
rows = np.tile([0.52, 1.57, 0.40, 0.0, 0.0, 0.78, 0.78], (2000000, 1))
begin = time.process_time()
getattr(planner, sys.argv[1])("gold", rows[:2000])
whole = 1000 * (time.process_time() - begin)

begin = time.process_time()

try:
    threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    getattr(planner, sys.argv[1])("gold", rows)
except KeyboardInterrupt:
    print(time.process_time() - begin < 0.5 * whole)

print(getattr(planner, sys.argv[1])("gold", rows[:2000]).shape)
""", tmp_path, call)
    assert (done.returncode, done.stdout) == (0, "True\n(2000,)\n"), done.stderr


@pytest.mark.parametrize("ticks", [20, 1000000])
def test_a_thread_that_steps_when_the_program_ends_does_not_abort_it(tmp_path, ticks):
    done = alone("""
simulation = raven2_trainer.Simulation(robot="none")
threading.Thread(target=lambda: [simulation.step(ticks=int(sys.argv[1])) for _ in iter(int, 1)], daemon=True).start()
time.sleep(0.3)
print("ends")
""", tmp_path, str(ticks))
    assert (done.returncode, done.stdout, done.stderr) == (0, "ends\n", "")


def test_a_signal_may_close_the_simulation_that_is_stepped(tmp_path):
    done = alone("""
simulation = raven2_trainer.Simulation(robot="none", output="session")
signal.signal(signal.SIGALRM, lambda *_: simulation.close())
signal.setitimer(signal.ITIMER_REAL, 0.5)
try:
    simulation.step(ticks=1000000)
except RuntimeError as error:
    print(error, simulation.closed, os.path.exists("session/metrics.json"))
""", tmp_path)
    assert (done.returncode, done.stdout) == (0, "the simulation is closed True True\n"), done.stderr


def test_a_forked_process_leaves_the_recording_and_the_pictures_alone(tmp_path):
    done = alone("""
simulation = raven2_trainer.Simulation(output="made")
simulation.start()
simulation.step({"gold": {"move": [0, 0, 0.001]}}, ticks=100)

for has_drawn in (False, True):
    if has_drawn:
        simulation.render("endoscope", 64, 64)
    if os.fork() == 0:
        for call in (simulation.step, simulation.close, *(has_drawn * [lambda: simulation.render("endoscope", 64, 64)])):
            try:
                call()
                os._exit(1)
            except (RuntimeError, raven2_trainer.RenderError) as error:
                assert "fork" in str(error), error

        del simulation, call
        # As multiprocessing ends: the drawing library would wait for its threads.
        os._exit(0) if has_drawn else sys.exit(0)
    assert os.wait()[1] == 0

simulation.step({"gold": {"move": [0, 0, 0.001]}}, ticks=2000)
ticks = simulation.state.tick
simulation.close()
log = raven2_trainer.Session("made").log
assert log.clean and log.bad_bytes == 0 and len(log.ticks) == ticks, (log.clean, log.bad_bytes, len(log.ticks), ticks)
assert open("made/commands.csv").read().count("pedal") == 1
""", tmp_path)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("seed", range(11, 14 if FULL else 12))
def test_nothing_that_a_caller_passes_ends_the_interpreter(seed, tmp_path):
    """Calls everything with random arguments (fuzz_module.py)."""
    done = subprocess.run([sys.executable, ROOT / "test/python/fuzz_module.py", str(seed), "20" if FULL else "3"], cwd=tmp_path, capture_output=True,
                          text=True, timeout=600, check=False, env=dict(os.environ, PYTHONPATH=os.pathsep.join([
                              str(BUILD / "devel/lib/python3/dist-packages"), "/usr/lib/python3/dist-packages"])))
    last = (tmp_path / "calls").read_text().splitlines()[-3:] if (tmp_path / "calls").exists() else []
    assert done.returncode == 0, "\n".join([done.stderr, "last calls:", *last])


def test_a_simulation_is_not_copied(ready):
    for thing in (ready, ready.state, ready.save()):
        for copied in (copy.copy, copy.deepcopy, pickle.dumps):
            with pytest.raises(TypeError):
                copied(thing)


BLANK = """
from raven2_trainer import _core

def refuses(call, *arguments):
    try:
        call(*arguments)
    except RuntimeError as error:
        return "__init__ has not been called" in str(error)
    except TypeError:
        return False
    raise SystemExit(f"{call} has worked without a value")

blanks = [kind.__new__(kind) for kind in (_core.Simulation, _core.State, _core.Snapshot, _core.Kinematics, _core.Planner)]

def is_method(kind, name):
    return not isinstance(getattr(kind, name), property)


for blank in blanks:
    for name in dir(blank):
        if name.startswith("_"):
            continue
        if is_method(type(blank), name):
            method = getattr(blank, name)
            assert any([refuses(method, *[None] * count) for count in range(12)]), (blank, name)
        else:
            assert refuses(getattr, blank, name), (blank, name)

assert refuses(_core.step_all, blanks[:1], [None], 1, 1)
"""


def test_an_object_without_its_constructor_raises_and_does_not_crash():
    subprocess.run(["/usr/bin/python3", "-c", BLANK], check=True, env={**os.environ, "PYTHONPATH": os.pathsep.join(
        [str(BUILD / "devel/lib/python3/dist-packages"), "/usr/lib/python3/dist-packages"])})
