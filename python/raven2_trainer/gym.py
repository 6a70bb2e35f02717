"""Environments for learning, with gymnasium (PyPI; not in Debian): doc/python.md.

    import gymnasium, raven2_trainer.gym
    env = gymnasium.make("raven2_trainer/Reach-v0")

Success, mistakes and failure are the judgement of the same judge that scores surgeons. A reset restores a snapshot.
"""

import os
import pathlib

import gymnasium
import numpy as np
import yaml

from .plain import whole_number
from .simulation import Simulation, root_file

TICKS = 20         # [ms] of a step
MOVE = 0.002       # [m] largest motion of a tip along an axis in a step
TURN = 0.05        # [rad] largest rotation about an axis in a step
OPEN = 1.0         # [rad] widest jaws that an action asks for
NEAR = 0.002       # [m] a reached point
REACH = 0.02       # [m] farthest point along an axis
SPREAD = 0.004     # [m] of the tips at a reset
JUDGED = 50        # [steps] after an exercise's time limit: its judge speaks first
STRIKE = (5, 50)   # [steps] into an episode, between which a hazard comes
MOST_STARTED = 16  # variations that are kept; a simulation takes some 35 MB
_ARMS = ("gold", "green")
PLANTS = ("identified", "more_friction", "worn_tool", "loose_cables")  # of the virtual Raven
LINKS = (None, "wifi", "wan")


def variation(number, config=None, robot="none"):
    """Arguments of Simulation that differ as two robots, instruments and networks differ: the same number, the same values.

    Friction of the joints is 1 / 1.6 to 1.6 times config/model.yaml's: by so much two robots may differ (config/plants/more_friction.yaml).
    Friction of contacts is that of ABS and steel, 0.35 to 0.5 (model.yaml), with a jaw twice that. Variation 0 changes nothing.
    """
    if whole_number("number", number, 0) == 0:
        return {}
    random = np.random.default_rng([16, number])
    root = pathlib.Path(root_file(config))
    model = yaml.safe_load((root.parent / yaml.safe_load(root.read_text(encoding="utf-8"))["model"]).read_text(encoding="utf-8"))
    settings = {"model/contact_mu": random.uniform(0.35, 0.5), "model/jaw_mu": random.uniform(0.7, 1.0)}
    for name in ("coulomb_friction", "viscous_friction"):
        settings[f"model/{name}"] = np.array(model[name], float) * 1.6 ** random.uniform(-1, 1, len(model[name]))
    plant, link = random.choice(len(PLANTS)), random.choice(len(LINKS))
    return {"settings": settings, "link": LINKS[link], **({"plant": PLANTS[plant]} if robot == "virtual" else {})}


def _exercise_file(exercise, config):
    root = pathlib.Path(root_file(config)).parent
    return yaml.safe_load((root / "exercises" / f"{exercise}.yaml").read_text(encoding="utf-8"))


def _hazard_of(exercise, hazard, config):
    """"own" is the drill of the exercise; "none" means no hazard."""
    if hazard == "none":
        return None
    if hazard == "own" and exercise is None:
        raise ValueError("hazard is \"own\", the exercise's, but this environment has no exercise: name one of config/faults")
    if hazard != "own":
        return hazard
    return _exercise_file(exercise, config)["drill"]["scenario"]


class Raven(gymnasium.Env):
    """Both arms in an exercise. `arms`: those that an action moves.

    Action, per arm: motion (3, along world axes), rotation (3) and jaws (1: -1 closed, 1 open), each -1 to 1. Observation: for both arms tip
    (3) [m, B], quaternion (4), jaw opening (1), error (1) [m], where the actions lead (3) [m, world]; objects (n, 7); from the tips to the first object in
    world axes.
    `robot`: "virtual" or "none"; None: "virtual" with a hazard, else "none", which is faster.
    With `pictures=(width, height)` a dict of that ("state") and the endoscope's image ("picture").
    With `hazard` it comes 0.1 to 1 s after the reset, by its seed.
    `max_steps`: longest episode; None: the time limit of the exercise.
    With `variations=n` each reset takes one of the variations 0 to n - 1 (see variation()), by its seed.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 1000 // TICKS}

    def __init__(self, exercise, arms=_ARMS, steps=None, hazard=None, pictures=None, robot=None, config=None, max_steps=None, variations=1,
                 render_mode=None):
        self.render_mode = render_mode
        config = config and os.path.abspath(config)  # a later chdir changes nothing
        self._hazard, self._strike = _hazard_of(exercise, hazard, config), None
        self._make = {"exercise": exercise, "robot": robot or ("none" if self._hazard is None else "virtual"), "config": config}
        if isinstance(arms, str) or not arms or len(set(arms)) != len(arms) or not set(arms) <= set(_ARMS):
            raise ValueError(f"arms is {arms!r}, expected some of {_ARMS}, each once")
        self._arms = [_ARMS.index(arm) for arm in arms]
        if max_steps is None and exercise is None:
            raise ValueError("max_steps is missing: without an exercise there is no time limit")
        if max_steps is None:
            max_steps = round(1000 * _exercise_file(exercise, config)["time_limit"]) // TICKS + JUDGED
        self._wanted = None if steps is None else whole_number("steps", steps)
        self._max_steps, self._pictures = whole_number("max_steps", max_steps), pictures
        variations = whole_number("variations", variations)
        self._variations, self._started = variations, {}
        self._take(0)
        self._done_before, self._step = 0, 0
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (self._action_size() * len(self._arms),), np.float32)
        state = gymnasium.spaces.Box(-10.0, 10.0, self._observe().shape, np.float32)
        self.observation_space = state if pictures is None else gymnasium.spaces.Dict(
            {"state": state, "picture": gymnasium.spaces.Box(0, 255, (pictures[1], pictures[0], 3), np.uint8)})

    def _action_size(self):
        return 7

    def _take(self, number, seed=None):
        """Goes to the beginning of a variation, which starts when it is first needed. `seed`: of its link and its hazard."""
        if number not in self._started:
            varied = variation(number, self._make["config"], self._make["robot"])
            simulation = Simulation(seed=0, **self._make, **varied)
            simulation.start()
            self._started[number] = (simulation, simulation.save())
            if self._hazard:
                simulation.inject(self._hazard)  # one that does not exist is refused here
        self._number, (self._simulation, begin) = number, self._started.pop(number)
        self._started[number] = (self._simulation, begin)  # the last one used goes last
        if len(self._started) > MOST_STARTED:
            oldest = next(iter(self._started))
            self._started.pop(oldest)[0].close()
        self._simulation.restore(begin)
        if seed is not None:
            self._simulation.reseed(seed)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        number = int(self.np_random.integers(self._variations)) if self._variations > 1 else 0
        self._take(number, int(self.np_random.integers(1 << 53)) if number or self._hazard else None)
        self._step = self._done_before = 0
        self._strike = int(self.np_random.integers(*STRIKE)) if self._hazard else None
        command = np.zeros((2, 7))
        command[:, :3] = self.np_random.uniform(-SPREAD, SPREAD, (2, 3))
        command[:, 6] = OPEN
        self._simulation.step(command, ticks=2 * TICKS)
        self._begin_episode()
        return self._seen(), self._info()

    def step(self, action):
        if np.shape(action) != self.action_space.shape:
            raise ValueError(f"action has the shape {np.shape(action)}, expected {self.action_space.shape}")
        if np.asarray(action).dtype.kind not in "iuf" or not np.isfinite(action).all():
            raise ValueError(f"action is {action!r}, expected finite numbers")
        action = np.clip(np.asarray(action, dtype=float).reshape(len(self._arms), -1), -1.0, 1.0)
        command = np.zeros((2, 7))
        command[:, 6] = OPEN
        for row, arm in zip(action, self._arms):
            command[arm, :3] = MOVE * row[:3]
            if len(row) == 7:
                command[arm, 3:6] = TURN * row[3:6]
                command[arm, 6] = OPEN * (row[6] + 1) / 2
        if self._step == self._strike:
            self._simulation.inject(self._hazard)
        self._simulation.step(command, ticks=TICKS)
        self._step += 1
        info = self._info()
        reward, is_over = self._judge(info)
        return self._seen(), reward, is_over, not is_over and self._step >= self._max_steps, info

    @property
    def simulation(self):
        """That of the episode, for its state."""
        return self._simulation

    def render(self):
        return self._simulation.render("endoscope", 640, 480)

    def close(self):
        for simulation, _ in self._started.values():
            simulation.close()

    def _begin_episode(self):
        """After the arms are at their random start."""

    def _judge(self, info):
        exercise = self._simulation.state.exercise
        steps = info["steps_done"] - self._done_before
        self._done_before = info["steps_done"]
        failed = exercise["status"] == "failed"
        return float(steps) - float(failed), failed or info["is_success"]

    def _info(self):
        state = self._simulation.state
        exercise = state.exercise
        wanted = self._wanted or len(exercise["steps"])
        return {"is_success": bool(exercise["status"] == "done" or exercise["steps_done"] >= wanted > 0), "steps_done": exercise["steps_done"],
                "mistakes": sum(exercise["mistakes"].values()),
                "hazard": state.hazard, "tick": state.tick, "variation": self._number}

    def _seen(self):
        state = self._observe()
        if self._pictures is None:
            return state
        return {"state": state, "picture": self._simulation.render("endoscope", *self._pictures)}

    def _observe(self):
        state = self._simulation.state
        jaws = state.joints[:, 5] + state.joints[:, 6]
        parts = [state.tips.ravel(), state.tip_rotations.ravel(), jaws, state.error, state.desired_tips_in_world.ravel(), state.objects.ravel()]
        if len(state.objects):
            parts.append((state.objects[0, :3] - state.tips_in_world).ravel())
        return np.concatenate(parts).astype(np.float32)


class Reach(Raven):
    """A tip to a point. Action: motion (3). Observation, in world axes: tip (3) [m], from the tip to the point (3), from where the actions
    lead to the point (3): the tip follows them later."""

    def __init__(self, arm="gold", max_steps=100, exercise=None, **options):
        self._arm, self._goal = _ARMS.index(arm), np.zeros(3)
        super().__init__(exercise, (arm,), max_steps=max_steps, **options)

    def _action_size(self):
        return 3

    def _tip(self):
        return np.array(self._simulation.state.tips_in_world[self._arm])

    def _begin_episode(self):
        self._goal = self._tip() + self.np_random.uniform(-REACH, REACH, 3)

    def _distance(self):
        return float(np.linalg.norm(self._goal - self._tip()))

    def _info(self):
        return {"is_success": self._distance() < NEAR, "distance": self._distance(), "steps_done": 0,
                "mistakes": sum(self._simulation.state.exercise["mistakes"].values()), "hazard": self._simulation.state.hazard,
                "tick": self._simulation.state.tick, "variation": self._number}

    def _judge(self, info):
        return -info["distance"] / REACH + float(info["is_success"]), info["is_success"]

    def _observe(self):
        tip = self._tip()
        return np.concatenate([tip, self._goal - tip, self._goal - self._simulation.state.desired_tips_in_world[self._arm]]).astype(np.float32)


for name, options in (("Reach", {}), ("PickRing", {"exercise": "pick_hand_over_place", "arms": ("gold",), "steps": 1, "max_steps": 1000}),
                      ("RingTransfer", {"exercise": "ring_tower_transfer"}), ("PegTransfer", {"exercise": "peg_transfer"})):
    gymnasium.register(f"raven2_trainer/{name}-v0", entry_point=Reach if name == "Reach" else Raven, kwargs=options)
del name, options
