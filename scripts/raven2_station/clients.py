"""One browser page behind a WebSocket: what waits to be sent to it, and how much it may send."""

import asyncio
import json
import time

MOST_WAITING = 500    # messages; a page that reads no more than that is closed
RATE, BURST = 200.0, 400.0  # [1/s], messages of a page
MOST_DROPPED = 2000   # messages over that rate, then the page is closed
WARN_EVERY = 1.0      # [s]
MOST_AHEAD = 3        # pictures that the page has not shown yet
AHEAD_LIMIT = 1.0     # [s] then they count as shown: a busy page does not say so
WRITE_LIMIT = 5.0     # [s] for one message: the page is gone
PICTURES = {"view": b"\x00", "second": b"\x01"}


class Client:
    """@param role: instructor or trainee."""

    def __init__(self, socket, role, number, transport=None):
        self.socket, self.role, self.number, self._transport = socket, role, number, transport
        self.wants = {"view"}      # pictures
        self._texts, self._pictures = [], {}
        self._wake = asyncio.Event()
        self._tokens, self._filled, self.dropped = BURST, time.monotonic(), 0
        self._warned = -WARN_EVERY
        self.overrun = False
        self.acknowledges, self._ahead, self._shown_at = False, 0, 0.0

    def send(self, message):
        if len(self._texts) >= MOST_WAITING:
            self.overrun = True
        else:
            self._texts.append(json.dumps(message, separators=(",", ":")))
        self._wake.set()

    def show(self, which, data):
        """The newest picture replaces one that still waits."""
        if which in self.wants:
            self._pictures[which] = data
            self._wake.set()

    def shown(self):
        """The page has shown one more picture."""
        self._ahead = max(0, self._ahead - 1)
        self._wake.set()

    def may_speak(self):
        """@return whether one more message is within the rate."""
        now = time.monotonic()
        self._tokens = min(BURST, self._tokens + RATE * (now - self._filled))
        self._filled = now
        if self._tokens < 1.0:
            self.dropped += 1
            return False
        self._tokens -= 1.0
        return True

    def warn(self):
        """Why messages get no answer, at most once a second: an answer to each would be a second flood."""
        now = time.monotonic()
        if now - self._warned >= WARN_EVERY:
            self._warned = now
            self.send({"t": "reply", "id": None, "ok": False, "text": f"too many messages: {RATE:.0f} a second are read"})

    async def write(self):
        """Until the page is closed."""
        while not self.socket.closed:
            await self._wake.wait()
            self._wake.clear()
            if self.overrun:
                await self.socket.close(code=1008, message=b"the page reads too slowly")
                return
            try:
                await asyncio.wait_for(self._write_all(), WRITE_LIMIT)
            except ConnectionError:  # the page has gone
                return
            except asyncio.TimeoutError:
                if self._transport is not None:
                    self._transport.abort()  # close() would wait for the page to read
                return

    async def _write_all(self):
        texts, self._texts = self._texts, []
        for text in texts:
            await self.socket.send_str(text)
        now = time.monotonic()
        if self.acknowledges and self._ahead >= MOST_AHEAD:
            if now - self._shown_at < AHEAD_LIMIT:
                return
            self._ahead = 0
        pictures, self._pictures = self._pictures, {}
        for which, data in pictures.items():
            self._ahead, self._shown_at = self._ahead + 1, now
            await self.socket.send_bytes(PICTURES[which] + data)
