"""Reads a session of raven2_trainer: the log session.rlog and the JSON files next to it.

The log describes itself: its first record lists the fields of every other record, and the numpy types are built from
that list, so this module knows no field by name. Format: doc/session.md. It is the session.py of the Python package as
well (with raven2_formulas.py as _formulas.py): that is why this file is long.

    import raven2_session                          # in scripts/; elsewhere: from raven2_trainer import session as raven2_session
    session = raven2_session.Session("sessions/2026-01-31T12-00-00Z")
    session.log.ticks["model"]["arms"]["q"]         # shape (ticks, 2 arms, 7 joints), rad; m for joint 3
    session.log.ticks["robot"]["active_fault"]      # shape (ticks,)
    session.log.names("tick", "model.mode")         # ["waiting", "pedal_up", ...]
    session.metrics["model_robot_error_mm"]["mean"]
"""

import collections
import ctypes
import ctypes.util
import fcntl
import functools
import json
import mmap
import os
import struct
import zlib

import numpy as np

try:
    from . import _formulas as formulas  # in the Python package
except ImportError:
    import raven2_formulas as formulas

MAGIC = b"RV2L"
FRAME = struct.Struct("<4sHHIQ")  # magic, type, version, payload length, record number
CRC = struct.Struct("<I")
MAX_PAYLOAD = 16 * 1024  # bytes, of any record but the first
MAX_HEADER = 1024 * 1024  # bytes, of the first
MAX_CHUNK = 2304 * 1024  # bytes, of a chunk
MAX_CONTENTS = 8 * 1024 * 1024  # bytes, of a chunk's contents
CHUNK = 14  # type of a record that holds others, compressed
CHUNK_VERSIONS = (1, 2)  # 1 has no formulas
CHUNK_SPAN = struct.Struct("<qq")  # first and last physics tick of its records; then the compressed contents
CHUNK_HEAD = struct.Struct("<II")  # records, groups
CHUNK_GROUP = struct.Struct("<HHII")  # type, version, records, numbers in a record
FORMS = (0x88, 8, 4, 2, 1)  # of a number: its bytes, and bit 7 for floating-point
MAX_ORDER = 4  # of differences
FORMULA_BIT = 0x80  # of an order: the number is kept as its difference to a formula's result
MAX_GROUPS = 255
MAX_FORMULAS = 16  # of a group
MAX_FORMULA_ROWS = 1000  # records of a group with formulas
ZSTD_MAGIC = bytes.fromhex("28b52ffd")
FORMAT_NAME = "raven2_trainer session log"
FORMAT_VERSIONS = (1, 2, 3)  # 1 has no chunks, 2 no formulas
NO_TRAINING = {"exercise": "none", "drill": "none", "trainee": "", "curriculum": "none"}


class SessionError(RuntimeError):
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

    ticks: (first, last) physics tick [ms], `model.tick`, to read only a part of a long session: chunks outside are passed
    over. `clean`, `recovered`, `counts` and `from_flight_recorder` are those of the whole, `lost` and `bad_bytes` of what was
    read.
    """

    def __init__(self, path, ticks=None):
        self._span = ticks
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
        fields = _entry(self.header["records"], record, "record")["fields"]
        for part in field.split("."):
            found = _entry(fields, part, "field")
            fields = found.get("fields", [])
        if "names" not in found:
            raise ValueError(f"{field} has numbers, no names")
        return found["names"]

    def _load(self, path, data, flight):
        self.header, position = _read_header(path, data)
        kinds = {entry["type"]: entry for entry in self.header["records"]}
        types = {number: dtype_of(entry["fields"]) for number, entry in kinds.items()}
        known = {n: (kinds[n]["version"], types[n].itemsize) for n in kinds}
        counts = next(number for number, entry in kinds.items() if entry["name"] == "counts")
        if flight and _is_finished(data, position, (counts, *known[counts])):
            flight = None  # its writer was killed before it could remove the file: the log has all
        end = min(len(data), flight.log_size) if flight else len(data)
        rows = _gathered(data, self._scan(data, position, end, known), {n: size for n, (_, size) in known.items()})
        self._arrays = {kinds[n]["name"]: np.frombuffer(rows[n], types[n]) for n in kinds}
        if flight and not len(self._arrays["counts"]):
            self.lost += flight.lost()
            for name, array in flight.records(types):
                self.from_flight_recorder += len(array)
                self._arrays[name] = np.concatenate([self._arrays[name], array])
        self._arrays = {name: self._within_span(name, array) for name, array in self._arrays.items()}

    def _is_outside(self, payload):
        """Whether a chunk lies before or behind the ticks that were asked for."""
        if not self._span or len(payload) < CHUNK_SPAN.size:
            return False
        first, last = CHUNK_SPAN.unpack_from(payload)
        return last < self._span[0] or first > self._span[1]

    def _chunk_groups(self, payload, version, known):
        """[(type, records, place)] that can be used, and whether that is all of known types. @throw ValueError."""
        if self._is_outside(payload):
            return [], True
        ours = [(place, group) for place, group in enumerate(_Chunk(payload, version).groups)
                if group.kind in known and known[group.kind][0] == group.version]
        usable = [(group.kind, group.count, place) for place, group in ours if group.length == known[group.kind][1]]
        return usable, len(usable) == len(ours)

    def _within_span(self, name, array):
        """The records of the ticks that were asked for. All but two kinds begin with their tick."""
        if not self._span or name in ("counts", "recovery") or not len(array):
            return array
        ticks = np.ndarray(array.shape, "<i8", array, strides=array.strides)
        return array[(ticks >= self._span[0]) & (ticks <= self._span[1])]

    def _scan(self, data, position, end, known):
        """[(offset, [(type, records, place in the chunk)], (size, version) of the chunk or None)] of what is intact, of known
        types and lengths."""
        found = []
        plain = {number: ((number, 1, 0),) for number in known}
        skipped_from = None  # start of a stretch without an intact record
        cut = False
        while position < end:
            state, kind, version, size = _look(data, position, end)
            body, is_whole = position + FRAME.size, True
            if state == "intact" and kind == CHUNK and version in CHUNK_VERSIONS:
                try:
                    groups, is_whole = self._chunk_groups(data[body : body + size], version, known)
                    if groups:
                        found.append((body, groups, (size, version)))
                except ValueError:
                    state = "bad"
            elif state == "intact" and kind in known and known[kind][0] == version:
                is_whole = size == known[kind][1]
                if is_whole:
                    found.append((body, plain[kind], None))
            if state == "intact":
                if skipped_from is not None:
                    self.bad_bytes += position - skipped_from
                    skipped_from = None
                position = body + size + CRC.size
                if not is_whole:
                    self.bad_bytes += FRAME.size + size + CRC.size
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


def _gathered(data, found, sizes):
    """The records of each type, one behind the other. Chunks are read a second time, which saves their memory."""
    totals = dict.fromkeys(sizes, 0)
    for number, count, _ in (group for _, groups, _ in found for group in groups):
        totals[number] += count * sizes[number]
    rows = {number: memoryview(bytearray(total)) for number, total in totals.items()}
    ends = dict.fromkeys(sizes, 0)
    for offset, groups, chunk in found:
        if chunk:
            size, version = chunk
            chunk = _Chunk(data[offset : offset + size], version)
        for number, count, place in groups:
            begin, size = ends[number], sizes[number]
            ends[number] = end = begin + count * size
            if chunk:
                _read_rows(chunk.groups[place], np.frombuffer(rows[number][begin:end], np.uint8).reshape(count, size))
            else:
                rows[number][begin:end] = data[offset : offset + size]
    return {number: view.toreadonly() for number, view in rows.items()}


@functools.lru_cache(maxsize=1)
def _zstd():
    """The library, which Debian's own package manager needs, too."""
    try:
        library = ctypes.CDLL("libzstd.so.1")
    except OSError:
        name = ctypes.util.find_library("zstd")
        if name is None:
            raise SessionError("the library zstd is missing: install Debian's libzstd1") from None
        library = ctypes.CDLL(name)
    library.ZSTD_getFrameContentSize.restype = ctypes.c_ulonglong
    library.ZSTD_getFrameContentSize.argtypes = [ctypes.c_char_p, ctypes.c_size_t]
    library.ZSTD_decompress.restype = ctypes.c_size_t
    library.ZSTD_decompress.argtypes = [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_char_p, ctypes.c_size_t]
    return library


def _contents(payload):
    size = _zstd().ZSTD_getFrameContentSize(payload, len(payload))
    if size > MAX_CONTENTS:  # also its two values for errors
        raise ValueError("no compressed frame")
    contents = np.empty(size, np.uint8)
    if _zstd().ZSTD_decompress(contents.ctypes.data, size, payload, len(payload)) != size:
        raise ValueError("damaged")
    return contents


# Records of a chunk that are alike; length: bytes of each.
_Group = collections.namedtuple("_Group", "kind version count length forms orders formulas planes")


class _Chunk:
    """`groups` of a chunk. @throw ValueError for what no writer makes."""

    def __init__(self, payload, version):
        contents = _contents(payload[CHUNK_SPAN.size :])
        try:
            records, count = CHUNK_HEAD.unpack_from(contents)
            if not records or count > MAX_GROUPS:
                raise ValueError("no records, or too many groups")
            heads = [CHUNK_GROUP.unpack_from(contents, CHUNK_HEAD.size + i * CHUNK_GROUP.size) for i in range(count)]
        except struct.error as error:
            raise ValueError(str(error)) from None
        position = CHUNK_HEAD.size + count * CHUNK_GROUP.size
        order = contents[position : position + records]  # each record's group; arrays of one kind do not need it
        position += len(order)
        if len(order) != records or np.bincount(order, minlength=count).tolist() != [head[2] for head in heads]:
            raise ValueError("not the records that it names")
        self.groups = []
        for head in heads:
            position = self._read_group(contents, position, head, version > 1)
        if position != len(contents):
            raise ValueError("too long")

    def _read_group(self, contents, position, head, has_formulas):
        """@return where it ends."""
        kind, version, rows, columns = head
        forms, codes = contents[position : position + 2 * columns].reshape(2, columns)
        position += 2 * columns
        length = int((forms & 0x0F).sum())
        used, position = _read_formulas(contents, position, rows) if has_formulas else ([], position)
        if (not rows or not 0 < length <= MAX_PAYLOAD or kind in (0, CHUNK) or not set(forms.tobytes()) <= set(FORMS)
                or (codes & ~np.uint8(FORMULA_BIT)).max() > MAX_ORDER or (codes[forms != 0x88] >= FORMULA_BIT).any()
                or not _are_in_order(used, forms, codes) or position + rows * length > len(contents)):
            raise ValueError("no group of records")
        planes = contents[position : position + rows * length]
        self.groups.append(_Group(kind, version, rows, length, forms, codes, used, planes))
        return position + rows * length


def _read_formulas(contents, position, rows):
    """(formulas, where they end). @throw ValueError."""
    count = int(contents[position]) if position < len(contents) else 0
    position += 1
    if count > MAX_FORMULAS or (count and rows > MAX_FORMULA_ROWS):
        raise ValueError("too many formulas, or records for them")
    used = []
    for _ in range(count):
        used.append(formulas.Formula(contents, position))
        position += used[-1].size
    if sum(formula.is_robot for formula in used) > 1:
        raise ValueError("the robot's formula is there twice")
    return used, position


def _are_in_order(used, forms, codes):
    """Whether each number that a formula needs is known by then, and all are at the end."""
    is_known = codes < FORMULA_BIT
    for formula in used:
        if not formula.fits(forms) or not all(is_known[first : first + width].all() for first, width in formula.needs):
            return False
        for first, width in formula.gives:
            is_known[first : first + width] = True
    return bool(is_known.all())


@functools.lru_cache(maxsize=64)
def _layout(forms):
    """[(form, columns, stretches)]; a stretch (first, end, offset in the record) is columns that lie side by side."""
    forms = np.frombuffer(forms, np.uint8)
    offsets = np.concatenate([[0], np.cumsum(forms & 0x0F, dtype=np.int64)])
    blocks = []
    for form in FORMS:
        columns = np.flatnonzero(forms == form)
        if len(columns):
            begins = np.flatnonzero(np.diff(columns, prepend=-2) != 1)
            ends = np.append(begins[1:], len(columns))
            blocks.append((form, columns, [(begin, end, offsets[columns[begin]]) for begin, end in zip(begins, ends)]))
    return blocks


def _read_rows(group, rows):
    """The records of a group into an array (record, byte). Each number was kept as a difference to the records before."""
    count = len(rows)
    begin = 0
    for form, columns, stretches in _layout(group.forms.tobytes()):
        width = form & 0x0F
        end = begin + width * len(columns) * count
        orders = group.orders[columns] & ~np.uint8(FORMULA_BIT)
        by_order = np.argsort(-orders.astype(int), kind="stable")  # the columns' order in the data
        planes = group.planes[begin:end].reshape(width, len(columns), count)
        numbers = _numbers(planes, orders[by_order])
        if form >= 0x80:
            plain = group.orders[columns][by_order] < FORMULA_BIT
            numbers = np.where(plain[:, None], _ordered(numbers), numbers) if group.formulas else _ordered(numbers)
        sorted_back = np.empty((count, len(columns)), numbers.dtype)
        sorted_back[:, by_order] = numbers.T
        values = sorted_back.view(np.uint8)
        for first, last, offset in stretches:
            rows[:, offset : offset + (last - first) * width] = values[:, first * width : last * width]
        begin = end
    if group.formulas:
        _add_formulas(group, rows)


def _add_formulas(group, rows):
    """To the records, in which some numbers are still differences to the results of formulas."""
    offsets = np.concatenate([[0], np.cumsum(group.forms & 0x0F, dtype=np.int64)])

    def columns(first, width, dtype):
        return np.ascontiguousarray(rows[:, offsets[first] : offsets[first + width]]).view(dtype)

    is_known = group.orders < FORMULA_BIT
    for formula in group.formulas:
        needed = [columns(first, width, "<i8")[:, 0] if width == 1 else np.ascontiguousarray(columns(first, width, "<f8").T)
                  for first, width in formula.needs]
        results = _ordered(formula.results(needed).view("<u8"))
        place = 0
        for first, width in formula.gives:
            residuals = columns(first, width, "<u8")
            sums = _ordered(residuals + results[place : place + width].T)
            mixed = np.where(is_known[first : first + width], residuals, sums)
            rows[:, offsets[first] : offsets[first + width]] = np.ascontiguousarray(mixed).view(np.uint8)
            is_known[first : first + width] = True
            place += width


def _ordered(bits):
    """Bits of f64 as integers that grow with them, and the reverse."""
    negative = bits >> np.uint64(63)
    return bits ^ ((np.uint64(0) - negative) >> np.uint64(1))


def _numbers(planes, orders):
    """Array (column, record) of the unsigned numbers whose bytes these are, lowest first; highest orders come first."""
    width, columns, count = planes.shape
    split = np.empty((columns, count, width), np.uint8)
    for k in range(width):
        split[:, :, k] = planes[k]
    numbers = split.view(f"<u{width}")[:, :, 0]
    one = numbers.dtype.type(1)
    changes = numbers[: np.count_nonzero(orders)]
    odd = changes & one
    np.right_shift(changes, one, out=changes)
    np.negative(odd, out=odd)
    np.bitwise_xor(changes, odd, out=changes)
    for order in range(1, int(orders.max(initial=0)) + 1):
        part = numbers[: np.count_nonzero(orders >= order)]
        np.cumsum(part, axis=1, dtype=part.dtype, out=part)
    return numbers


def _look(data, position, end, limit=MAX_PAYLOAD):
    """The record at a position: (intact | bad | cut, type, version, payload length)."""
    if end - position < FRAME.size:
        return "cut", 0, 0, 0
    magic, kind, version, size, _ = FRAME.unpack_from(data, position)
    if magic != MAGIC or size > max(limit, MAX_CHUNK if kind == CHUNK else 0):
        return "bad", 0, 0, 0
    body = position + FRAME.size + size
    if body + CRC.size > end:
        return "cut", 0, 0, 0
    begin = position + FRAME.size + CHUNK_SPAN.size
    if kind == CHUNK and version in CHUNK_VERSIONS and data[begin : begin + len(ZSTD_MAGIC)] != ZSTD_MAGIC:
        return "bad", 0, 0, 0  # the CRC of what is so long takes time
    intact = zlib.crc32(data[position:body]) == CRC.unpack_from(data, body)[0]
    return ("intact" if intact else "bad"), kind, version, size


def _is_finished(data, position, counts):
    """Whether a log ends with its counts (type, version, length), which are never in a chunk."""
    last = len(data) - FRAME.size - counts[2] - CRC.size
    return last >= position and _look(data, last, len(data)) == ("intact", *counts)


def _read_header(path, data):
    state, kind, _, size = _look(data, 0, len(data), MAX_HEADER)
    if state != "intact" or kind != 0:
        raise SessionError(f"{path}: is no session log, or its first record is damaged")
    try:
        header = json.loads(data[FRAME.size : FRAME.size + size])
    except ValueError as error:
        raise SessionError(f"{path}: first record: {error}") from None
    version = header.get("format_version")
    if header.get("format") != FORMAT_NAME or type(version) is not int or version not in FORMAT_VERSIONS:
        raise SessionError(f"{path}: format version {version}, this program reads {FORMAT_VERSIONS[0]} to {FORMAT_VERSIONS[-1]}")
    return header, FRAME.size + size + CRC.size


def read_header(path):
    """The header of a log alone, without reading the rest. @throw SessionError."""
    try:
        with open(os.fspath(path), "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
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


def _columns(name, values):
    """(name, one number a record) of each field."""
    if values.ndim > 1:
        for i in range(values.shape[1]):
            yield from _columns(f"{name}.{i}", values[:, i])
    elif values.dtype.names:
        for field in values.dtype.names:
            yield from _columns(f"{name}.{field}" if name else field, values[field])
    else:
        yield name, values


def _entry(entries, name, what):
    for entry in entries:
        if entry["name"] == name:
            return entry
    raise ValueError(f"no {what} is called {name!r}, expected one of {', '.join(entry['name'] for entry in entries)}")


class Session:
    """A session directory: `log`, and `metrics`, `faults`, `meta` as dicts (empty where the file is missing). `ticks` as SessionLog."""

    def __init__(self, directory, ticks=None):
        self.directory = directory
        self._place = os.path.abspath(directory)  # a later chdir changes nothing
        path = os.path.join(directory, "session.rlog")
        if not os.path.isfile(path):
            raise SessionError(f"{directory}: is no session directory (no session.rlog in it)")
        self.log = SessionLog(path, ticks)
        self.metrics = _load_json(os.path.join(directory, "metrics.json"))
        self.faults = _load_json(os.path.join(directory, "faults.json"))
        self.meta = _load_json(os.path.join(directory, "meta.json"))

    def table(self, records="ticks"):
        """Columns by name, {"model.arms.1.q.3": array (records,)}: indices count from 0. pandas.DataFrame takes it."""
        return dict(_columns("", getattr(self.log, records)))

    def file(self, name):
        """Path of a file of the session, or None if it is not there."""
        path = os.path.join(self._place, name)
        return path if os.path.isfile(path) else None
