"""libraven2_usb_faults.so, preloaded into a control program that knows nothing of it. The tests compare the bytes that
the program reads and receives, and the bytes that the boards get, with the bytes that were sent. The boards are pseudo
terminals, the program is test/preload/usb_control_loop.cpp. Needs the built library and program, in
$RAVEN2_TRAINER_BUILD or build/."""

import contextlib
import json
import os
import pathlib
import pty
import random
import signal
import socket
import struct
import subprocess
import threading
import tty

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build"))
LIBRARY = BUILD / "devel/lib/libraven2_usb_faults.so"
PROGRAM = BUILD / "test_bin/usb_control_loop"
FAULTS = ROOT / "config/faults"

BATCH = 50  # cycles at once: a terminal holds 4096 bytes, and 50 packets are 1350
PHRASE = "nobody_is_within_reach"
JOINT_CHANNELS = (0, 1, 2, 4, 5, 6, 7)
# First cycle in which the boards report pedal down. The program's write repeats it; it counts from the next cycle on.
ENGAGED = 20
TICK_0 = ENGAGED + 1


def packet_in(cycle, board, level=None):
    """27 bytes as a board sends them. The counts differ for every cycle and board."""
    rng = random.Random(cycle * 2 + board)
    counts = [rng.randrange(-(1 << 23), 1 << 23) for _ in range(8)]
    level = (3 if cycle >= ENGAGED else 2) if level is None else level
    body = b"".join(struct.pack("<i", count)[:3] for count in counts)
    return bytes([0x03, 8, level << 6 | rng.randrange(64)]) + body


def packet_itp(number):
    """124 bytes, raven2.md 1.1: <3I6i8d6i."""
    rng = random.Random(number)
    values = [number, rng.randrange(1 << 32), rng.randrange(1 << 32)]
    values += [rng.randrange(-2000, 2000) for _ in range(6)] + [rng.uniform(-1, 1) for _ in range(8)]
    values += [rng.randrange(-100, 100) for _ in range(4)] + [1, rng.randrange(1 << 31)]
    return struct.pack("<3I6i8d6i", *values)


class Cycle:
    """Results and data of the program's reads, receive and writes in one cycle."""

    def __init__(self, line):
        words = line.split()
        self.results = [int(word) for word in words[::2]]  # read gold, read green, received, wrote gold, wrote green
        data = [b"" if word == "-" else bytes.fromhex(word) for word in words[1::2]]
        self.read, self.received, self.wrote = data[0:2], data[2], data[3:5]


class Bench:
    """The program with its two boards and its master. `environment` has the settings of the library."""

    def __init__(self, folder, environment=None, preload=True):
        self.masters, self.slaves = zip(*[pty.openpty() for _ in range(2)])
        for master, slave in zip(self.masters, self.slaves):
            tty.setraw(slave)
            os.set_blocking(master, False)
        self.paths = [str(folder / name) for name in ("brl_usb49", "brl_usb22")]
        for path, slave in zip(self.paths, self.slaves):
            if os.path.lexists(path):
                os.unlink(path)
            os.symlink(os.ttyname(slave), path)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.master = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        known = {"RAVEN2_USB_FAULTS_GOLD": self.paths[0], "RAVEN2_USB_FAULTS_GREEN": self.paths[1],
                 "RAVEN2_USB_FAULTS_PORT": str(self.port)}
        clean = {key: value for key, value in os.environ.items() if not key.startswith("RAVEN2_USB_FAULTS")}
        both = {**clean, **known, **(environment or {})}
        if preload:
            both["LD_PRELOAD"] = str(LIBRARY)
        self.log = folder / "stderr"
        with open(self.log, "w", encoding="utf-8") as log:
            self.program = subprocess.Popen([PROGRAM, *self.paths, str(self.port)], env=both, stdin=subprocess.PIPE,
                                            stdout=subprocess.PIPE, stderr=log, text=True)
        assert self.program.stdout.readline() == "ready\n", self.stderr()
        self.start_up = [self.from_board(board) for board in range(2)]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.program.poll() is None:
            self.program.kill()
            self.program.wait()
        self.program.stdin.close()
        self.program.stdout.close()
        self.master.close()
        for descriptor in self.masters + self.slaves:
            os.close(descriptor)

    def stderr(self):
        return self.log.read_text(encoding="utf-8")

    def from_board(self, board):
        """All that has arrived at a board."""
        arrived = b""
        while True:
            try:
                arrived += os.read(self.masters[board], 4096)
            except BlockingIOError:
                return arrived

    def send(self, itp):
        self.master.sendto(itp, ("127.0.0.1", self.port))

    def tell(self, text):
        self.program.stdin.write(text + "\n")
        self.program.stdin.flush()

    def cycles(self, boards, itps=()):
        """Runs a cycle for each pair of packets. Returns the program's Cycles and the bytes that each board got."""
        for gold, green in boards:
            os.write(self.masters[0], gold)
            os.write(self.masters[1], green)
        for itp in itps:
            self.send(itp)
        self.tell(f"cycle {len(boards)}")
        seen = [Cycle(self.program.stdout.readline()) for _ in boards]
        return seen, [self.from_board(board) for board in range(2)]

    def leave(self):
        self.tell("quit")
        assert self.program.stdout.readline() == "0 allocations or locks\n"
        assert self.program.wait(timeout=60) == 0


@pytest.fixture(autouse=True)
def fixture_patience():
    """A program that waits forever fails the test."""
    def give_up(*_):
        raise TimeoutError("the program under test waits")

    before = signal.signal(signal.SIGALRM, give_up)
    signal.alarm(300)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


def test_before_the_first_cycle_packets_pass(tmp_path, keys):
    row = f"site: network_layer, variable: packet, kind: drop, value: 1.0, {ALWAYS}"
    with Bench(tmp_path, own(tmp_path, keys, row)) as bench:
        bench.send(packet_itp(1))
        bench.tell("wait")
        assert bytes.fromhex(bench.program.stdout.readline().split()[1]) == packet_itp(1)


@pytest.fixture(name="keys")
def fixture_keys(tmp_path):
    """Both keys, in the environment and in a file."""
    file = tmp_path / "injection.yaml"
    file.write_text("enable: true\nreal_robot: true\n", encoding="utf-8")
    return {"RAVEN2_USB_FAULTS_I_KNOW": PHRASE, "RAVEN2_USB_FAULTS_INJECTION": str(file)}


def run(bench, count, with_itp=False):
    """[(cycle, bytes sent by the boards, Cycle of the program, bytes received by the boards)], 50 cycles at once."""
    for first in range(0, count, BATCH):
        numbers = range(first, min(first + BATCH, count))
        boards = [(packet_in(n, 0), packet_in(n, 1)) for n in numbers]
        seen, got = bench.cycles(boards, [packet_itp(n + 1) for n in numbers] if with_itp else [])
        for i, number in enumerate(numbers):
            yield number, boards[i], seen[i], [each[19 * i:19 * i + 19] for each in got]


def assert_untouched(folder, environment, preload=True):
    """Runs some cycles in which every byte must arrive. Returns the program's stderr."""
    with Bench(folder, environment, preload) as bench:
        assert bench.start_up == [bytes([6, 8]) + bytes(17)] * 2
        for number, boards, seen, got in run(bench, 150, with_itp=True):
            assert seen.results == [27, 27, 124, 19, 19]
            assert tuple(seen.read) == boards
            assert seen.received == packet_itp(number + 1)
            assert got == seen.wrote
        bench.leave()
        return bench.stderr()


def said_off(text):
    lines = text.splitlines()
    assert len(lines) == 1, text
    assert lines[0].startswith("raven2_usb_faults: OFF, everything passes through untouched: ")
    return lines[0]


def test_the_bench_itself_changes_nothing(tmp_path):
    assert assert_untouched(tmp_path, {}, preload=False) == ""


SUDDEN = {"RAVEN2_USB_FAULTS": str(FAULTS / "sudden_jump.yaml")}


def test_without_a_scenario_all_passes(tmp_path, keys):
    assert "names no scenario" in said_off(assert_untouched(tmp_path, keys))
    assert "names no scenario" in said_off(assert_untouched(tmp_path, {}))


@pytest.mark.parametrize("missing", ["RAVEN2_USB_FAULTS_I_KNOW", "RAVEN2_USB_FAULTS_INJECTION"])
def test_one_key_alone_opens_nothing(tmp_path, keys, missing):
    del keys[missing]
    assert "key is missing" in said_off(assert_untouched(tmp_path, {**keys, **SUDDEN}))


def test_the_packaged_key_opens_nothing(tmp_path, keys):
    keys["RAVEN2_USB_FAULTS_INJECTION"] = str(ROOT / "config/injection.yaml")
    assert "real_robot" in said_off(assert_untouched(tmp_path, {**keys, **SUDDEN}))


def test_a_wrong_or_missing_scenario_is_named_with_its_line_and_all_passes(tmp_path, keys):
    wrong = tmp_path / "sudden_jump.yaml"
    text = (FAULTS / "sudden_jump.yaml").read_text(encoding="utf-8")
    line = 1 + text.splitlines().index(next(row for row in text.splitlines() if "value:" in row))
    wrong.write_text(text.replace("value: 800", "value: many"), encoding="utf-8")
    said = said_off(assert_untouched(tmp_path, {**keys, "RAVEN2_USB_FAULTS": str(wrong)}))
    assert f"{wrong}:{line}: " in said
    said = said_off(assert_untouched(tmp_path, {**keys, "RAVEN2_USB_FAULTS": "/nowhere/at_all.yaml"}))
    assert "/nowhere/at_all.yaml" in said
    inside = FAULTS / "dac_minus1000.yaml"
    said = said_off(assert_untouched(tmp_path, {**keys, "RAVEN2_USB_FAULTS": str(inside)}))
    assert f"{inside}:" in said and "inside of the program" in said


def with_dac(wrote, channel, dac):
    out = bytearray(wrote)
    out[2 + 2 * channel:4 + 2 * channel] = struct.pack("<H", dac + 0x8000)
    return bytes(out)


def test_third_row_of_table_1_the_boards_get_a_constant_for_300_cycles_every_8000(tmp_path, keys):
    truth = tmp_path / "truth.json"
    environment = {**keys, **SUDDEN, "RAVEN2_USB_FAULTS_TRUTH": str(truth)}
    acted = []
    with Bench(tmp_path, environment) as bench:
        assert "ON: scenario sudden_jump" in bench.stderr()
        for number, boards, seen, got in run(bench, TICK_0 + 16400):
            acts = number >= TICK_0 + 8000 and (number - TICK_0) % 8000 < 300
            assert tuple(seen.read) == boards
            assert seen.results[3:] == [19, 19], "the program does not notice"
            assert got[0] == (with_dac(seen.wrote[0], 0, 800) if acts else seen.wrote[0]), number
            assert got[1] == seen.wrote[1], number
            acted += [number] if got[0] != seen.wrote[0] else []
        bench.leave()
    assert len(acted) > 590, "except a few cycles in which the program itself wrote 800"
    told = json.loads(truth.read_text(encoding="utf-8"))
    assert told["cycles"] == TICK_0 + 16400
    moments = [(entry["inject"]["cycle"], entry["clear"]["cycle"]) for entry in told["injections"]]
    first = TICK_0 + 8000 + 1  # counted from 1
    assert moments == [(first, first + 300), (first + 8000, first + 8300)]
    assert {entry["variable"] for entry in told["injections"]} == {"dac"}
    times = [entry["inject"]["time_ns"] for entry in told["injections"]]
    assert times == sorted(times) and told["changes_lost"] == 0


def test_second_row_of_table_1_the_program_reads_no_counts_of_gold_any_more(tmp_path, keys):
    environment = {**keys, "RAVEN2_USB_FAULTS": str(FAULTS / "unavailable_permanent.yaml")}
    with Bench(tmp_path, environment) as bench:
        for number, boards, seen, got in run(bench, TICK_0 + 8200):
            expected = bytearray(boards[0])
            for channel in JOINT_CHANNELS if number >= TICK_0 + 8000 else ():
                expected[3 + 3 * channel:6 + 3 * channel] = bytes(3)
            assert seen.results[:2] == [27, 27]
            assert seen.read == [bytes(expected), boards[1]], number
            assert got == seen.wrote, number


def test_first_row_of_table_1_the_program_hears_no_packet_for_12_s(tmp_path, keys):
    environment = {**keys, "RAVEN2_USB_FAULTS": str(FAULTS / "unavailable_recoverable.yaml")}
    eagain = -11
    with Bench(tmp_path, environment) as bench:
        for number, boards, seen, got in run(bench, TICK_0 + 20100, with_itp=True):
            lost = TICK_0 + 8000 <= number < TICK_0 + 20000
            assert seen.results[2] == (eagain if lost else 124), number
            assert seen.received == (b"" if lost else packet_itp(number + 1)), number
            assert tuple(seen.read) == boards and got == seen.wrote, number


SCENARIO = """name: own
title: Own
number: 0
source: test
published: ""
hazard: [H-3]
maude: []
maude_link: none
basis: design
expected: Something.
response: Something.
faults:
"""


def own(folder, keys, *rows):
    """Writes a scenario of these rows. Returns the environment that selects it."""
    file = folder / "own.yaml"
    file.write_text(SCENARIO + "".join(f"  - {{host: robot, {row}}}\n" for row in rows), encoding="utf-8")
    return {**keys, "RAVEN2_USB_FAULTS": str(file)}


ALWAYS = "start: {trigger: power_on, first_tick: 0}, duration_ticks: 0"


def one(bench, number, itps=()):
    boards = (packet_in(number, 0, 3), packet_in(number, 1, 3))
    seen, got = bench.cycles([boards], itps)
    return boards, seen[0], got


def test_the_first_row_of_table_1_can_corrupt_what_a_packet_says(tmp_path, keys):
    row = f"site: network_layer, variable: increment, kind: add, arm: gold, channel: y, value: 500, {ALWAYS}"
    with Bench(tmp_path, own(tmp_path, keys, row)) as bench:
        for number in range(1, 20):
            _, seen, _ = one(bench, number, [packet_itp(number)])
            sent = packet_itp(number)
            (dely,) = struct.unpack_from("<i", sent, 20)
            assert seen.received == sent[:20] + struct.pack("<i", dely + 500) + sent[24:]


def test_reads_that_fail_are_told_as_the_driver_would(tmp_path, keys):
    row = f"site: get_usb_packet, variable: read_result, kind: stuck_at, arm: gold, value: -16, {ALWAYS}"
    with Bench(tmp_path, own(tmp_path, keys, row)) as bench:
        for number in range(3):
            boards, seen, got = one(bench, number)
            assert seen.results[:2] == [-16, 27] and seen.read[1] == boards[1]
            assert got == seen.wrote


def test_a_board_that_is_not_written_gets_nothing_and_the_program_does_not_know(tmp_path, keys):
    row = f"site: put_usb_packet, variable: board_count, kind: stuck_at, value: 1, {ALWAYS}"
    with Bench(tmp_path, own(tmp_path, keys, row)) as bench:
        for number in range(3):
            _, seen, got = one(bench, number)
            assert seen.results[3:] == [19, 19]
            assert got == [seen.wrote[0], b""]


def green_first(folder, environment):
    """Exchanges the boards: the program opens green's board first, as raven2 does if green has the higher serial."""
    return {**environment, "RAVEN2_USB_FAULTS_GOLD": str(folder / "brl_usb22"),
            "RAVEN2_USB_FAULTS_GREEN": str(folder / "brl_usb49")}


def test_the_one_board_that_is_read_and_written_is_the_one_that_was_opened_first(tmp_path, keys):
    rows = [f"site: {site}, variable: board_count, kind: stuck_at, value: 1, {ALWAYS}"
            for site in ("get_usb_packet", "put_usb_packet")]
    for environment in (own(tmp_path, keys, *rows), green_first(tmp_path, own(tmp_path, keys, *rows))):
        with Bench(tmp_path, environment) as bench:
            for number in range(3):
                _, seen, got = one(bench, number)
                assert seen.results == [27, -19, -11, 19, 19]
                assert got == [seen.wrote[0], b""]


def test_where_green_is_board_0_golds_commands_go_there_by_index_0_and_nothing_changes_by_index_1(tmp_path, keys):
    for index, golds in ((0, 0), (1, 1)):
        row = f"site: put_usb_packet, variable: board_index, kind: stuck_at, arm: gold, value: {index}, {ALWAYS}"
        with Bench(tmp_path, green_first(tmp_path, own(tmp_path, keys, row))) as bench:
            _, seen, got = one(bench, 0)
            expected = [seen.wrote[0], b""]
            expected[golds] += seen.wrote[1]
            assert got == expected


def test_golds_commands_go_to_greens_board(tmp_path, keys):
    row = f"site: put_usb_packet, variable: board_index, kind: stuck_at, arm: gold, value: 1, {ALWAYS}"
    with Bench(tmp_path, own(tmp_path, keys, row)) as bench:
        _, seen, got = one(bench, 0)
        assert got == [b"", seen.wrote[0] + seen.wrote[1]]


def look(bench):
    """The program opens and closes both boards once more, while it keeps using its other descriptors."""
    bench.tell("look")
    assert [bench.program.stdout.readline() for _ in range(2)] == ["there\n"] * 2


def test_a_board_that_was_opened_and_closed_once_more_still_gets_all(tmp_path, keys):
    row = f"site: put_usb_packet, variable: dac, kind: stuck_at, arm: gold, channel: shoulder, value: 5, {ALWAYS}"
    with Bench(tmp_path, own(tmp_path, keys, row)) as bench:
        for number in range(3):
            look(bench)
            _, seen, got = one(bench, number)
            assert got == [with_dac(seen.wrote[0], 0, 5), seen.wrote[1]]


def test_golds_commands_go_to_greens_board_after_it_was_opened_and_closed_once_more(tmp_path, keys):
    row = f"site: put_usb_packet, variable: board_index, kind: stuck_at, arm: gold, value: 1, {ALWAYS}"
    with Bench(tmp_path, own(tmp_path, keys, row)) as bench:
        for number in range(3):
            look(bench)
            _, seen, got = one(bench, number)
            assert got == [b"", seen.wrote[0] + seen.wrote[1]]


def test_who_waits_for_a_packet_waits_for_the_first_that_is_not_lost(tmp_path, keys):
    row = ("site: network_layer, variable: packet, kind: drop, value: 1.0, start: {trigger: packet, first_tick: 2}, "
           "duration_ticks: 3")
    with Bench(tmp_path, own(tmp_path, keys, row)) as bench:
        one(bench, 0)
        for number in range(1, 8):
            bench.send(packet_itp(number))
        for expected in (1, 2, 6, 7):
            bench.tell("wait")
            result, data, port = bench.program.stdout.readline().split()
            assert int(result) == 124 and bytes.fromhex(data) == packet_itp(expected)
            assert int(port) == bench.master.getsockname()[1]


@contextlib.contextmanager
def stream(bench):
    """A packet every 10 ms."""
    is_over = threading.Event()

    def send():
        number = 1
        while not is_over.wait(0.01):
            number += 1
            bench.send(packet_itp(number))

    sender = threading.Thread(target=send)
    sender.start()
    try:
        yield
    finally:
        is_over.set()
        sender.join()


@pytest.mark.parametrize("coming", [stream, contextlib.nullcontext], ids=["a stream", "no other"])
def test_who_waits_while_all_packets_are_lost_is_told_so_and_can_end(tmp_path, keys, coming):
    row = f"site: network_layer, variable: packet, kind: drop, value: 1.0, {ALWAYS}"
    with Bench(tmp_path, own(tmp_path, keys, row)) as bench:
        one(bench, 0)
        bench.send(packet_itp(1))
        with coming(bench):
            bench.tell("wait")
            line = bench.program.stdout.readline()
        assert int(line.split()[0]) == -11
        bench.leave()


def test_other_sizes_than_itp_pass(tmp_path, keys):
    row = f"site: network_layer, variable: packet, kind: drop, value: 1.0, {ALWAYS}"
    with Bench(tmp_path, own(tmp_path, keys, row)) as bench:
        _, seen, _ = one(bench, 0, [packet_itp(1)])
        assert seen.results[2] == -11
        _, seen, _ = one(bench, 1, [packet_itp(2)[:123]])
        assert seen.results[2] == 123 and seen.received[:123] == packet_itp(2)[:123]


def test_what_random_draws_is_the_same_from_the_same_seed(tmp_path, keys):
    row = f"site: put_usb_packet, variable: dac, kind: random, arm: gold, channel: elbow, low: -900, high: 900, {ALWAYS}"

    def drawn(seed):
        environment = {**own(tmp_path, keys, row), "RAVEN2_USB_FAULTS_SEED": seed}
        with Bench(tmp_path, environment) as bench:
            return [one(bench, number)[2][0][4:6] for number in range(20)]

    first = drawn("5")
    assert first == drawn("5") and first != drawn("6")
    values = [struct.unpack("<H", dac)[0] - 0x8000 for dac in first]
    assert all(-900 <= value <= 900 for value in values) and len(set(values)) > 10


def test_a_truth_that_cannot_be_written_is_said_and_the_program_ends_well(tmp_path, keys):
    environment = {**keys, **SUDDEN, "RAVEN2_USB_FAULTS_TRUTH": "/nowhere/truth.json"}
    with Bench(tmp_path, environment) as bench:
        one(bench, 0)
        bench.leave()
        assert "/nowhere/truth.json cannot be written" in bench.stderr()


def test_nothing_but_names_of_the_c_library_is_seen():
    listed = subprocess.run(["nm", "-D", "--defined-only", "-C", LIBRARY], capture_output=True, text=True, check=True)
    names = {line.split()[-1].split("@")[0] for line in listed.stdout.splitlines()}
    wrapped = {"open", "open64", "openat", "openat64", "__open_2", "__open64_2", "__openat_2", "__openat64_2", "close",
               "read", "__read_chk", "write", "recvfrom", "__recvfrom_chk"}
    assert wrapped <= names
    assert {name for name in names - wrapped if "raven2_trainer" in name or "YAML" in name} == set()
