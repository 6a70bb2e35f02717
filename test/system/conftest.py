"""Makes `stack` importable. Skips the tests, with the reason, where the programs are not built. Fixtures of the station's tests."""

import asyncio
import os
import sys

import pytest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import stack  # noqa: E402


def pytest_collection_modifyitems(items):
    if os.path.exists(os.path.join(stack.PROGRAMS, "simulator")):
        return
    for item in items:
        item.add_marker(pytest.mark.skip(reason="the programs are not built"))


@pytest.fixture(scope="module")
def station(tmp_path_factory):
    """One for the tests of a file, with small pictures."""
    import station_rig  # aiohttp and ROS: for these tests alone
    config = station_rig.small_pictures(tmp_path_factory.mktemp("share") / "small")
    with station_rig.Station("--config", config) as started:
        yield started


@pytest.fixture(autouse=True)
def no_session_is_left(request):
    """A test that fails may leave its session running, and the next ones would fail for that alone. A class ends its own."""
    yield
    if "station" not in request.fixturenames or request.cls:
        return
    station = request.getfixturevalue("station")
    import station_rig
    if station.process.poll() is not None:
        station.start()
    if station.programs():
        asyncio.run(station_rig.end_session(station))
