#!/usr/bin/env python3
"""Learns raven2_trainer/Reach-v0 by CMA-ES (the package `cma`), a linear policy; then tries it on 100 seeds that it has not seen.

    /usr/bin/python3 -m venv --system-site-packages ENV && ENV/bin/pip install cma==4.5.0 gymnasium==1.4.0
    ENV/bin/python doc/examples/learn_reach.py            # 81 s on two cores
"""

import argparse
import concurrent.futures
import os
import time

import cma
import gymnasium
import numpy as np

import raven2_trainer.gym  # noqa: F401  registers the environments

SCALE = 100.0  # [1/m] observations are some centimetres
_env = None


def environment():
    """One for each process."""
    global _env  # pylint: disable=global-statement
    _env = _env or gymnasium.make("raven2_trainer/Reach-v0")
    return _env


def episode(weights, seed):
    """@return (sum of rewards, success)."""
    env = environment()
    W = np.reshape(weights, (3, -1))
    observation, _ = env.reset(seed=seed)
    total = 0.0
    while True:
        features = np.append(SCALE * observation[3:], 1.0)
        observation, reward, terminated, truncated, info = env.step(np.tanh(W @ features).astype(np.float32))
        total += reward
        if terminated or truncated:
            return total, info["is_success"]


def cost(weights, seeds):
    return -float(np.mean([episode(weights, seed)[0] for seed in seeds]))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--generations", type=int, default=60)
    parser.add_argument("--episodes", type=int, default=6, help="of each candidate")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    begin = time.monotonic()
    size = 3 * (len(environment().observation_space.low) - 3 + 1)
    search = cma.CMAEvolutionStrategy(size * [0.0], 0.3, {"seed": options.seed, "popsize": 16, "verbose": -9})
    with concurrent.futures.ProcessPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        for generation in range(options.generations):
            seeds = range(1000 * generation, 1000 * generation + options.episodes)
            candidates = search.ask()
            search.tell(candidates, list(pool.map(cost, candidates, len(candidates) * [seeds])))
            if generation % 10 in (0, 9):
                print(f"generation {generation + 1}: reward {-search.best.last.f:.2f}, {time.monotonic() - begin:.0f} s", flush=True)
        tried = list(pool.map(episode, 100 * [search.result.xfavorite], range(10**6, 10**6 + 100)))
    print(f"success {sum(success for _, success in tried)} of 100 unseen seeds after {time.monotonic() - begin:.0f} s")


if __name__ == "__main__":
    main()
