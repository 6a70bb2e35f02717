"""Reads a session of raven2_trainer: the log session.rlog and the JSON files next to it.

The log describes itself: its first record lists the fields of every other record, and the numpy types are built from
that list, so this module knows no field by name. Format: doc/session.md.

    import raven2_session
    session = raven2_session.Session("sessions/2026-01-31T12-00-00Z")
    session.log.ticks["model"]["arms"]["q"]         # shape (ticks, 2 arms, 7 joints), rad; m for joint 3
    session.log.ticks["robot"]["active_fault"]      # shape (ticks,)
    session.log.names("tick", "model.mode")         # ["waiting", "pedal_up", ...]
    session.metrics["model_robot_error_mm"]["mean"]
"""

import fcntl
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
NO_TRAINING = {"exercise": "none", "drill": "none", "trainee": "", "curriculum": "none"}


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


def _memory_dtype(fields, size):
    """The numpy type of a struct as it lies in memory, from the flight recorder's description."""
    formats = []
    for field in fields:
        kind = field["type"]
        base = (_memory_dtype(field["fields"], field["size"]) if kind == "struct"
                else np.dtype("<" + kind[0] + str(int(kind[1:]) // 8)))
        formats.append((base, tuple(field["shape"])))
    return np.dtype({"names": [field["name"] for field in fields], "formats": formats,
                     "offsets": [field["offset"] for field in fields], "itemsize": size})


def _checksums(words, index):
    """recordChecksum() of rows of 64-bit words (include/raven2_trainer/core/record_ring.h)."""
    with np.errstate(over="ignore"):
        value = np.uint64(0xCBF29CE484222325) ^ index.astype(np.uint64)
        for column in range(words.shape[1]):
            value = (value ^ words[:, column]) * np.uint64(0x100000001B3)
            value ^= value >> np.uint64(29)
    return value


class FlightRecorder:
    """The record queues of a session whose process was killed: the records in them after the log's `log_size` bytes.

    Made by open_for(path of a log), which gives None unless there is a whole one that belongs to the log and nobody
    writes to. Reads only: recover_session is what completes a log.
    """

    HEAD = struct.Struct("<8sQQQ")  # magic, size of the description, device and inode of the log
    LAYOUT = 64 + 2 * 192  # where the description begins: head and two checkpoints, each aligned to 64 bytes

    def __init__(self, data):
        self._data = data
        _, size, _, _ = self.HEAD.unpack_from(data)
        self._layout = json.loads(data[self.LAYOUT : self.LAYOUT + size].decode())
        queues = len(self._layout["queues"])
        newest = max(self._checkpoints(queues), key=lambda words: words[0])
        self.log_size = int(newest[1])
        self._heads, self._reported = newest[3 : 3 + queues], newest[3 + queues :]

    @classmethod
    def open_for(cls, log_path):
        path = os.path.join(os.path.dirname(log_path), "flight_recorder")
        try:
            with open(path, "rb") as file, open(log_path, "rb") as log:
                fcntl.flock(log, fcntl.LOCK_SH | fcntl.LOCK_NB)  # held by a living writer
                data = file.read()
                magic, _, device, inode = cls.HEAD.unpack_from(data)
                status = os.fstat(log.fileno())
                if (magic, device, inode) != (b"RVFLIGHT", status.st_dev, status.st_ino):
                    return None
                return cls(data)
        except (OSError, ValueError, struct.error, KeyError):
            return None

    def _checkpoints(self, queues):
        count = 3 + 2 * queues  # sequence, log size, next number, heads and losses of the queues
        for offset in self._layout["checkpoints"]:
            words = np.frombuffer(self._data, "<u8", count + 1, offset)
            if words[0] and _checksums(words[None, :count], np.zeros(1))[0] == words[count]:
                yield words

    def records(self, types):
        """(name, packed array) for each queue; `types`: numpy types of the log by record type number."""
        for queue in self._layout["queues"]:
            head = int(self._heads[queue["kind"]])
            tail = int(np.frombuffer(self._data, "<u8", 1, queue["tail"])[0])
            count = tail - head if 0 <= tail - head <= queue["capacity"] else 0
            yield queue["name"], self._take(queue, head, count, types[queue["type"]])

    def lost(self):
        """Lost records that no gap record reports, all kinds."""
        return sum(int(np.frombuffer(self._data, "<u8", 1, queue["dropped"])[0]) - int(self._reported[queue["kind"]])
                   for queue in self._layout["queues"])

    def _take(self, queue, head, count, packed):
        stride, size = queue["stride"], queue["size"]
        slots = np.frombuffer(self._data, np.uint8, queue["capacity"] * stride, queue["slots"])
        index = np.arange(head, head + count)
        rows = slots.reshape(queue["capacity"], stride)[index % queue["capacity"]]
        words = np.ascontiguousarray(rows[:, :size]).view("<u8").reshape(count, size // 8)
        check = np.ascontiguousarray(rows[:, queue["check"] : queue["check"] + 8]).view("<u8").reshape(count)
        whole = rows[_checksums(words, index) == check]
        memory = np.ascontiguousarray(whole[:, :size]).view(_memory_dtype(queue["fields"], size)).reshape(len(whole))
        return _packed(memory, packed)


def _packed(memory, packed):
    """The same values in the log's type, field by field."""
    result = np.zeros(memory.shape, packed)
    for name in packed.names:
        base = packed[name].base
        result[name] = _packed(memory[name], base) if base.names else memory[name]
    return result


class SessionLog:
    """One log, all in memory: `ticks`, `haptic`, `commands`, `requests`, `plans`, `executions`, `exercise_events`,
    `contacts`, `counts`, `gaps`, `recovery` as structured arrays. `training` has the header's `exercise`, `drill`,
    `trainee` and `curriculum`, "none" and "" in logs older than they.

    Damaged records are left out, as the C++ reader does: `bad_bytes` says how much. `clean` is true if the log ends
    with the session's counters, `recovered` if its writer was killed and recover_session completed it,
    `truncated_bytes` the size of a last record that was cut short. `lost` is the sum of the gap records.
    If the writer was killed and nobody recovered the log yet, the records that its flight recorder holds are appended
    here and `from_flight_recorder` says how many; the files stay as they are.
    """

    def __init__(self, path):
        self.bad_bytes = 0
        self.truncated_bytes = 0
        self.from_flight_recorder = 0
        self.lost = 0
        flight = FlightRecorder.open_for(path)
        try:
            with open(path, "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
                self._load(path, data, flight)
        except (OSError, ValueError) as error:  # ValueError: an empty file cannot be mapped
            raise SessionError(f"{path}: cannot be read as a session log: {error}") from None
        self.ticks = self._arrays["tick"]
        self.haptic = self._arrays["haptic"]
        self.commands = self._arrays["command"]
        self.requests = self._arrays["request"]
        self.plans = self._arrays["plan"]
        self.executions = self._arrays.get("execution")  # None in logs older than they
        self.exercise_events = self._arrays.get("exercise")  # None in logs older than they
        self.training = {key: self.header.get(key, missing) for key, missing in NO_TRAINING.items()}
        self.faults = self._arrays.get("faults")  # None in logs older than they
        self.contacts = self._arrays.get("contact")  # None in logs older than contact records
        self.counts = self._arrays["counts"]
        self.gaps = self._arrays.get("gap")  # None in logs older than gap records
        self.recovery = self._arrays.get("recovery")
        self.clean = len(self.counts) > 0
        self.recovered = self.recovery is not None and len(self.recovery) > 0
        if self.gaps is not None:
            self.lost += int(self.gaps["lost"].sum())

    def names(self, record, field):
        """Names of the values of an enum, e.g. names("tick", "model.mode")."""
        fields = next(entry["fields"] for entry in self.header["records"] if entry["name"] == record)
        for part in field.split("."):
            found = next(entry for entry in fields if entry["name"] == part)
            fields = found.get("fields", [])
        return found["names"]

    def _load(self, path, data, flight):
        self.header, position = _read_header(path, data)
        kinds = {entry["type"]: entry for entry in self.header["records"]}
        types = {number: dtype_of(entry["fields"]) for number, entry in kinds.items()}
        end = min(len(data), flight.log_size) if flight else len(data)
        found = self._scan(data, position, end, {n: (kinds[n]["version"], types[n].itemsize) for n in kinds})
        self._arrays = {}
        for number, offsets in found.items():
            size = types[number].itemsize
            self._arrays[kinds[number]["name"]] = np.frombuffer(_gathered(data, offsets, size), dtype=types[number])
        if flight and not len(self._arrays["counts"]):
            self.lost += flight.lost()
            for name, array in flight.records(types):
                self.from_flight_recorder += len(array)
                self._arrays[name] = np.concatenate([self._arrays[name], array])

    def _scan(self, data, position, end, known):
        """Offsets of the intact payloads of each known type."""
        found = {number: [] for number in known}
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
            position = data.find(MAGIC, position + 1, end)
            if position < 0:
                break
        if skipped_from is not None:
            if cut:
                self.truncated_bytes = end - skipped_from
            else:
                self.bad_bytes += end - skipped_from
        return found


def _gathered(data, offsets, size):
    """Payloads one behind the other, read-only; never more than one of them twice in memory."""
    payloads = bytearray(len(offsets) * size)
    for i, offset in enumerate(offsets):
        payloads[i * size : (i + 1) * size] = data[offset : offset + size]
    return memoryview(payloads).toreadonly()


def _look(data, position, end, limit=MAX_PAYLOAD):
    """The record at a position: (intact | bad | cut, type, version, payload length)."""
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


def read_header(path):
    """The header of a log alone, without reading the rest. @throw SessionError."""
    try:
        with open(path, "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
            return _read_header(path, data)[0]
    except (OSError, ValueError) as error:  # ValueError: an empty file cannot be mapped
        raise SessionError(f"{path}: cannot be read as a session log: {error}") from None


def _load_json(path):
    """The file's content, or an empty dict if it is missing (a session that was cut off has no metrics)."""
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
