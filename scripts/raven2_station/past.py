"""Requests of pages about recorded sessions: their list, reports, videos and replays, and the trainees' progress."""

import asyncio
import contextlib
import time

from . import words
from .curriculum import stages_of
from .supervisor import Refused

REPLAY_START = 30.0  # [s] until a session that is started for a replay is ready


class PastSessions:
    """A part of Station."""

    async def _do_sessions(self, given, _):
        """The newest, or those behind the first `skip` of them."""
        skip = given.get("skip", 0)
        if not isinstance(skip, int) or isinstance(skip, bool) or skip < 0:
            raise Refused("skip is a whole number from 0")
        return True, "", await asyncio.to_thread(lambda: {
            "sessions": self.records.list(skip), "count": len(self.records.names()), "trainees": self.records.trainees()})

    async def _do_verdict(self, given, _):
        name = given.get("session")
        verdict = await asyncio.to_thread(self.records.verdict, name)
        share, text = self.progress.get((name, "report"), (0.0, ""))
        return True, "", {**verdict, "trouble": text if share is None else ""}

    async def _do_report(self, given, _):
        self._refuse_running(given.get("session"))
        self.finisher.report(self.records.directory(given.get("session")))
        return True, "The report is being written.", {}

    async def _do_video(self, given, _):
        self._refuse_running(given.get("session"))
        self.finisher.video(self.records.directory(given.get("session")))
        return True, "The video is being rendered.", {}

    async def _do_replay(self, given, _):
        """In the running session; without one, the programs are started in the same scene, and no session is kept of that."""
        directory = self.records.directory(given.get("session"))
        self._refuse_running(directory.name)
        starts = self.supervisor.phase == "idle" and not self.is_foreign
        if starts:
            await self._await_ros()
            await self._start_replay(directory.name)
        ok, text, more = await self.link.call("begin_replay", {"session": str(directory)})
        if ok:
            return True, "The picture shows the recorded session.", more
        if starts and self.supervisor.is_replay:  # no session that somebody has started meanwhile
            with contextlib.suppress(Refused):
                await self.supervisor.end()
        why = (starts and self.supervisor.trouble) or text
        return False, f"The session is not shown. {words.answer(why)}", more

    async def _start_replay(self, name):
        exercise = await asyncio.to_thread(self.records.exercise, name)
        await self.supervisor.start({"driver": "browser", "exercise": exercise if self.known.exercise(exercise) else "none"},
                                    replay=True)
        until = time.monotonic() + REPLAY_START
        while self.supervisor.is_running and self.newest.get("mode", {}).get("mode") != "pedal_up" and time.monotonic() < until:
            await asyncio.sleep(0.1)

    async def _do_delete(self, given, _):
        name = self.records.directory(given.get("session")).name
        self._refuse_running(name)
        if self.finisher.is_busy(name):
            raise Refused("its report or video is being written: wait for it")
        if given.get("sure") is not True:
            raise Refused("deleting needs a confirmation")
        try:
            await asyncio.to_thread(self.records.delete, name)
        except OSError as error:
            raise Refused(f"the session is not deleted completely: {error.strerror}") from error
        return True, "Deleted.", {}

    async def _do_history(self, given, _):
        trainee = given.get("trainee")
        attempts = await asyncio.to_thread(self.records.history, trainee)
        if not attempts and trainee not in await asyncio.to_thread(self.records.trainees):
            raise Refused("this trainee has no session yet")
        return True, "", {"trainee": trainee, "attempts": attempts}

    async def _do_class(self, given, _):
        curriculum = self.known.curriculum(given.get("curriculum"))
        return True, "", {"title": (curriculum or {}).get("title", ""), "titles": [stage.title for stage in stages_of(curriculum)],
                          "rows": await asyncio.to_thread(self.records.the_class, curriculum)}

    async def _do_stage(self, given, _):
        """A trainee's stage in a curriculum."""
        name, trainee = given.get("curriculum"), given.get("trainee")
        if not name or name not in self.known.names("curricula"):
            raise Refused("that curriculum is unknown")
        stages, current = await asyncio.to_thread(self.records.progress, trainee if isinstance(trainee, str) else "",
                                                  self.known.curriculum(name))
        return True, "", {"stages": [stage.describe() for stage in stages], "current": current}
