"""Access to the pages: cookies, passwords, origins."""

import base64
import hashlib
import hmac
import ipaddress
import json
import os
import pathlib
import secrets
import sys
import threading
import time
from urllib.parse import urlsplit

LIFETIME = 12 * 3600  # [s] of a login
TRIES = 5             # wrong passwords, from all addresses together, in
TRIES_IN = 60.0       # [s]
LOCAL_NAMES = {"localhost", "127.0.0.1", "::1"}


SCRYPT = {"n": 1 << 15, "r": 8, "p": 1, "maxmem": 1 << 26}  # RFC 7914; some 0.1 s


def cookie_name(port):
    """Browsers send a cookie to all ports of a host: each station needs a different name."""
    return f"raven2_station_{port}"


def make_hash(password):
    """`scrypt$SALT$HASH`, for a password file."""
    salt = secrets.token_bytes(16)
    return "$".join(["scrypt", *(base64.b64encode(b).decode() for b in (salt, hashlib.scrypt(password.encode(), salt=salt, **SCRYPT)))])


def fits(password, stored):
    try:
        kind, salt, known = stored.split("$")
        found = hashlib.scrypt(password.encode(), salt=base64.b64decode(salt, validate=True), **SCRYPT)
        return kind == "scrypt" and hmac.compare_digest(found, base64.b64decode(known, validate=True))
    except ValueError:
        return False


def is_loopback(address):
    try:
        return ipaddress.ip_address(address).is_loopback
    except ValueError:
        return address == "localhost"


class Access:
    """@param password_hash: of make_hash(); None on loopback alone. @param file: keeps logins over a restart of the station,
    but not over a change of the password."""

    def __init__(self, password_hash, file=None):
        self._hash, self._file = password_hash, file and pathlib.Path(file)
        self._password = hashlib.sha256((password_hash or "").encode()).hexdigest()  # a new one ends all logins
        self._logins = self._read()
        self._wrong = []
        self._checks = threading.Lock()

    @property
    def needs_password(self):
        return self._hash is not None

    def _read(self):
        try:
            if self._file is None or self._file.stat().st_mode & 0o077:
                return {}
            content = json.loads(self._file.read_text(encoding="utf-8"))
            if content["password"] != self._password:
                return {}
            return {str(k): float(v) for k, v in content["logins"].items() if v > time.time()}
        except (OSError, ValueError, AttributeError, TypeError, KeyError):
            return {}

    def _write(self):
        """On a full disk a login lasts as long as this station."""
        if self._file is None:
            return
        part = self._file.with_suffix(".part")
        try:
            self._file.parent.mkdir(parents=True, exist_ok=True)
            with open(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "w", encoding="utf-8") as out:
                json.dump({"password": self._password, "logins": self._logins}, out)
            os.replace(part, self._file)
        except OSError as error:
            print(f"{self._file}: cannot be written: {error.strerror}; after a restart, log in again", file=sys.stderr)

    def check_password(self, password):
        """One at a time: tries at the same moment count, too. @return "" or a sentence that says why not."""
        with self._checks:
            now = time.monotonic()
            self._wrong = [t for t in self._wrong if now - t < TRIES_IN]
            if len(self._wrong) >= TRIES:
                return "Too many wrong passwords: wait a minute."
            if fits(password, self._hash):
                return ""
            self._wrong.append(now)
            return "Wrong password."

    def login(self):
        """@return the cookie's value."""
        now = time.time()
        self._logins = {k: v for k, v in self._logins.items() if v > now}
        token = secrets.token_urlsafe(32)
        self._logins[token] = now + LIFETIME
        self._write()
        return token

    def knows(self, token):
        if not token or not token.isascii():
            return False
        until = 0.0
        for known, end in self._logins.items():  # all of them: the time taken says nothing
            if hmac.compare_digest(known.encode(), token.encode()):
                until = end
        return until > time.time()


def same_origin(origin, host):
    """Of a WebSocket or POST: the page that asks is one of ours."""
    try:
        return bool(origin) and urlsplit(origin).netloc == host
    except ValueError:
        return False


def is_local_name(host):
    """Against DNS rebinding: on loopback the address must be localhost."""
    name = host.rsplit(":", 1)[0].strip("[]") if not host.endswith("]") else host.strip("[]")
    return name in LOCAL_NAMES
