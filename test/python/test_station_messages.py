"""Tests the messages between trainer, station and pages: their limits, their order, and sockets that stall or close."""

import asyncio
import json
import math
import os
import pathlib
import random
import socket
import sys
import threading
import time
import types

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from raven2_station import clients, frames, hands, ros_link, wire  # noqa: E402


class SlowPage:
    """A socket of a page that reads nothing."""

    def __init__(self):
        self.closed, self.sent, self.aborted, self.stuck, self.gone = False, [], False, False, False

    async def send_str(self, text):
        if self.gone:
            raise ConnectionResetError("Cannot write to closing transport")
        if self.stuck:
            await asyncio.sleep(3600)
        self.sent.append(text)

    async def send_bytes(self, data):
        self.sent.append(data)

    def abort(self):
        self.aborted = True


def test_pictures_of_both_cameras_go_to_their_own_places():
    """The first byte says which: link.js takes it off."""
    async def run():
        page = SlowPage()
        client = clients.Client(page, "trainee", 1)
        client.wants = {"view", "second"}
        writer = asyncio.ensure_future(client.write())
        for which in ("view", "second"):
            client.show(which, which.encode())
        await asyncio.sleep(0.05)
        writer.cancel()
        return page.sent

    assert sorted(asyncio.run(run())) == [b"\x00view", b"\x01second"]


def test_strips_have_the_distance_of_each_arm():
    pytest.importorskip("rospy")
    sys.path.insert(0, str(pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build")) / "devel/lib/python3/dist-packages"))
    pytest.importorskip("raven2_trainer.msg", reason="the messages are not built")
    from raven2_station import ros_side
    sent = []
    daemon = object.__new__(ros_side.Daemon)
    daemon._lock, daemon._last_tick = threading.Lock(), time.monotonic()
    daemon._link = types.SimpleNamespace(send=lambda message, may_drop: sent.append(message))
    daemon._frames = types.SimpleNamespace(apart={"L": 0.003, "R": 0.005}.get)  # the robot's left arm is gold
    daemon._force, daemon._push = {"gold": 1.0, "green": 2.0}, {"gold": [1.0, 0.0, 0.0], "green": [0.0, 2.0, 0.0]}
    daemon.strips()
    assert sent == [{"t": "strips", "apart": {"gold": 0.003, "green": 0.005}, "force": daemon._force, "push": daemon._push}]


def test_no_picture_is_sent_ahead_of_a_page_that_acknowledges(monkeypatch):
    monkeypatch.setattr(clients, "AHEAD_LIMIT", 3600.0)  # until it is the subject

    async def run():
        page = SlowPage()
        client = clients.Client(page, "trainee", 1)
        client.acknowledges = True
        writer = asyncio.ensure_future(client.write())
        for number in range(10):
            client.show("view", bytes([number]))
            await asyncio.sleep(0)
            await asyncio.sleep(0)
        await asyncio.sleep(0.05)
        assert len(page.sent) == clients.MOST_AHEAD
        client.send({"t": "text"})
        await asyncio.sleep(0.05)
        assert page.sent[-1] == '{"t":"text"}', "texts do not wait"
        client.shown()
        await asyncio.sleep(0.05)
        assert page.sent[-1] == b"\x00\x09" and len(page.sent) == clients.MOST_AHEAD + 2, "the newest, not those that waited"
        monkeypatch.setattr(clients, "AHEAD_LIMIT", 0.01)
        await asyncio.sleep(0.02)
        client.show("view", b"x")
        await asyncio.sleep(0.05)
        assert page.sent[-1] == b"\x00x", "a page that forgot to acknowledge goes on"
        writer.cancel()

    asyncio.run(run())


def test_a_page_over_its_rate_learns_why_once_a_second(monkeypatch):
    async def run():
        now = 100.0
        monkeypatch.setattr(clients.time, "monotonic", lambda: now)
        page = SlowPage()
        client = clients.Client(page, "trainee", 1)
        for _ in range(1000):
            client.warn()
        now += clients.WARN_EVERY
        client.warn()
        await client._write_all()
        assert [json.loads(text)["text"] for text in page.sent] == ["too many messages: 200 a second are read"] * 2
        assert json.loads(page.sent[0])["ok"] is False

    asyncio.run(run())


def test_a_page_that_goes_while_it_is_written_to_is_no_error():
    async def run():
        page = SlowPage()
        page.gone = True
        client = clients.Client(page, "trainee", 1)
        client.send({"t": "text"})
        await asyncio.wait_for(client.write(), 5)

    asyncio.run(run())


def test_a_page_that_takes_no_message_is_cut_off(monkeypatch):
    monkeypatch.setattr(clients, "WRITE_LIMIT", 0.05)

    async def run():
        page = SlowPage()
        page.stuck = True
        client = clients.Client(page, "trainee", 1, transport=page)
        client.send({"t": "text"})
        await asyncio.wait_for(client.write(), 5)
        assert page.aborted

    asyncio.run(run())


def test_messages_survive_any_cut():
    sent = [({"t": "a", "n": 1}, b""), ({"t": "picture"}, bytes(range(256)) * 9), ({"t": "b", "text": "line\nend"}, b"")]
    stream = b"".join(wire.encode(m, d) for m, d in sent)
    source = random.Random(3)
    for _ in range(50):
        reader, got, at = wire.Reader(), [], 0
        while at < len(stream):
            step = source.randint(1, 700)
            got += reader.feed(stream[at:at + step])
            at += step
        assert [(m["t"], d) for m, d in got] == [(m["t"], d) for m, d in sent]


def test_a_stream_that_is_no_message_is_an_error():
    with pytest.raises(ValueError):
        wire.Reader().feed(b"garbage\n")
    with pytest.raises(ValueError):
        wire.Reader().feed(b'{"t": "x", "bytes": 99999999999}\n')


def test_the_picture_has_axes_of_the_hands():
    """A camera that looks forward and down, from straight behind and from the right."""
    tree = frames.Frames()
    assert tree.view("endoscope_optical_frame") is None
    half = math.sqrt(0.5)
    into_x = [-0.5, 0.5, -0.5, 0.5]  # optical axes right, down, into along -y, -z, x of the world
    tree.put("camera", "world", [0, 0, 0], hands.turned([0.0, math.radians(40), 0.0]))
    tree.put("endoscope_optical_frame", "camera", [0, 0, 0], into_x)
    c, s = math.cos(math.radians(40)), math.sin(math.radians(40))
    right, up, into = tree.view("endoscope_optical_frame")
    assert right == pytest.approx([1, 0, 0]) and up == pytest.approx([0, s, c]) and into == pytest.approx([0, c, -s])
    tree.put("camera", "world", [0, 0, 0], [0, 0, half, half])  # looks to the world's left
    right, up, into = tree.view("endoscope_optical_frame")
    assert right == pytest.approx([0, 1, 0]) and up == pytest.approx([0, 0, 1]) and into == pytest.approx([-1, 0, 0])


def test_tips_are_compared_over_the_chain_of_frames():
    tree = frames.Frames()
    half = math.sqrt(0.5)
    for side, shift in (("model", 0.0), ("robot", 0.003)):
        tree.put(f"{side}/base_link_L", "world", [1, 0, 0], [0, 0, half, half])
        tree.put(f"{side}/grasper1_L", f"{side}/base_link_L", [0.1 + shift, 0, 0], [0, 0, 0, 1], stamp=1)
    assert tree.origin("model/grasper1_L") == pytest.approx([1, 0.1, 0])
    assert tree.apart("L") == pytest.approx(0.003)
    assert tree.apart("R") is None
    tree.put("model/grasper1_L", "model/base_link_L", [0.2, 0, 0], [0, 0, 0, 1], stamp=2)
    assert tree.apart("L") is None, "the robot is gone; its last pose is one of another moment"
    tree.put("loop", "loop", [0, 0, 0], [0, 0, 0, 1])
    assert tree.origin("loop") is None


def test_a_message_that_was_sent_in_part_ends_the_link():
    ours, theirs = socket.socketpair()
    ours.setblocking(False)
    ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
    link = ros_link.RosLink(None, None)
    link._connection, link.is_up = ours, True
    assert link.send({"t": "hands"})
    assert not link.send({"t": "hands", "text": "x" * (1 << 20)})
    theirs.settimeout(5)
    while theirs.recv(1 << 16):
        pass
    assert not link.send({"t": "hands"}), "the end of the stream was read: no later message is taken for the rest"
    ours.close()
    theirs.close()
