"""Work after a session: the report, and the video on request. One report and one video at a time, at the lowest priority."""

import asyncio
import contextlib
import os
import pathlib
import re
import signal
import time

import psutil

PATIENCE = 15.0  # [s] for reports when the station ends
PERCENT = re.compile(rb"(\d+) ?%")
PLACES = re.compile(r"^(?:(?:/\S*|raven2_trainer): )+")  # in front of a message: the page names the session itself
CONTROL = re.compile(rb"\x1b\[[0-9;]*[A-Za-z]")  # of a terminal


class Finisher:
    """@param programs, scripts: folders. @param changed(session, what, share, text): progress; share 1 is done, None failed."""

    def __init__(self, programs, scripts, changed):
        self._programs, self._scripts, self._changed = programs, scripts, changed
        self._locks = {"report": asyncio.Lock(), "video": asyncio.Lock()}  # a report does not wait for a video
        self._wanted, self._again = set(), set()
        self._tasks = set()
        self._running = {}  # what -> process
        self._ends = False

    def report(self, directory):
        return self._begin(directory, "report", ["/usr/bin/python3", str(self._scripts / "session_report"), str(directory)])

    def video(self, directory):
        return self._begin(directory, "video", [str(self._programs / "render_session"), str(directory)])

    def _begin(self, directory, what, command):
        key = (directory.name, what)
        if key in self._wanted:
            self._again |= {key} if what == "report" else set()  # of the session as it is now
            return None
        self._wanted.add(key)
        task = asyncio.ensure_future(self._run(key, command))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task

    async def end(self):
        """When the station ends. Reports are finished. A video takes minutes and can be asked for again, so it is ended."""
        self._ends = True
        self._stop("video")
        if self._tasks:
            await asyncio.wait(self._tasks, timeout=PATIENCE)
        self._stop("report")

    def is_busy(self, name):
        return any((name, what) in self._wanted for what in self._locks)

    def _stop(self, what):
        if what in self._running:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self._running[what].pid, signal.SIGTERM)

    async def _run(self, key, command):
        name, what = key
        try:
            async with self._locks[what]:
                if self._ends and what == "video":
                    return
                self._changed(name, what, 0.0, "")
                code, reason = await self._work(what, command, lambda share: self._changed(name, what, share, ""))
                self._changed(name, what, 1.0 if code == 0 else None, "" if code == 0 else reason)
                if what == "video" and code == 0 and not self._ends:
                    self.report(pathlib.Path(command[-1]))  # with the video's pictures
        finally:
            self._wanted.discard(key)
            if key in self._again:
                self._again.discard(key)
                self._begin(pathlib.Path(command[-1]), what, command)

    async def _work(self, what, command, report_share):
        """@return (exit status, the last line of stderr)."""
        terminal, end = os.openpty()  # to a pipe, programs write only every 25 %
        try:
            process = await asyncio.create_subprocess_exec(
                "nice", "-n", "19", *command, stdin=asyncio.subprocess.DEVNULL, stdout=asyncio.subprocess.DEVNULL,
                stderr=end, start_new_session=True)
        except BaseException:
            os.close(terminal)
            raise
        finally:
            os.close(end)
        self._running[what] = process
        if self._ends and what == "video":  # meanwhile
            self._stop(what)
        last = await _follow(terminal, report_share)
        code = await process.wait()
        if self._ends and what == "video":
            await _until_gone(process.pid)
        del self._running[what]
        lines = [line for line in last.decode(errors="replace").replace("\r", "\n").split("\n") if line.strip()]
        return code, PLACES.sub("", (lines or ["it failed"])[-1].strip())[:200]


async def _until_gone(group):
    """The renderer's own workers have the signal, too, but may end later."""
    until = time.monotonic() + PATIENCE
    while time.monotonic() < until and any(_is_of(group, process) for process in psutil.process_iter()):
        await asyncio.sleep(0.02)


def _is_of(group, process):
    try:
        return os.getpgid(process.pid) == group and process.status() != psutil.STATUS_ZOMBIE
    except (OSError, psutil.Error):  # it has ended
        return False


async def _follow(terminal, report_share):
    """Reads until the program has closed its end. @return the last that it wrote."""
    reader, loop = asyncio.StreamReader(), asyncio.get_running_loop()
    transport, _ = await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), os.fdopen(terminal, "rb", 0))
    last, shown = b"", b""
    try:
        while data := await reader.read(4096):
            last = (last + data)[-2000:]
            found = PERCENT.findall(last)
            if found and found[-1] != shown:
                shown = found[-1]
                report_share(min(0.99, int(shown) / 100))
    except OSError:  # EIO: the end of a terminal
        pass
    finally:
        transport.close()
    return CONTROL.sub(b"", last)
