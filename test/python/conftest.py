"""For all tests of this folder. A fixture imports its modules itself, because most tests need neither of them."""
import os
import pathlib

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]

# Our matrices are small. Otherwise each process that loads numpy starts a thread per core, at 0.1 s of processor time.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


@pytest.fixture(scope="session")
def known():
    """An instructor's choices. It reads most files of config, which takes 0.4 s; tests do not change it."""
    from raven2_station import library
    return library.Library(ROOT)


@pytest.fixture(name="ready")
def started():
    """A simulation of module raven2_trainer that is ready for commands."""
    from built_module import PICK, raven2_trainer
    with raven2_trainer.Simulation(PICK) as simulation:
        simulation.start()
        yield simulation
