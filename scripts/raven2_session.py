"""Reads a session of raven2_trainer: the log session.rlog and the JSON files beside it.

The log describes itself: its first record lists the fields of every other record, and the numpy types are built from
that list, so this module knows no field by name. Format: doc/session.md.

    import raven2_session
    session = raven2_session.Session("sessions/2026-01-31T12-00-00Z")
    session.log.ticks["model"]["arms"]["q"]         # shape (ticks, 2 arms, 7 joints), rad; m for joint 3
    session.log.ticks["robot"]["active_fault"]      # shape (ticks,)
    session.log.names("tick", "model.mode")         # ["waiting", "pedal_up", ...]
    session.metrics["model_robot_error_mm"]["mean"]
"""

import json
import mmap
import os
import struct
import zlib

import numpy as np

MAGIC = b"RV2L"
FRAME = struct.Struct("<4sHHIQ")  # magic, type, version, payload length, record number
CRC = struct.Struct("<I")
MAX_PAYLOAD = 16 * 1024  # bytes, of any record but the first
MAX_HEADER = 1024 * 1024  # bytes, of the first
FORMAT_NAME = "raven2_trainer session log"
FORMAT_VERSION = 1


class SessionError(Exception):
    """A file is missing or is not what it should be; the message names it and says why."""


def dtype_of(fields):
    """The packed little-endian numpy type of a list of fields of the log's schema."""
    entries = []
    for field in fields:
        kind = field["type"]
        base = dtype_of(field["fields"]) if kind == "struct" else np.dtype("<" + kind[0] + str(int(kind[1:]) // 8))
        entries.append((field["name"], base, tuple(field["shape"])))
    return np.dtype(entries)


class SessionLog:
    """One log, all in memory: `ticks`, `haptic`, `commands`, `requests`, `plans`, `contacts`, `counts` as
    structured arrays.

    Damaged records are left out, as the C++ reader does: `bad_bytes` says how much. `clean` is true if the log ends
    with the session's counters, `truncated_bytes` the size of a last record that was cut short.
    """

    def __init__(self, path):
        self.bad_bytes = 0
        self.truncated_bytes = 0
        try:
            with open(path, "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
                self._load(path, data)
        except (OSError, ValueError) as error:  # ValueError: an empty file cannot be mapped
            raise SessionError(f"{path}: cannot be read as a session log: {error}") from None
        self.ticks = self._arrays["tick"]
        self.haptic = self._arrays["haptic"]
        self.commands = self._arrays["command"]
        self.requests = self._arrays["request"]
        self.plans = self._arrays["plan"]
        self.faults = self._arrays.get("faults")  # None in logs older than they
        self.contacts = self._arrays.get("contact")  # None in logs older than contact records
        self.counts = self._arrays["counts"]
        self.clean = len(self.counts) > 0

    def names(self, record, field):
        """Names of the values of an enum, e.g. names("tick", "model.mode")."""
        fields = next(entry["fields"] for entry in self.header["records"] if entry["name"] == record)
        for part in field.split("."):
            found = next(entry for entry in fields if entry["name"] == part)
            fields = found.get("fields", [])
        return found["names"]

    def _load(self, path, data):
        self.header, position = _read_header(path, data)
        kinds = {entry["type"]: entry for entry in self.header["records"]}
        types = {number: dtype_of(entry["fields"]) for number, entry in kinds.items()}
        found = self._scan(data, position, {n: (kinds[n]["version"], types[n].itemsize) for n in kinds})
        self._arrays = {}
        for number, offsets in found.items():
            size = types[number].itemsize
            payloads = b"".join([data[offset : offset + size] for offset in offsets])
            self._arrays[kinds[number]["name"]] = np.frombuffer(payloads, dtype=types[number])

    def _scan(self, data, position, known):
        """Offsets of the intact payloads of each known type."""
        found = {number: [] for number in known}
        end = len(data)
        skipped_from = None  # start of a stretch without an intact record
        cut = False
        while position < end:
            state, kind, version, size = _look(data, position, end)
            if state == "intact":
                if skipped_from is not None:
                    self.bad_bytes += position - skipped_from
                    skipped_from = None
                if kind in known and known[kind][0] == version:
                    if size == known[kind][1]:
                        found[kind].append(position + FRAME.size)
                    else:
                        self.bad_bytes += FRAME.size + size + CRC.size
                position += FRAME.size + size + CRC.size
                continue
            if skipped_from is None:
                skipped_from, cut = position, state == "cut"
            position = data.find(MAGIC, position + 1)
            if position < 0:
                break
        if skipped_from is not None:
            if cut:
                self.truncated_bytes = end - skipped_from
            else:
                self.bad_bytes += end - skipped_from
        return found


def _look(data, position, end, limit=MAX_PAYLOAD):
    """What stands at a position: (intact | bad | cut, type, version, payload length)."""
    if end - position < FRAME.size:
        return "cut", 0, 0, 0
    magic, kind, version, size, _ = FRAME.unpack_from(data, position)
    if magic != MAGIC or size > limit:
        return "bad", 0, 0, 0
    body = position + FRAME.size + size
    if body + CRC.size > end:
        return "cut", 0, 0, 0
    intact = zlib.crc32(data[position:body]) == CRC.unpack_from(data, body)[0]
    return ("intact" if intact else "bad"), kind, version, size


def _read_header(path, data):
    state, kind, _, size = _look(data, 0, len(data), MAX_HEADER)
    if state != "intact" or kind != 0:
        raise SessionError(f"{path}: is no session log, or its first record is damaged")
    try:
        header = json.loads(data[FRAME.size : FRAME.size + size])
    except ValueError as error:
        raise SessionError(f"{path}: first record: {error}") from None
    if header.get("format") != FORMAT_NAME or header.get("format_version") != FORMAT_VERSION:
        version = header.get("format_version")
        raise SessionError(f"{path}: format version {version}, this program reads {FORMAT_VERSION}")
    return header, FRAME.size + size + CRC.size


def _load_json(path):
    """The file's content, or an empty dict if there is none (a session that was cut off has no metrics)."""
    try:
        with open(path, encoding="utf-8") as file:
            return json.load(file)
    except FileNotFoundError:
        return {}
    except ValueError as error:
        raise SessionError(f"{path}: {error}") from None


class Session:
    """A session directory: `log`, and `metrics`, `faults`, `meta` as dicts (empty where the file is missing)."""

    def __init__(self, directory):
        self.directory = directory
        path = os.path.join(directory, "session.rlog")
        if not os.path.isfile(path):
            raise SessionError(f"{directory}: is no session directory (no session.rlog in it)")
        self.log = SessionLog(path)
        self.metrics = _load_json(os.path.join(directory, "metrics.json"))
        self.faults = _load_json(os.path.join(directory, "faults.json"))
        self.meta = _load_json(os.path.join(directory, "meta.json"))

    def file(self, name):
        """Path of a file of the session, or None if it is not there."""
        path = os.path.join(self.directory, name)
        return path if os.path.isfile(path) else None
