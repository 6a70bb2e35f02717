"""The payload of a state frame of the robot's TCP link, read with struct alone (doc/wire.md)."""
import struct

STATE = struct.Struct("<QqII5B" + 2 * "21d7i7B" + "23Q")


class State:
    """One state frame. A payload of another size is refused."""

    def __init__(self, payload):
        values = STATE.unpack(payload)
        self.cycle, self.time_ns, self.last_sequence, self.active_fault = values[:4]
        self.runlevel, self.sublevel, self.homed, self.soft_estopped, self.fault_mask = values[4:9]
        arms = [values[9 + 35 * a:9 + 35 * (a + 1)] for a in (0, 1)]
        self.q = [list(arm[0:7]) for arm in arms]
        self.dq = [list(arm[7:14]) for arm in arms]
        self.motor = [list(arm[14:21]) for arm in arms]
        self.dac = [list(arm[21:28]) for arm in arms]
        self.received, self.applied, *self.rejected = values[79:]
