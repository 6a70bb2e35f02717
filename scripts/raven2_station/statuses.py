"""Statuses of the programs, from /diagnostics."""

import time

OLD = 3.0          # [s] a status comes once a second
MASTER = "master "  # begins the names of statuses that the console sends, not the daemon


class Statuses:
    """The newest of each name. Daemon and console have a message of their own each: neither replaces the other's."""

    def __init__(self):
        self._newest = {}  # name: (when, (name, level, message))

    def hear(self, statuses):
        """@return whether they are the daemon's."""
        now = time.monotonic()
        self._newest.update({status[0]: (now, tuple(status)) for status in statuses})
        self._newest = {name: each for name, each in self._newest.items() if now - each[0] <= OLD}
        return not all(status[0].startswith(MASTER) for status in statuses)

    def clear(self):
        self._newest.clear()

    @property
    def all(self):
        return [status for _, status in self._newest.values()]

    def message(self, name):
        """"" if none has come."""
        return self._newest[name][1][2] if name in self._newest else ""
