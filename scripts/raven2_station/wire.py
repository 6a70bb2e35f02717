"""Messages between the server and `ros_side`: a line of JSON, followed by `bytes` raw bytes where it says so."""

import json

LIMIT = 8 << 20  # [bytes] of one message: a picture is some 60 kB


def encode(message, data=b""):
    if data:
        message = {**message, "bytes": len(data)}
    return json.dumps(message, separators=(",", ":")).encode() + b"\n" + data


class Reader:
    """Cuts a stream of bytes into messages."""

    def __init__(self):
        self._held = bytearray()
        self._head = None

    def feed(self, data):
        """@return [(message, bytes)] that are complete. @throw ValueError for something else than messages."""
        self._held += data
        found = []
        while True:
            if self._head is None:
                end = self._held.find(b"\n")
                if end < 0:
                    if len(self._held) > LIMIT:
                        raise ValueError("message without an end")
                    return found
                self._head = json.loads(self._held[:end])
                del self._held[:end + 1]
            size = self._head.get("bytes", 0)
            if not 0 <= size <= LIMIT:
                raise ValueError(f"message of {size} bytes")
            if len(self._held) < size:
                return found
            found.append((self._head, bytes(self._held[:size])))
            del self._held[:size]
            self._head = None
