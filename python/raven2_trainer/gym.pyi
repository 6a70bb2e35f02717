"""Environments for learning, with gymnasium from PyPI (doc/python.md). SI units; world frame W: x forward, y left, z up."""

from os import PathLike
from typing import Any, Optional, Sequence, Union

import gymnasium
import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import Simulation

_Observation = Union[NDArray[np.float32], dict[str, NDArray[Any]]]

TICKS: int  # [ms] of a step
MOVE: float  # [m] largest motion of a tip along an axis in a step
TURN: float  # [rad] largest rotation about an axis in a step
OPEN: float  # [rad] widest jaws that an action asks for
NEAR: float  # [m] a reached point
REACH: float  # [m] farthest point along an axis
SPREAD: float  # [m] of the tips at a reset
JUDGED: int  # [steps] added to the exercise's time limit
STRIKE: tuple[int, int]  # [steps] from the reset: first step in which a hazard may come, and the step before which it comes
MOST_STARTED: int  # simulations that an environment keeps
PLANTS: tuple[str, ...]  # names in config/plants
LINKS: tuple[Optional[str], ...]  # names in config/impairments; None: a perfect network

def variation(number: int, config: Union[str, PathLike[str], None] = ..., robot: str = ...) -> dict[str, Any]:
    """Arguments of Simulation: settings, link and, with robot="virtual", plant. Empty for number 0."""

class Raven(gymnasium.Env[Any, NDArray[np.float32]]):
    """Both arms in an exercise. Action (7,) for each of `arms`, -1 to 1: motion (3) and rotation (3) along the axes of W, jaws (1).
    Observation (n,): tips (2, 3) [m, B], quaternions (2, 4), jaws (2,) [rad], error (2,) [m], commanded tips (2, 3) [m, W],
    objects (m, 7) [m, W; -], and from both tips to the first object (2, 3) [m, W]. With `pictures` a dict: "state", and "picture"
    (height, width, 3)."""

    metadata: dict[str, Any]
    render_mode: Optional[str]
    action_space: gymnasium.spaces.Box
    observation_space: Union[gymnasium.spaces.Box, gymnasium.spaces.Dict]
    def __init__(self, exercise: Optional[str], arms: Sequence[str] = ..., steps: Optional[int] = ..., hazard: Optional[str] = ...,
                 pictures: Optional[tuple[int, int]] = ..., robot: Optional[str] = ..., config: Union[str, PathLike[str], None] = ...,
                 max_steps: Optional[int] = ..., variations: int = ..., render_mode: Optional[str] = ...) -> None: ...
    def reset(self, *, seed: Optional[int] = ..., options: Optional[dict[str, Any]] = ...) -> tuple[_Observation, dict[str, Any]]: ...
    def step(self, action: ArrayLike) -> tuple[_Observation, float, bool, bool, dict[str, Any]]:
        """Observation, reward, terminated, truncated, info. ValueError for another shape, and for NaN or infinity."""
    @property
    def simulation(self) -> Simulation:
        """The simulation of the episode. A reset may choose another one."""
    def render(self) -> NDArray[np.uint8]:
        """RGB (480, 640, 3) of the endoscope."""
    def close(self) -> None: ...

class Reach(Raven):
    """A tip to a point. Action (3,), -1 to 1: motion along the axes of W. Observation (9,) [m, W]: tip, from the tip to the point,
    from the commanded tip to the point."""

    def __init__(self, arm: str = ..., max_steps: Optional[int] = ..., exercise: Optional[str] = ..., **options: Any) -> None: ...
