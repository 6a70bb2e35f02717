"""Tests logins, passwords and the addresses that may use the station."""

import concurrent.futures
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from raven2_station import access, server  # noqa: E402


def test_a_login_is_known_until_it_ends_also_after_a_restart(tmp_path, monkeypatch):
    door = access.Access(None, tmp_path / "logins.json")
    token = door.login()
    assert door.knows(token) and not door.knows(token[:-1] + "?") and not door.knows(None) and not door.knows("")
    assert (tmp_path / "logins.json").stat().st_mode & 0o077 == 0
    assert access.Access(None, tmp_path / "logins.json").knows(token)
    (tmp_path / "logins.json").chmod(0o644)
    assert not access.Access(None, tmp_path / "logins.json").knows(token), "others could have written it"
    assert not door.knows("\udcff") and not door.knows("\u00fc"), "a header may have any bytes"
    now = access.time.time()
    monkeypatch.setattr(access.time, "time", lambda: now + access.LIFETIME + 1)
    assert not door.knows(token)


def test_a_new_password_ends_all_logins(tmp_path):
    file, first, second = tmp_path / "logins.json", access.make_hash("a"), access.make_hash("b")
    token = access.Access(first, file).login()
    assert access.Access(first, file).knows(token) and first not in file.read_text()
    assert not access.Access(second, file).knows(token) and not access.Access(None, file).knows(token)


def test_a_login_holds_on_a_full_disk_until_the_station_ends(tmp_path, capsys):
    (tmp_path / "logins.part").symlink_to("/dev/full")
    door = access.Access(None, tmp_path / "logins.json")
    assert door.knows(door.login())
    assert "log in again" in capsys.readouterr().err


def test_wrong_passwords_are_counted_and_then_wait():
    door = access.Access(access.make_hash("right"))
    assert not access.fits("right", "scrypt$nonsense") and not access.fits("right", "") and access.make_hash("a") != access.make_hash("a")
    assert door.needs_password and door.check_password("right") == ""
    for _ in range(access.TRIES):
        assert door.check_password("wrong") == "Wrong password."
    assert "wait" in door.check_password("right")


def test_wrong_passwords_are_forgotten_after_a_minute(monkeypatch):
    door, now = access.Access(access.make_hash("right")), access.time.monotonic()
    for _ in range(access.TRIES):
        door.check_password("wrong")
    monkeypatch.setattr(access.time, "monotonic", lambda: now + access.TRIES_IN + 30.0)
    assert door.check_password("right") == ""


def test_an_address_that_only_looks_local_is_not():
    for address in ("127.0.0.1.evil.example", "127.evil.example", "localhost.evil.example", "127.0.0.256", "", "1"):
        assert not access.is_loopback(address), address
    for address in ("127.0.0.1", "127.255.0.9", "::1", "localhost"):
        assert access.is_loopback(address), address


def test_an_origin_that_is_no_address_is_foreign():
    assert not access.same_origin("http://[", "localhost:8080") and not access.same_origin("http://[::1", "[::1]:8080")


def test_origins_and_names():
    assert access.same_origin("http://localhost:8080", "localhost:8080")
    for origin in (None, "", "null", "http://evil.example", "http://localhost:8081", "https://localhost:8080.evil.example",
                   "http://evillocalhost:8080", "http://x@localhost:8080"):
        assert not access.same_origin(origin, "localhost:8080")
    for host in ("localhost:8080", "127.0.0.1:8080", "[::1]:8080", "localhost"):
        assert access.is_local_name(host)
    for host in ("evil.example:8080", "127.0.0.1.evil.example", ""):
        assert not access.is_local_name(host)
    assert access.is_loopback("127.0.0.5") and not access.is_loopback("0.0.0.0")


def test_a_report_may_run_its_scripts_but_not_as_the_station():
    """With allow-same-origin a script in it could use the instructor's login."""
    rules = [rule.split() for rule in server.REPORT_POLICY.split(";")]
    assert ["sandbox", "allow-scripts", "allow-popups"] in rules and ["default-src", "'none'"] in rules


def test_wrong_passwords_at_the_same_time_count_too(monkeypatch):
    door, tried = access.Access("x"), []
    monkeypatch.setattr(access, "fits", lambda *_: tried.append(1) or access.time.sleep(0.05))
    with concurrent.futures.ThreadPoolExecutor(20) as pool:
        list(pool.map(door.check_password, ["wrong"] * 20))
    assert len(tried) == access.TRIES
