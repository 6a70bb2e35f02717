"""The tests' own reader of state frames reads each field at its offset in doc/wire.md."""
import pathlib
import re
import struct
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "test/support"))
from state_frame import STATE, State  # noqa: E402


def section():
    page = (ROOT / "doc/wire.md").read_text()
    size, text = re.search(r"(?s)### State, payload (\d+) bytes\n(.*?)\n### ", page).groups()
    return int(size), text


def test_size_and_frame_are_those_of_the_page():
    size, _ = section()
    assert STATE.size == size
    assert f"| 28, {20 + size} |" in (ROOT / "doc/wire.md").read_text()


def test_every_field_stands_at_its_offset():
    """The payload has a different number in each field, written at the page's offset."""
    size, text = section()
    head, arm_table = text.split("An arm;")
    payload, told = bytearray(size), {}

    def write(table, base, prefix):
        for offset, code, count, name in re.findall(r"(?m)^\| (\d+) \| ([uif]\d+)(?:\[(\d+)\])? \| (\w+) \|", table):
            letter = {"u64": "Q", "i64": "q", "u32": "I", "i32": "i", "u8": "B", "f64": "d"}[code]
            values = [(len(told) * 7 + i) % 200 + 1 for i in range(int(count or 1))]
            struct.pack_into(f"<{len(values)}{letter}", payload, base + int(offset), *values)
            told[prefix + name] = values if count else values[0]

    write(head, 0, "")
    for arm, offset in enumerate(map(int, re.findall(r"(?m)^\| (\d+) \| arm \|", head))):
        write(arm_table, offset, f"{arm}.")
    state = State(bytes(payload))
    read = {"time" if name == "time_ns" else name: value for name, value in vars(state).items()}
    for name in ("cycle", "time", "last_sequence", "active_fault", "runlevel", "sublevel", "homed", "soft_estopped",
                 "fault_mask", "received", "applied", "rejected"):
        assert read[name] == told[name], name
    for name in ("q", "dq", "motor", "dac"):
        assert read[name] == [told[f"0.{name}"], told[f"1.{name}"]], name


@pytest.mark.parametrize("change", [-1, 1])
def test_a_payload_of_another_size_is_refused(change):
    with pytest.raises(struct.error):
        State(bytes(STATE.size + change))
