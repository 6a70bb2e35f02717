#!/usr/bin/env python3
"""The smallest master: pedal up for half a second, then down while both tools draw a circle. The packet: doc/wire.md.

    itp_master.py [HOST] [PORT] [SECONDS]    defaults: 127.0.0.1, the daemon's 36010, 10 s
"""
import math
import socket
import struct
import sys
import time

ITP = struct.Struct("<3I6i8d6i")  # 124 bytes
RADIUS, PERIOD = 5000.0, 5.0  # [um] of the tool, [s]


def itp(sequence, pedal, step):
    """Both arms move by `step` [um]: x forward, y right, z down. Jaws and orientation stay as they are."""
    moves = [value for axis in step for value in (axis, axis)]  # gold, green of x, then of y, of z
    checksum = (pedal + 2 * sum(step) + sequence + 2**31) % 2**32 - 2**31
    return ITP.pack(sequence, 0, 0, *moves, 0, 0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, pedal, checksum)


def circle(t):
    angle = 2 * math.pi * max(t - 0.5, 0.0) / PERIOD
    return round(RADIUS * math.sin(angle)), round(RADIUS * (1 - math.cos(angle))), 0


target = (sys.argv[1] if len(sys.argv) > 1 else "127.0.0.1", int(sys.argv[2]) if len(sys.argv) > 2 else 36010)
sock, start, was = socket.socket(socket.AF_INET, socket.SOCK_DGRAM), time.monotonic(), circle(0)
for n in range(1, int(1000 * float(sys.argv[3] if len(sys.argv) > 3 else 10)) + 1):
    now = circle(n / 1000)  # differences of whole positions: nothing is ever rounded away
    sock.sendto(itp(n, int(n > 500), [a - b for a, b in zip(now, was)]), target)
    was = now
    time.sleep(max(0.0, start + n / 1000 - time.monotonic()))
