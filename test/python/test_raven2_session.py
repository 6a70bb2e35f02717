"""Tests of scripts/raven2_session.py and of the programs built on it. Logs are written here by hand, with a schema of
our own, so that the reader is shown to follow the log and not a fixed layout.

    /usr/bin/python3 -m unittest discover -s test/python
"""

import ctypes
import functools
import json
import os
import random
import re
import struct
import subprocess
import sys
import tempfile
import unittest
import unittest.mock
import zlib

SCRIPTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts")
sys.path.insert(0, SCRIPTS)
sys.dont_write_bytecode = True

import numpy as np  # noqa: E402

import forked  # noqa: E402
import raven2_session  # noqa: E402


def field(name, kind, shape=(), fields=None, names=None):
    entry = {"name": name, "type": kind, "shape": list(shape), "unit": "", "meaning": ""}
    if fields:
        entry["fields"] = fields
    if names:
        entry["names"] = names
    return entry


MODES = ["waiting", "pedal_up", "teleoperating", "planning", "tracking", "stopped", "executing"]
POSE = [field("q", "f64", (7,)), field("p_BT", "f64", (3,))]
MODEL = [field("tick", "i64"), field("session_tick", "i64"), field("time_ns", "i64"), field("mode", "u8", names=MODES),
         field("robot_fresh", "u8"), field("linked", "u8"), field("arms", "struct", (2,), POSE)]
ROBOT = [field("cycle", "u64"), field("frame", "u64"), field("active_fault", "u32"), field("runlevel", "u8"),
         field("is_virtual", "u8"), field("arms", "struct", (2,), POSE)]
HAPTIC = [field("tick", "i64"), field("force_B", "f64", (2, 3))]
PLAN = [field("status", "u8", names=["none", "success"]), field("arm", "u8", names=["gold", "green"]),
        field("waypoint_count", "u32"), field("arrival", "f64", (4,)), field("cost", "f64"),
        field("planning_time", "f64"), field("samples", "u32")]
ERROR = [field("mean", "f64"), field("largest", "f64")]
EXECUTION = [field("arm", "u8", names=["gold", "green"]), field("on_robot", "u8"),
             field("end", "u8", names=["none", "finished", "released", "no_pedal"]), field("started", "i64"),
             field("ended", "i64"), field("progress", "f64"), field("planned_clearance", "f64"),
             field("model", "struct", (), ERROR), field("robot", "struct", (), ERROR), field("model_clearance", "f64"),
             field("robot_clearance", "f64"), field("contact_ticks", "u32")]
RECORDS = [
    {"type": 1, "name": "tick", "version": 1, "fields": [field("model", "struct", (), MODEL),
                                                         field("robot", "struct", (), ROBOT)]},
    {"type": 2, "name": "haptic", "version": 1, "fields": [field("haptic", "struct", (), HAPTIC)]},
    {"type": 3, "name": "command", "version": 1, "fields": [field("tick", "i64")]},
    {"type": 4, "name": "request", "version": 1, "fields": [field("tick", "i64"), field("kind", "u8")]},
    {"type": 5, "name": "plan", "version": 1, "fields": [field("tick", "i64"), field("result", "struct", (), PLAN)]},
    {"type": 6, "name": "counts", "version": 1, "fields": [field("frames", "u64")]},
    {"type": 7, "name": "execution", "version": 1, "fields": [field("tick", "i64"),
                                                              field("report", "struct", (), EXECUTION)]},
]
HEADER = {"format": "raven2_trainer session log", "format_version": 1, "byte_order": "little", "seed": 42,
          "scenarios": ["sudden_jump"], "hazard": "sudden_jump", "robot_urdf_hash": "aa", "scene_urdf_hash": "bb",
          "config_hash": "cc", "motion": "<scripted>", "d4": -0.47, "tolerance": 0.003, "arm_contacts": False,
          "records": RECORDS}


def record(kind, payload, number=0, version=1):
    framed = struct.pack("<4sHHIQ", b"RV2L", kind, version, len(payload), number) + payload
    return framed + struct.pack("<I", zlib.crc32(framed))


def header_record(**changes):
    return record(0, json.dumps({**HEADER, **changes}).encode())


def numbers_of(fields):
    """(bytes, whether floating-point) of each number of a record, in order."""
    for entry in fields:
        count = int(np.prod(entry["shape"], dtype=int))
        if entry["type"] == "struct":
            yield from list(numbers_of(entry["fields"])) * count
        else:
            yield from [(int(entry["type"][1:]) // 8, entry["type"][0] == "f")] * count


def column_planes(values, width, is_float, order):
    """A column as doc/session.md says, in plain integers: differences, folded, lowest bytes first."""
    top = 1 << (8 * width)
    if is_float:
        values = [v ^ (top // 2 - 1) if v >= top // 2 else v for v in values]
    for _ in range(order):
        values = [values[0]] + [(b - a) % top for a, b in zip(values, values[1:])]
    if order:
        values = [2 * v if v < top // 2 else 2 * (top - v) - 1 for v in values]
    return [bytes(v >> (8 * k) & 0xFF for v in values) for k in range(width)]


def group_data(rows, numbers, orders):
    """All numbers of a group: form by form; of one form the highest order first, and all lowest bytes before the next ones."""
    data = b""
    offsets = [sum(width for width, _ in numbers[:k]) for k in range(len(numbers))]
    for form in ((8, True), (8, False), (4, False), (2, False), (1, False)):
        columns = sorted((k for k, own in enumerate(numbers) if own == form), key=lambda k: -orders[k])
        coded = [column_planes([int.from_bytes(row[offsets[k] : offsets[k] + form[0]], "little") for row in rows], *form, orders[k])
                 for k in columns]
        data += b"".join(planes[byte] for byte in range(form[0]) for planes in coded)
    return data


def compressed(contents):
    library = ctypes.CDLL("libzstd.so.1")
    room = ctypes.create_string_buffer(len(contents) + 1000 + len(contents) // 100)
    size = library.ZSTD_compress(room, ctypes.c_size_t(len(room)), contents, ctypes.c_size_t(len(contents)), 3)
    return room.raw[:size]


def span(first, last):
    return struct.pack("<qq", first, last)


def chunk(records, seed=0, number=0):
    """A chunk of (type, payload), with orders of differences drawn by lot."""
    source = random.Random(seed)
    kinds = sorted({kind for kind, _ in records})
    contents = struct.pack("<II", len(records), len(kinds))
    body = bytes(kinds.index(kind) for kind, _ in records)
    for kind in kinds:
        rows = [payload for k, payload in records if k == kind]
        numbers = list(numbers_of(next(entry["fields"] for entry in RECORDS if entry["type"] == kind)))
        orders = [source.randrange(5) for _ in numbers]
        contents += struct.pack("<HHII", kind, 1, len(rows), len(numbers))
        body += bytes(width | 0x80 * is_float for width, is_float in numbers) + bytes(orders) + group_data(rows, numbers, orders)
    stamps = [struct.unpack_from("<q", payload)[0] for _, payload in records]
    return record(14, span(min(stamps), max(stamps)) + compressed(contents + body), number)


def request(tick):
    return record(4, struct.pack("<qB", tick, 3))


def tick_payload(tick, session_tick, error=0.0, fault=0, mode=2):
    tip = struct.pack("<7d3d", *[0.1 * j for j in range(7)], 0.1, 0.2, 0.3)
    moved = struct.pack("<7d3d", *[0.1 * j for j in range(7)], 0.1, 0.2 + error, 0.3)
    model = struct.pack("<qqqBBB", tick, session_tick, tick * 1000000, mode, 1, 1) + tip + tip
    robot = struct.pack("<QQIBB", 100 + tick, 1, fault, 3, 1) + moved + tip
    return model + robot


def execution(started, ended, end, progress=1.0, on_robot=1, arm=0):
    report = struct.pack("<BBBqqdd", arm, on_robot, end, started, ended, progress, 0.0047)
    return record(7, struct.pack("<q", ended) + report + struct.pack("<6dI", 0.00041, 0.00123, 0.00082, 0.00456, 0.0061, 0.0058, 17))


@functools.lru_cache(maxsize=None)
def session_bytes():
    """A session of two seconds with a fault from 1.0 s to 1.299 s, an error of 10 mm and a force of 2 N."""
    data = header_record()
    for t in range(-10, 2000):
        fault = 1000 <= t < 1300
        data += record(1, tick_payload(t + 10, t if t >= 0 else -1, 0.010 if fault else 0.001, int(fault)))
        data += record(2, struct.pack("<q6d", t + 10, 2.0 if fault else 0.0, 0, 0, 0, 0, 0))
    data += record(5, struct.pack("<qBBI4dddI", 500, 1, 1, 3, 0.0, 0.5, 1.25, 0.0, 3.75, 0.2, 1000))
    return data + record(6, struct.pack("<Q", 60))


class LogCase(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.path = os.path.join(self.folder.name, "session.rlog")

    def tearDown(self):
        self.folder.cleanup()

    def read(self, data):
        with open(self.path, "wb") as file:
            file.write(data)
        return raven2_session.SessionLog(self.path)


class ReaderTest(LogCase):
    def test_gives_the_values_written(self):
        log = self.read(header_record() + record(1, tick_payload(12, 5, 0.25, 1)) + record(6, struct.pack("<Q", 7)))
        self.assertEqual(log.ticks["model"]["tick"].tolist(), [12])
        self.assertEqual(log.ticks["model"]["session_tick"].tolist(), [5])
        self.assertEqual(log.ticks["model"]["arms"]["q"].shape, (1, 2, 7))
        self.assertEqual(log.ticks["robot"]["arms"]["p_BT"][0, 0].tolist(), [0.1, 0.45, 0.3])
        self.assertEqual(log.ticks["robot"]["active_fault"].tolist(), [1])
        self.assertEqual(log.counts["frames"].tolist(), [7])
        self.assertTrue(log.clean)
        self.assertEqual(log.header["seed"], 42)

    def test_reads_logs_with_and_without_exercises(self):
        old = self.read(header_record())
        self.assertIsNone(old.exercise_events)
        self.assertEqual(old.training, {"exercise": "none", "drill": "none", "trainee": "", "curriculum": "none"})
        event = [field("kind", "u8", names=["started", "dropped"]), field("a", "u16"), field("value", "f64")]
        kind = {"type": 13, "name": "exercise", "version": 8,
                "fields": [field("tick", "i64"), field("event", "struct", (), event)]}
        new = self.read(header_record(records=RECORDS + [kind], exercise="peg_transfer", drill="sudden_jump", trainee="t1",
                                      curriculum="basics") +
                        record(13, struct.pack("<qBHd", 77, 1, 5, 0.25), version=8) + request(1))
        self.assertEqual(new.exercise_events["tick"].tolist(), [77])
        self.assertEqual(new.exercise_events["event"]["a"].tolist(), [5])
        self.assertEqual(new.names("exercise", "event.kind"), ["started", "dropped"])
        self.assertEqual(new.training["exercise"], "peg_transfer")
        self.assertEqual(new.training["trainee"], "t1")
        self.assertEqual(len(new.requests), 1)

    def test_names_the_values_of_an_enum(self):
        log = self.read(header_record())
        self.assertEqual(log.names("tick", "model.mode"), MODES)

    def test_stops_cleanly_wherever_the_log_is_cut(self):
        head, body = header_record(), request(0) + request(1) + request(2)
        size = len(request(0))
        for cut in range(len(body) + 1):
            log = self.read(head + body[:cut])
            self.assertEqual(log.requests["tick"].tolist(), list(range(cut // size)))
            self.assertEqual(log.truncated_bytes, cut % size)
            self.assertEqual(log.bad_bytes, 0)
            self.assertFalse(log.clean)

    def test_loses_only_the_record_with_the_flipped_bit(self):
        head, body = header_record(), b"".join(request(i) for i in range(20))
        size = len(request(0))
        source = random.Random(2017)
        for _ in range(1000):
            at = source.randrange(len(body))
            damaged = bytearray(body)
            damaged[at] ^= 1 << source.randrange(8)
            log = self.read(head + bytes(damaged))
            self.assertEqual(log.requests["tick"].tolist(), [i for i in range(20) if i != at // size])
            self.assertEqual(log.bad_bytes + log.truncated_bytes, size)

    def test_never_fails_on_noise(self):
        source = random.Random(5)
        for _ in range(200):
            noise = b"".join(source.choice((b"RV2L", source.randbytes(3))) for _ in range(100))
            log = self.read(header_record() + noise + request(1))
            self.assertEqual(log.requests["tick"].tolist(), [1])
            self.assertEqual(log.bad_bytes, len(noise))

    def test_gives_the_records_of_chunks_in_place(self):
        source = random.Random(8)
        records = []
        for t in range(400):
            tips = struct.pack("<20d", *(source.choice((0.0, -0.0, 1e300, float("nan"), float("-inf"), source.gauss(0, 1))) for _ in range(20)))
            model = struct.pack("<qqqBBB", t - 50, -1, t * 1000003, source.randrange(7), 1, 1) + tips
            records.append((1, model + struct.pack("<QQIBB", 2**64 - 1 - t, 1, source.randrange(2**32), 3, 1) + tips))
            if source.random() < 0.7:
                records.append((2, struct.pack("<q6d", t, *(t * t * 1e-3 for _ in range(6)))))
        plain = self.read(header_record() + b"".join(record(kind, payload) for kind, payload in records) + request(5))
        for seed in range(3):
            log = self.read(header_record() + chunk(records[:300], seed) + record(*records[300]) + chunk(records[301:], seed) + request(5))
            for name in ("ticks", "haptic", "requests"):
                self.assertEqual(getattr(log, name).tobytes(), getattr(plain, name).tobytes())
            self.assertEqual((log.bad_bytes, log.truncated_bytes), (0, 0))

    def test_damage_costs_one_chunk(self):
        chunks = [chunk([(4, struct.pack("<qB", 100 * i + k, 3)) for k in range(100)]) for i in range(3)]
        ticks = [list(range(100 * i, 100 * i + 100)) for i in range(3)]
        body = b"".join(chunks)
        source = random.Random(2017)
        for _ in range(300):
            at = source.randrange(len(body))
            damaged = bytearray(body)
            damaged[at] ^= 1 << source.randrange(8)
            log = self.read(header_record() + bytes(damaged) + request(999))
            hit = next(i for i in range(3) if at < sum(map(len, chunks[: i + 1])))
            self.assertEqual(log.requests["tick"].tolist(), sum((ticks[i] for i in range(3) if i != hit), []) + [999])
            self.assertEqual(log.bad_bytes, len(chunks[hit]))
        for cut in range(0, len(body), 7):
            log = self.read(header_record() + body[:cut])
            self.assertEqual(len(log.requests) % 100, 0)
            self.assertEqual(log.bad_bytes, 0)

    def test_a_part_of_a_session_is_read_alone(self):
        records = [(4, struct.pack("<qB", t, 3)) for t in range(300)]
        head = header_record() + b"".join(record(*r) for r in records[:50])
        data = head + chunk(records[50:150]) + chunk(records[150:250]) + b"".join(record(*r) for r in records[250:]) + record(6, struct.pack("<Q", 7))
        self.read(data)
        for first, last in ((0, 299), (10, 60), (150, 150), (149, 251), (260, 1000), (-5, -1)):
            log = raven2_session.SessionLog(self.path, ticks=(first, last))
            self.assertEqual(log.requests["tick"].tolist(), [t for t in range(300) if first <= t <= last])
            self.assertTrue(log.clean)
            self.assertEqual(log.bad_bytes, 0)
        unreadable = record(14, span(50, 149) + compressed(b"")[:4] + b"not compressed")
        self.read(head + unreadable + chunk(records[150:250]))
        log = raven2_session.SessionLog(self.path, ticks=(200, 249))
        self.assertEqual((len(log.requests), log.bad_bytes), (50, 0))  # passed over, not looked at

    def test_a_chunk_that_no_writer_makes_is_refused_as_a_whole(self):
        good = struct.pack("<IIHHII", 2, 1, 4, 1, 2, 2) + bytes([0, 0, 8, 1, 0, 0]) + bytes(18)
        self.assertEqual(len(self.read(header_record() + record(14, span(0, 1) + compressed(good))).requests), 2)
        wrong = {"too many records": struct.pack("<I", 2**31) + good[4:], "too many groups": good[:4] + struct.pack("<I", 2**31) + good[8:],
                 "rows without bytes": good[:12] + struct.pack("<I", 2**31) + good[16:], "cut": good[:-1], "longer": good + b"0", "empty": b"",
                 "more numbers": good[:16] + struct.pack("<I", 2**31) + good[20:], "3 bytes": good[:22] + b"\3" + good[23:],
                 "order 5": good[:24] + b"\5" + good[25:], "no such group": good[:20] + b"\1" + good[21:],
                 "a chunk": good[:8] + struct.pack("<H", 14) + good[10:]}
        for what, contents in wrong.items():
            with self.subTest(what):
                framed = record(14, span(0, 1) + compressed(contents))
                log = self.read(header_record() + framed + request(7))
                self.assertEqual(log.requests["tick"].tolist(), [7])
                self.assertEqual(log.bad_bytes, len(framed))
        log = self.read(header_record() + record(14, b"not compressed") + request(7) + record(14, b"later", version=3) + request(8))
        self.assertEqual(log.requests["tick"].tolist(), [7, 8])
        self.assertEqual(log.bad_bytes, len(record(14, b"not compressed")))

    def test_a_chunk_whose_formulas_do_not_fit_is_refused_as_a_whole(self):
        def chunk_of(formulas, orders=(0, 0)):
            groups = struct.pack("<IIHHII", 2, 1, 4, 1, 2, 2) + bytes([0, 0, 8, 1, *orders]) + formulas + bytes(18)
            return record(14, span(0, 1) + compressed(groups), version=2)

        positions = struct.pack("<B2H14d", 2, 0, 1, *[0.0] * 14)
        self.assertEqual(len(self.read(header_record() + chunk_of(b"\0")).requests), 2)
        for what, framed in {"columns that are no doubles": chunk_of(b"\1" + positions), "cut": chunk_of(b"\2" + positions),
                             "kind 0": chunk_of(b"\1\0"), "kind 6": chunk_of(b"\1\6"),
                             "without its formula": chunk_of(b"\0", (0x80, 0)), "no number of formulas": chunk_of(b"")}.items():
            with self.subTest(what):
                log = self.read(header_record() + framed + request(7))
                self.assertEqual(log.requests["tick"].tolist(), [7])
                self.assertEqual(log.bad_bytes, len(framed))

    def test_no_more_than_a_second_of_records_has_formulas(self):
        robot = struct.pack("<B7H182d", 1, 0, 1, 8, 15, 15, 15, 15, *[0.0] * 182)
        positions = struct.pack("<B2H14d", 2, 1, 15, *[0.0] * 14)
        for rows, formulas, is_good in ((1000, [robot], True), (1001, [robot], False), (3, [robot, robot], False),
                                        (3, 16 * [positions], True), (3, 17 * [positions], False)):
            forms, orders = [8] + 21 * [0x88], 15 * [0] + 7 * [0x80]
            groups = struct.pack("<IIHHII", rows, 1, 9, 1, rows, 22) + bytes(rows) + bytes(forms) + bytes(orders)
            contents = groups + bytes([len(formulas)]) + b"".join(formulas) + bytes(rows * 176)
            with self.subTest(f"{rows} records, {len(formulas)} formulas"):
                if is_good:
                    group = raven2_session._Chunk(span(0, 1) + compressed(contents), 2).groups[0]
                    self.assertEqual(len(group.formulas), len(formulas))
                else:
                    with self.assertRaises(ValueError):
                        raven2_session._Chunk(span(0, 1) + compressed(contents), 2)

    def test_what_looks_like_the_head_of_a_chunk_costs_no_checksum(self):
        fake = raven2_session.FRAME.pack(raven2_session.MAGIC, 14, 2, 2**20, 7) + bytes(2**20 + 4)
        with unittest.mock.patch.object(raven2_session.zlib, "crc32") as crc32:
            self.assertEqual(raven2_session._look(fake, 0, len(fake))[0], "bad")
        crc32.assert_not_called()

    def test_two_groups_of_one_kind_are_both_read(self):
        heads = struct.pack("<II", 2, 2) + 2 * struct.pack("<HHII", 4, 1, 1, 2) + bytes([0, 1])
        groups = b"".join(bytes([8, 1, 0, 0]) + struct.pack("<qB", tick, 3) for tick in (5, 9))
        log = self.read(header_record() + record(14, span(5, 9) + compressed(heads + groups)))
        self.assertEqual(log.requests["tick"].tolist(), [5, 9])
        self.assertEqual(log.bad_bytes, 0)

    def test_passes_over_kinds_and_versions_it_does_not_know(self):
        log = self.read(header_record() + record(99, b"new") + record(4, b"longer than before", version=2) + request(8))
        self.assertEqual(log.requests["tick"].tolist(), [8])
        self.assertEqual(log.bad_bytes, 0)

    def test_refuses_what_is_no_log(self):
        damaged = bytearray(header_record())
        damaged[100] ^= 1
        for data in (b"", b"RV2L", b"x" * 1000, bytes(damaged), header_record(format_version=4), record(0, b"no JSON")):
            with self.assertRaises(raven2_session.SessionError):
                self.read(data)
        with self.assertRaises(raven2_session.SessionError):
            raven2_session.SessionLog(os.path.join(self.folder.name, "missing"))


class FiguresTest(LogCase):
    def test_finds_faults_errors_and_forces_in_session_time(self):
        import raven2_figures

        self.read(session_bytes())
        series = raven2_figures.Series(raven2_session.Session(self.folder.name))
        self.assertEqual(len(series.t), 2000)
        self.assertEqual(series.fault_windows, [(1.0, 1.299, "sudden_jump")])
        self.assertAlmostEqual(series.error_mm[1100, 0], 10.0, places=9)
        self.assertAlmostEqual(series.error_mm[1100, 1], 0.0, places=9)
        self.assertEqual(series.force_t[0], 0.0)
        self.assertEqual(series.force[:, 0].sum(), 300 * 2.0)

    def test_a_plan_is_followed_while_it_is_tracked_or_executed(self):
        import raven2_figures

        modes = [2, 4, 6, 1]
        self.read(header_record() + b"".join(record(1, tick_payload(t, t, mode=m)) for t, m in enumerate(modes)))
        series = raven2_figures.Series(raven2_session.Session(self.folder.name))
        self.assertEqual(series.tracking.tolist(), [False, True, True, False])

    def test_thinning_keeps_the_peaks(self):
        import raven2_figures

        t = np.arange(100000) / 1000
        values = np.zeros(100000)
        values[77777], values[12345] = 5.0, -3.0
        values[:100] = np.nan
        thin_t, thin = raven2_figures.thinned(t, values)
        self.assertLessEqual(len(thin), raven2_figures.MAX_POINTS)
        self.assertEqual(thin_t[np.nanargmax(thin)], 77.777)
        self.assertEqual(thin_t[np.nanargmin(thin)], 12.345)
        self.assertTrue(np.all(np.diff(thin_t) > 0))

    def test_runs_are_inclusive_index_pairs(self):
        import raven2_figures

        mask = np.array([True, False, True, True, False, True])
        self.assertEqual(raven2_figures.runs(mask), [(0, 0), (2, 3), (5, 5)])
        self.assertEqual(raven2_figures.runs(np.zeros(3, dtype=bool)), [])


class ProgramsTest(LogCase):
    @classmethod
    def setUpClass(cls):
        import raven2_figures  # noqa: F401  (loaded once, for all reports)
        from raven2_report import page  # noqa: F401

    def run_script(self, name, *arguments):
        return forked.run(os.path.join(SCRIPTS, name), *arguments)

    @staticmethod
    def run_plainly(name, *arguments):
        command = ["/usr/bin/python3", os.path.join(SCRIPTS, name), *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    def report(self, data):
        with open(self.path, "wb") as file:
            file.write(data)
        done = self.run_script("session_report", self.folder.name)
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(os.path.join(self.folder.name, "report.html"), encoding="utf-8") as file:
            return file.read()

    def test_report_is_one_file_that_refers_to_nothing_else(self):
        page = self.report(session_bytes())
        self.assertNotRegex(page, r'(?:src|href)="(?!data:|#)')
        self.assertNotRegex(page, r"@import|<script[^>]*\bsrc|<link|url\((?!#)")
        ids = re.findall(r'\bid="([^"]+)"', page)
        drawn = [i for i in ids if re.search(r"(figure|axes|legend)_\d+$", i)]
        self.assertEqual(len(drawn), len(set(drawn)), "figures share ids")

    def test_report_escapes_what_comes_from_outside(self):
        self.assertIn("&lt;scripted&gt;", self.report(session_bytes()))

    def test_report_shows_what_the_log_tells(self):
        page = self.report(session_bytes())
        for text in ("sudden jump", "1.000 s", "300 ms", "3.750", "There is no video", "virtual Raven"):
            self.assertIn(text, page)

    def test_report_lists_planned_motions(self):
        motions = execution(610, 1210, 2, 0.62) + execution(1310, 1510, 1, arm=1, on_robot=0) + execution(-1, 1600, 3)
        page = self.report(session_bytes() + motions)
        section = page[page.index("Planned motions"):page.index("Packets")]
        rows = [re.findall("<td[^>]*>(.*?)</td>", row) for row in re.findall("<tr>(.*?)</tr>", section)[1:]]
        self.assertEqual(rows, [
            ["0.600 s", "gold, model and robot", "released at 62 %", "0.60 s", "0.41", "1.23", "0.82", "4.56", "4.7 mm",
             "6.1 mm", "5.8 mm", "17 ms"],
            ["1.300 s", "green, model alone", "finished", "0.20 s", "0.41", "1.23", "–", "–", "4.7 mm", "6.1 mm", "–",
             "17 ms"],
            ["–", "gold, model and robot", "no pedal, never begun"] + ["–"] * 9])

    def test_report_without_planned_motions_does_not_speak_of_them(self):
        self.assertNotIn("Planned motions", self.report(session_bytes()))
        older = {"records": [entry for entry in RECORDS if entry["name"] != "execution"]}
        self.assertNotIn("Planned motions", self.report(header_record(**older) + session_bytes()[len(header_record()):]))

    def test_report_of_a_session_that_was_cut_off_says_so(self):
        page = self.report(session_bytes()[:-100])
        self.assertIn("did not end properly", page)
        self.assertIn("Fault", page)

    def test_report_of_a_session_without_a_tick_is_written(self):
        self.assertIn("never pressed", self.report(header_record()))

    def test_report_shows_the_metrics(self):
        metrics = {"duration_s": 2.0, "ticks": 2000, "lockstep": True,
                   "on_time_ratio": {"physics": None, "haptic": None},
                   "model_robot_error_mm": {"mean": 1.234, "std": 0.567, "max": 2.5},
                   "faults": [{"name": "sudden_jump", "first_tick": 1000, "last_tick": 1299, "max_error_mm": 10.0,
                               "error_to_force_ms": 7, "max_force_N": 2.0, "first_cycle": 1110, "last_cycle": 1409}],
                   "packets": {"master_to_daemon": {"received": 10, "applied": 8, "used": 7,
                                                    "rejected": {"duplicate": 2}},
                               "daemon_to_robot": {"sent": 9, "received": 9, "applied": 8, "rejected": {}},
                               "robot_to_daemon": {"received": 5, "applied": 5, "rejected": {}},
                               "daemon_to_console": {"sent": 4}}}
        with open(os.path.join(self.folder.name, "metrics.json"), "w", encoding="utf-8") as file:
            json.dump(metrics, file)
        page = self.report(session_bytes())
        for text in ("1.23 ± 0.57 mm", "2.43 ± 1.72 mm", "7 ms", "1,110 – 1,409", "duplicate 2", "does not add up"):
            self.assertIn(text, page)

    def test_plot_session_writes_png_and_svg(self):
        with open(self.path, "wb") as file:
            file.write(session_bytes())
        target = os.path.join(self.folder.name, "pictures")
        done = self.run_plainly("plot_session", self.folder.name, "--output", target)
        self.assertEqual(done.returncode, 0, done.stderr)
        for name in ("joints", "joint_1", "haptic_force", "tip_error", "tip_paths"):
            for kind, start in (("png", b"\x89PNG"), ("svg", b"<?xml")):
                with open(os.path.join(target, f"{name}.{kind}"), "rb") as file:
                    self.assertTrue(file.read().startswith(start))

    def test_programs_say_in_one_line_that_a_folder_is_no_session(self):
        for name in ("session_report", "plot_session"):
            done = self.run_plainly(name, self.folder.name)
            self.assertEqual(done.returncode, 1)
            self.assertEqual(done.stderr.count("\n"), 1)
            self.assertIn("no session", done.stderr)


if __name__ == "__main__":
    unittest.main()
