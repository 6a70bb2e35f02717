"""Work after a session: the report, and the video on request. One program at a time, at the lowest priority."""

import asyncio
import re

PERCENT = re.compile(rb"(\d+) ?%")


class Finisher:
    """@param programs, scripts: folders. @param changed(session, what, share, text): progress; share 1 is done, None failed."""

    def __init__(self, programs, scripts, changed):
        self._programs, self._scripts, self._changed = programs, scripts, changed
        self._lock = asyncio.Lock()
        self._wanted = set()

    def report(self, directory):
        return self._begin(directory, "report", ["/usr/bin/python3", str(self._scripts / "session_report"), str(directory)])

    def video(self, directory):
        return self._begin(directory, "video", [str(self._programs / "render_session"), str(directory)])

    def _begin(self, directory, what, command):
        key = (directory.name, what)
        if key in self._wanted:
            return None
        self._wanted.add(key)
        return asyncio.ensure_future(self._run(key, command))

    async def _run(self, key, command):
        name, what = key
        try:
            async with self._lock:
                self._changed(name, what, 0.0, "")
                process = await asyncio.create_subprocess_exec(
                    "nice", "-n", "19", *command, stdin=asyncio.subprocess.DEVNULL, stdout=asyncio.subprocess.DEVNULL,
                    stderr=asyncio.subprocess.PIPE, start_new_session=True)
                last = b""
                while True:
                    data = await process.stderr.read(4096)
                    if not data:
                        break
                    last = (last + data)[-2000:]
                    found = PERCENT.findall(data)
                    if found:
                        self._changed(name, what, min(0.99, int(found[-1]) / 100), "")
                code = await process.wait()
                lines = [line for line in last.decode(errors="replace").replace("\r", "\n").split("\n") if line.strip()]
                self._changed(name, what, 1.0 if code == 0 else None, "" if code == 0 else (lines or ["it failed"])[-1][:200])
        finally:
            self._wanted.discard(key)
