"""The server's end of `ros_side`: keeps it running, sends it messages, gets its messages."""

import asyncio
import os
import socket
import sys

from . import wire

RESTART = 0.5  # [s] between attempts to reach a ROS master
NO_ANSWER = (False, "the trainer does not answer", {})


class RosLink:
    """@param heard(message, bytes): each message. @param changed(): the link came or went."""

    def __init__(self, heard, changed, command=None):
        self._heard, self._changed = heard, changed
        self._command = command or [sys.executable, "-u", "-m", "raven2_station.ros_side"]
        self._connection = None
        self._calls, self._number = {}, 0
        self.is_up = False
        self.is_taken = False  # another station has this ROS master

    async def run(self):
        """For ever: a `ros_side` that ends is started again."""
        folder = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
        environment = {**os.environ, "PYTHONPATH": folder + os.pathsep + os.environ.get("PYTHONPATH", "")}
        while True:
            ours, theirs = socket.socketpair()
            ours.setblocking(False)
            process = await asyncio.create_subprocess_exec(*self._command, stdin=theirs, stdout=asyncio.subprocess.DEVNULL,
                                                           env=environment)
            theirs.close()
            self._connection = ours
            try:
                await self._listen(ours)
            finally:
                self._connection = None
                ours.close()
                if process.returncode is None:
                    try:
                        process.kill()
                    except ProcessLookupError:
                        pass
                await process.wait()
                self._lose()
            await asyncio.sleep(RESTART)

    async def _listen(self, connection):
        reader, loop = wire.Reader(), asyncio.get_running_loop()
        while True:
            try:
                data = await loop.sock_recv(connection, 1 << 18)
                messages = reader.feed(data)
            except (OSError, ValueError):
                return
            if not data:
                return
            for message, extra in messages:
                if message["t"] in ("up", "taken"):
                    self.is_up, self.is_taken = message["t"] == "up", message["t"] == "taken"
                    self._changed()
                elif message["t"] == "called":
                    waiting = self._calls.pop(message["number"], None)
                    if waiting is not None and not waiting.done():
                        waiting.set_result((message["ok"], message["text"], message["more"]))
                else:
                    self._heard(message, extra)

    def _lose(self):
        was_up, self.is_up, self.is_taken = self.is_up, False, False
        for waiting in self._calls.values():
            if not waiting.done():
                waiting.set_result(NO_ANSWER)
        self._calls.clear()
        if was_up:
            self._changed()

    def send(self, message):
        """@return whether it was sent. Messages are small: a link that does not take one whole is ended, and starts again."""
        if self._connection is None or not self.is_up:
            return False
        data = wire.encode(message)
        try:
            sent = self._connection.send(data)
        except OSError:
            return False
        if sent < len(data):  # what follows would be read as its rest
            self._connection.shutdown(socket.SHUT_RDWR)
        return sent == len(data)

    async def call(self, service, arguments=None, limit=20.0):
        """@return (whether it happened, a sentence, the other fields of the answer)."""
        if not self.is_up:
            return False, "there is no ROS master", {}
        self._number += 1
        waiting = asyncio.get_running_loop().create_future()
        self._calls[self._number] = waiting
        if not self.send({"t": "call", "number": self._number, "service": service, "arguments": arguments or {}}):
            self._calls.pop(self._number, None)
            return NO_ANSWER
        try:
            return await asyncio.wait_for(waiting, limit)
        except asyncio.TimeoutError:
            return NO_ANSWER
