"""For all tests of this folder. A fixture imports its modules itself, because most tests need neither of them."""
import os
import pathlib
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

# Our matrices are small. Otherwise each process that loads numpy starts a thread per core, at 0.1 s of processor time.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


@pytest.fixture(scope="session")
def known():
    """An instructor's choices. It reads most files of config, which takes 0.4 s; tests do not change it."""
    from raven2_station import library
    return library.Library(ROOT)


# Their sessions begin with a robot that has homed; how long that takes is nothing to them. All others use the package as it is.
HOME_QUICKLY = {"test_bands", "test_export_dataset", "test_export_learning", "test_figures", "test_make_gallery", "test_merge_truth",
                "test_opengl", "test_render_session", "test_score_session", *(f"test_python_{part}" for part in (
                    "gym", "hazards", "interpreter", "motion", "pictures", "planner", "recording", "settings", "state", "vector"))}


@pytest.fixture(scope="session", name="quick_share")
def configuration_with_quick_homing(tmp_path_factory):
    """The package's configuration, with a robot that homes in 0.5 s."""
    import raven2_lockstep
    share = tmp_path_factory.mktemp("share")
    root = raven2_lockstep.copy_of_configuration(share)
    raven2_lockstep.replace(root.parent / "virtual_raven.yaml", r"(?m)^homing_time: [0-9.]+", "homing_time: 0.5")
    return share


@pytest.fixture(scope="module", autouse=True)
def home_quickly(request):
    """The programs that a test starts read this variable, too."""
    if request.module.__name__ not in HOME_QUICKLY:
        yield
        return
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RAVEN2_TRAINER_SHARE", str(request.getfixturevalue("quick_share")))
        yield


@pytest.fixture(name="ready")
def started():
    """A simulation of module raven2_trainer that is ready for commands."""
    from built_module import PICK, raven2_trainer
    with raven2_trainer.Simulation(PICK) as simulation:
        simulation.start()
        yield simulation
