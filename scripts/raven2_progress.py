"""For scripts that run many sessions: seeds as the user gives them, and how far they are."""

import contextlib
import sys
import time

BAR = 30  # characters


def read_seeds(text):
    """1001-1020, or 1,5,7, or both."""
    seeds = []
    for part in text.split(","):
        first, _, last = part.partition("-")
        seeds += range(int(first), int(last or first) + 1)
    return seeds


@contextlib.contextmanager
def cancelling(pool):
    """A pool of concurrent.futures. After an exception, Ctrl-C for example, it starts nothing more."""
    try:
        yield pool
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        raise
    pool.shutdown()


class Bar:
    """Progress on stderr: redrawn in place on a terminal, a line for each session elsewhere. `verb`: done with each."""

    def __init__(self, count, verb=""):
        self.count, self.done, self.begun, self.verb = count, 0, time.monotonic(), verb and verb + " "

    def step(self, text):
        self.done += 1
        left = (time.monotonic() - self.begun) / self.done * (self.count - self.done)
        line = f"{self.verb}{self.done}/{self.count} {text}; about {left / 60:.0f} min left"
        if sys.stderr.isatty():
            filled = BAR * self.done // self.count
            end = "\n" if self.done == self.count else ""
            line = f"\r[{'#' * filled}{'.' * (BAR - filled)}] {line}\033[K{end}"
            print(line, end="", file=sys.stderr, flush=True)
        else:
            print(line, file=sys.stderr, flush=True)
