"""raven2_trainer.gym in a virtual environment with gymnasium from PyPI; skipped where that cannot be installed."""

import os
import pathlib
import re
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build"))
GYMNASIUM = "gymnasium==1.4.0"

CHECK = """
import sys, types, warnings
import numpy as np, gymnasium, yaml
from gymnasium.utils.env_checker import check_env
warnings.simplefilter("error")
import raven2_trainer.gym

def refused(name, **options):
    try:
        gymnasium.make(f"raven2_trainer/{name}-v0", **options)
    except ValueError as error:
        return str(error)

def episode(env, seed, steps=30):
    random = np.random.default_rng(seed)
    observation, info = env.reset(seed=seed)
    seen = [np.asarray(observation)]
    for _ in range(steps):
        observation, reward, terminated, truncated, info = env.step(random.uniform(-1, 1, env.action_space.shape))
        seen.append(np.append(observation, reward))
        if terminated or truncated:
            break
    return np.concatenate(seen)

for name in ("Reach", "PickRing", "RingTransfer", "PegTransfer"):
    env = gymnasium.make(f"raven2_trainer/{name}-v0", render_mode="rgb_array")
    check_env(env.unwrapped, skip_render_check=False)
    assert np.array_equal(episode(env, 3), episode(env, 3)) and not np.array_equal(episode(env, 3), episode(env, 4)), name
    env.close()
    env = gymnasium.make(f"raven2_trainer/{name}-v0", hazard="sudden_jump", pictures=(32, 24), variations=2)
    check_env(env.unwrapped, skip_render_check=True)
    assert env.reset(seed=3)[1]["mistakes"] == 0
    env.close()

# a controller that goes straight to the point reaches it, which is success
env = gymnasium.make("raven2_trainer/Reach-v0")
successes = 0
for seed in range(20):
    observation, _ = env.reset(seed=seed)
    over = False
    while not over:
        observation, reward, terminated, truncated, info = env.step(np.clip(observation[6:] / 0.002, -1, 1).astype(np.float32))
        over = terminated or truncated
        assert abs(reward - (info["is_success"] - info["distance"] / raven2_trainer.gym.REACH)) < 1e-9, reward
    successes += info["is_success"]
assert successes == 20, successes
for action in (np.zeros(7), np.zeros(1), np.zeros((1, 3)), ["0.1", "0", "0"], [None, 0, 0], [np.nan, 0, 0], [0, np.inf, 0], [1j, 0, 0]):
    try:
        env.step(action)
    except ValueError as error:
        assert "expected (3,)" in str(error) or "expected finite numbers" in str(error), error
    else:
        raise AssertionError(action)

assert [env.reset(seed=1)[1]["steps_done"], *(env.step(np.zeros(3, np.float32))[3] for _ in range(100))][1:] == [False] * 99 + [True]

# the arm that is asked for is the one that moves
env = gymnasium.make("raven2_trainer/Reach-v0", arm="green", max_steps=50)
env.reset(seed=1)
before = np.array(env.unwrapped.simulation.state.tips_in_world)
for _ in range(20):
    env.step(np.array([0, 0, 1], np.float32))
moved = np.linalg.norm(env.unwrapped.simulation.state.tips_in_world - before, axis=1)
assert moved[1] > 0.02 and moved[0] < 0.01, moved  # from the random start both settle by some millimetres
env.close()

# A step is worth 1. A failure costs 1 and ends the episode.

env = gymnasium.make("raven2_trainer/PegTransfer-v0").unwrapped

simulation = env._simulation

for status, done, expected in (("failed", 0, (-1.0, True)), ("failed", 1, (0.0, True)), ("running", 2, (2.0, False))):
    env._simulation, env._done_before = types.SimpleNamespace(state=types.SimpleNamespace(exercise={"status": status})), 0
    assert env._judge({"steps_done": done, "is_success": False}) == expected, status
env._simulation = simulation
env.close()

# As long as surgeons have for the exercise; the judge's limit comes first.
for name, seconds in (("RingTransfer", 300), ("PegTransfer", 300)):
    assert seconds < 0.02 * gymnasium.make(f"raven2_trainer/{name}-v0").unwrapped._max_steps < seconds + 2

# without an exercise there is no time limit
try:
    gymnasium.make("raven2_trainer/Reach-v0", max_steps=None)
    raise AssertionError("no time limit")
except ValueError as error:
    assert "max_steps is missing" in str(error)

for options in ({"max_steps": 0}, {"max_steps": 1.5}, {"variations": 0}, {"variations": 1.5}, {"variations": True}, {"steps": 0}, {"steps": 1.5}):
    said = refused("Reach", **options)
    assert f"{next(iter(options))} is" in said and "whole number of at least 1" in said, said

for arms in ((), "gold", ("gold", "gold"), ("blue",)):
    assert "arms is" in refused("RingTransfer", arms=arms), arms

for number in (True, -1, "3", 1.5):
    try:
        raven2_trainer.gym.variation(number)
    except ValueError as error:
        assert "number is" in str(error), error
    else:
        raise AssertionError(number)

assert gymnasium.make("raven2_trainer/PickRing-v0", hazard="none").unwrapped.simulation.state.runlevel == "none"

# each seed has its variation of friction and link, and always the same episode
env = gymnasium.make("raven2_trainer/Reach-v0", variations=3)
first = {seed: episode(env, seed) for seed in range(8)}
taken = {seed: env.reset(seed=seed)[1]["variation"] for seed in range(20)}
assert set(taken.values()) == {0, 1, 2}, taken
assert all(np.array_equal(first[seed], episode(env, seed)) for seed in (7, 3, 5, 0))
for number in (1, 2):
    varied = raven2_trainer.gym.variation(number)["settings"]
    assert 0.35 <= varied["model/contact_mu"] <= 0.5 and varied["model/viscous_friction"].shape == (7,)
with open(SOURCE + "/config/model.yaml", encoding="utf-8") as file:
    model = yaml.safe_load(file)
shares = np.concatenate([np.array([a / b for a, b in zip(raven2_trainer.gym.variation(n)["settings"][f"model/{name}"], model[name]) if b])
                         for n in range(1, 31) for name in ("coulomb_friction", "viscous_friction")])
assert 1 / 1.6 <= shares.min() < 0.8 and 1.25 < shares.max() <= 1.6 and 0.4 < np.mean(shares < 1) < 0.6, shares
assert raven2_trainer.gym.variation(0) == {} and "plant" in raven2_trainer.gym.variation(1, robot="virtual")
env.close()

env = gymnasium.make("raven2_trainer/PickRing-v0", hazard="sudden_jump", pictures=(64, 48), variations=2)
seed = next(seed for seed in range(20) if env.reset(seed=seed)[1]["variation"] == 1)
observation, _ = env.reset(seed=seed)

came = [env.step(np.zeros(7, np.float32))[4]["hazard"] for _ in range(60)]
assert any(came), "the hazard comes in the first steps, in an exercise whose drill is later, too"

assert not env.reset(seed=seed)[1]["hazard"], "and is over with the episode"
assert observation["picture"].shape == (48, 64, 3) and observation["picture"].std() > 5
assert env.observation_space.contains(observation)
env.close()

# each seed of a variation with a bad link has its own losses and delays

wireless = next(n for n in range(1, 30) if raven2_trainer.gym.variation(n)["link"] == "wifi")
env = gymnasium.make("raven2_trainer/Reach-v0", variations=wireless + 1)
raven = env.unwrapped

paths = []
for seed in (1, 2, 1):
    raven._take(wireless, seed)
    for _ in range(40):
        raven.simulation.step({"gold": {"move": [0, 0, 1e-4]}}, ticks=5)
    paths.append(raven.simulation.state.desired_tips_in_world.copy())
assert np.array_equal(paths[0], paths[2]) and not np.array_equal(paths[0], paths[1])
env.close()

# each seed of an environment with a hazard has its own random values of the hazard

env = gymnasium.make("raven2_trainer/PickRing-v0", hazard="put_usb_cmd_random")
raven = env.unwrapped
take, seeds = raven._take, []

raven._take = lambda number, seed=None: seeds.append(seed) or take(number, seed)
for seed in (1, 2, 1):
    env.reset(seed=seed)
assert None not in seeds and seeds[0] == seeds[2] != seeds[1], seeds

ends = []
for seed in (1, 2, 1):
    take(0, seed)
    raven.simulation.inject("put_usb_cmd_random")
    raven.simulation.step({"gold": {"move": [0, 0, 0]}}, ticks=60)
    ends.append(raven.simulation.state.robot_joints[0].copy())
assert np.array_equal(ends[0], ends[2]) and not np.array_equal(ends[0], ends[1])
env.close()

# Without a robot there is no hazard of the robot.
assert "has no exercise" in refused("Reach", hazard="own")
assert "sudden_jump acts on the robot" in refused("PickRing", hazard="sudden_jump", robot="none")
env = gymnasium.make("raven2_trainer/PickRing-v0")
env.reset(seed=1)
env.unwrapped._done_before = 3  # of an episode that came so far
env.reset(seed=1)
assert env.step(np.zeros(7, np.float32))[1] == 0.0
env.close()
print("all good")
"""


@pytest.fixture(scope="module", name="python")
def environment(tmp_path_factory):
    folder = tmp_path_factory.mktemp("gym") / "venv"
    subprocess.run(["/usr/bin/python3", "-m", "venv", "--system-site-packages", "--without-pip", folder], check=True, timeout=120)
    site = next((folder / "lib").glob("python3*/site-packages"))
    got = subprocess.run(["/usr/bin/python3", "-m", "pip", "install", "--quiet", "--target", site, "--no-deps", GYMNASIUM, "farama-notifications",
                          "cloudpickle", "typing-extensions"], capture_output=True, text=True, timeout=120, check=False)
    if got.returncode != 0:
        pytest.skip(f"gymnasium cannot be installed: {got.stderr.strip().splitlines()[-1] if got.stderr.strip() else 'no reason given'}")
    return folder / "bin/python3"


def test_the_environments_keep_gymnasiums_rules(python):
    environment = {**os.environ, "PYTHONPATH": str(BUILD / "devel/lib/python3/dist-packages")}
    done = subprocess.run([python, "-c", f"SOURCE = {str(ROOT)!r}\n{CHECK}"], capture_output=True, text=True, env=environment, timeout=300, check=False)
    assert done.returncode == 0 and "all good" in done.stdout, done.stderr[-3000:]


def test_nothing_that_a_caller_passes_to_an_environment_ends_the_interpreter(python, tmp_path):
    """As test_python_interpreter.py, which has no gymnasium."""
    done = subprocess.run([python, ROOT / "test/python/fuzz_module.py", "11", "2", "gym"], capture_output=True, text=True, cwd=tmp_path, timeout=300,
                          check=False, env={**os.environ, "PYTHONPATH": str(BUILD / "devel/lib/python3/dist-packages")})
    assert done.returncode == 0, done.stderr[-3000:]


def test_without_gymnasium_the_module_says_what_is_missing():
    done = subprocess.run(["/usr/bin/python3", "-c", "import raven2_trainer.gym"], capture_output=True, text=True, timeout=60, check=False,
                          env={**os.environ, "PYTHONPATH": str(BUILD / "devel/lib/python3/dist-packages")})
    assert done.returncode != 0 and "gymnasium" in done.stderr


def test_the_page_has_the_versions_that_the_tests_use():
    page = (ROOT / "doc/python.md").read_text()
    pins = {pin for file in ("python/test_python_gym.py", "learn/test_examples.py", "learn/test_data_sets.py")
            for pin in re.findall(r'"([a-z-]+==[0-9.]+)"', (ROOT / "test" / file).read_text())}
    assert len(pins) >= 6
    for pin in pins:
        name, version = pin.split("==")
        assert pin in page or re.search(rf"{name}[^|]*{re.escape(version)}", page), pin
    for script, (package, *_) in {"learn_reach.py": ("cma==",), "clone_pick_ring.py": ("scikit-learn==",)}.items():
        head = (ROOT / "doc/examples" / script).read_text()[:600]
        assert GYMNASIUM in head and any(pin in head for pin in pins if pin.startswith(package)), script
