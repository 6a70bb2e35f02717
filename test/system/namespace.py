"""A network namespace with its own loopback interface. A test may drop packets in it without disturbing others."""

import ctypes
import itertools
import os
import subprocess

CLONE_NEWNET = 0x40000000
_numbers = itertools.count()


def missing():
    """Returns why no network namespace can be made here, or None."""
    try:
        with Namespace() as space:
            space.cut("tcp dport 1")
    except (OSError, subprocess.CalledProcessError) as error:
        return f"no network namespaces with nft here: {error}"
    return None


class Namespace:
    """Use as a context manager; `prefix` before a command runs it inside."""

    def __init__(self):
        self.name = f"raven2_{os.getpid()}_{next(_numbers)}"
        self.prefix = ("ip", "netns", "exec", self.name)

    def __enter__(self):
        self._run("ip", "netns", "add", self.name)
        self._run("ip", "-n", self.name, "link", "set", "lo", "up")
        self._nft("add", "table", "inet", "test")
        self._nft("add", "chain", "inet", "test", "in", "{ type filter hook input priority 0; }")
        return self

    def __exit__(self, *_):
        subprocess.run(["ip", "netns", "del", self.name], check=False)

    def cut(self, *what):
        """Drops matching packets from now on, e.g. "tcp dport 26100". Neither side is notified."""
        self._nft("; ".join(f"add rule inet test in {each} drop" for each in what))  # all at once

    def heal(self):
        self._nft("flush", "chain", "inet", "test", "in")

    def run(self, function, *arguments):
        """Calls a function with this thread inside. Sockets that the function makes stay inside."""
        libc = ctypes.CDLL(None, use_errno=True)
        with open("/proc/thread-self/ns/net", "rb") as outside, open(f"/run/netns/{self.name}", "rb") as inside:
            self._enter(libc, inside)
            try:
                return function(*arguments)
            finally:
                self._enter(libc, outside)

    def connections(self, port):
        """(local, peer) of the established TCP connections of the server at that port, as the system sees them."""
        listing = self._run("ss", "-Htn", "state", "established", f"sport = :{port}", inside=True)
        return [tuple(line.split()[-2:]) for line in listing.splitlines()]

    @staticmethod
    def _enter(libc, file):
        if libc.setns(file.fileno(), CLONE_NEWNET) != 0:
            raise OSError(ctypes.get_errno(), "setns")

    def _nft(self, *words):
        self._run("nft", *words, inside=True)

    def _run(self, *words, inside=False):
        command = (*self.prefix, *words) if inside else words
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout
