"""scripts/raven2_session.py reads the flight recorder. The tests write its file byte by byte, as
src/session/flight_file.h and include/raven2_trainer/core/record_ring.h define it. The reader must return the intact
records and nothing else."""
import fcntl
import json
import pathlib
import struct
import sys

import numpy as np
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
sys.dont_write_bytecode = True
import raven2_session  # noqa: E402
import test_raven2_session as made  # noqa: E402

CAPACITY, SIZE, STRIDE = 4, 16, 32  # of the only queue; the checksum follows the record
TAIL, DROPPED, SLOTS, CHECKPOINTS = 4096, 4104, 4160, (64, 256)
FIELDS = [{"name": "tick", "type": "i64", "shape": [], "offset": 0}, {"name": "kind", "type": "u8", "shape": [],
                                                                      "offset": 8}]
PACKED = np.dtype([("tick", "<i8", ()), ("kind", "u1", ())])
MASK = 2**64 - 1


def checksum(words, index=0):
    value = 0xCBF29CE484222325 ^ index
    for word in words:
        value = (value ^ word) * 0x100000001B3 & MASK
        value ^= value >> 29
    return value


class Memory:
    """A recorder in which the records from `head` to `tail` wait. The tick of each record is 1000 times its number."""

    def __init__(self, log, head=0, tail=0):
        self.log = log
        layout = json.dumps({"checkpoints": CHECKPOINTS, "queues": [
            {"name": "request", "type": 4, "kind": 0, "capacity": CAPACITY, "stride": STRIDE, "size": SIZE,
             "check": SIZE, "tail": TAIL, "dropped": DROPPED, "slots": SLOTS, "fields": FIELDS}]}).encode()
        self.data = bytearray(SLOTS + CAPACITY * STRIDE)
        self.data[448 : 448 + len(layout)] = layout
        status = log.stat()
        struct.pack_into("<8sQQQ", self.data, 0, b"RVFLIGHT", len(layout), status.st_dev, status.st_ino)
        self.checkpoint(0, 1, head)
        for number in range(max(head, tail - CAPACITY), tail):
            words = 1000 * number, 3
            struct.pack_into("<3Q", self.data, SLOTS + number % CAPACITY * STRIDE, *words, checksum(words, number))
        self.put(TAIL, tail)

    def put(self, place, number):
        struct.pack_into("<Q", self.data, place, number)

    def checkpoint(self, place, sequence, head, told=0, log_size=None):
        words = sequence, log_size or 100 * sequence, 7, head, told
        struct.pack_into("<6Q", self.data, CHECKPOINTS[place], *words, checksum(words))

    def read(self):
        (self.log.parent / "flight_recorder").write_bytes(self.data)
        return raven2_session.FlightRecorder.open_for(str(self.log))

    def ticks(self):
        ((name, rows),) = self.read().records({4: PACKED})
        assert name == "request" and (rows["kind"] == 3).all()
        return rows["tick"].tolist()


@pytest.fixture(name="log")
def log_file(tmp_path):
    path = tmp_path / "session.rlog"
    path.write_bytes(b"a log")
    return path


@pytest.mark.parametrize("head, tail", [(0, 0), (0, 3), (0, 4), (2, 3), (6, 10), (9, 9)])
def test_what_waits_is_given_in_its_order(log, head, tail):
    assert Memory(log, head, tail).ticks() == [1000 * number for number in range(head, tail)]


def test_a_record_that_was_being_written_is_left_out(log):
    memory = Memory(log, 5, 8)
    memory.data[SLOTS + 6 % CAPACITY * STRIDE] ^= 1
    assert memory.ticks() == [5000, 7000]


def test_a_record_of_a_round_before_is_none_of_this_one(log):
    memory = Memory(log, 0, 4)
    memory.checkpoint(0, 1, 4)
    memory.put(TAIL, 6)
    assert memory.ticks() == []


@pytest.mark.parametrize("tail", [9, 10, 2, 2**40, MASK])
def test_numbers_that_cannot_be_give_nothing(log, tail):
    memory = Memory(log, 4, 8)
    memory.put(TAIL, tail)
    assert memory.ticks() == []


def test_the_newest_whole_checkpoint_counts(log):
    memory = Memory(log, 0, 3)
    memory.checkpoint(1, 2, 1)
    assert memory.ticks() == [1000, 2000]
    assert memory.read().log_size == 200
    memory.data[CHECKPOINTS[1] + 8] ^= 1
    assert memory.ticks() == [0, 1000, 2000]
    memory.checkpoint(1, 0, 1)  # never written
    assert memory.read().log_size == 100
    memory.data[CHECKPOINTS[0]] ^= 1
    assert memory.read() is None


def test_losses_that_no_gap_tells_of_are_counted(log):
    memory = Memory(log)
    memory.checkpoint(0, 1, 0, told=5)
    memory.put(DROPPED, 12)
    assert memory.read().lost() == 7


def test_one_of_another_log_or_of_a_living_writer_is_left_alone(log):
    memory = Memory(log, 0, 2)
    assert memory.read() is not None
    with open(log, "rb") as writer:
        fcntl.flock(writer, fcntl.LOCK_EX)
        assert memory.read() is None
    assert memory.read() is not None
    struct.pack_into("<Q", memory.data, 24, log.stat().st_ino + 1)
    assert memory.read() is None
    assert Memory(log).read() is not None
    (log.parent / "flight_recorder").unlink()
    assert raven2_session.FlightRecorder.open_for(str(log)) is None


def test_a_finished_log_has_all_whether_or_not_its_writer_could_remove_the_file(log):
    """The counts are the log's last record. They come behind the newest checkpoint."""
    begun = made.header_record() + made.request(1)
    memory = Memory(log, 0, 1)
    memory.checkpoint(0, 1, 0, log_size=len(begun))
    memory.read()
    log.write_bytes(begun + made.request(2) + made.record(6, struct.pack("<Q", 60)))
    finished = raven2_session.SessionLog(str(log))
    assert finished.clean and finished.counts["frames"].tolist() == [60]
    assert finished.requests["tick"].tolist() == [1, 2] and finished.from_flight_recorder == 0
    log.write_bytes(begun + made.request(2))
    killed = raven2_session.SessionLog(str(log))
    assert not killed.clean
    assert killed.requests["tick"].tolist() == [1, 0] and killed.from_flight_recorder == 1


def test_a_part_of_one_is_none(log):
    memory = Memory(log, 0, 2)
    for size in (0, 20, 300, 460):
        memory.data, whole = memory.data[:size], memory.data
        assert memory.read() is None, size
        memory.data = whole
