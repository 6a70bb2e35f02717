"""Sessions on disk: their list, verdicts, a trainee's history, the class. Reads the files of doc/session.md; judges nothing itself."""

import csv
import fcntl
import io
import json
import os
import pathlib
import re
import shutil

from .curriculum import follow, stages_of
from .words import is_demonstration

NAME = re.compile(r"[A-Za-z0-9_:-][A-Za-z0-9_.:-]{0,119}")  # of a session directory: no separators, no leading dot
FILES = {"report.html": "text/html; charset=utf-8", "report.json": "application/json", "video.mp4": "video/mp4",
         "score.json": "application/json", "metrics.json": "application/json", "session.rlog": "application/octet-stream"}
LARGEST = 16 << 20  # [bytes] of a JSON file that is read


def _json(path):
    try:
        if path.stat().st_size > LARGEST:
            return None
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None


def _dict(value):
    return value if isinstance(value, dict) else {}


def _dicts(value):
    """Those of a list; of anything else, none."""
    return [_dict(each) for each in value] if isinstance(value, list) else []


def _text(value):
    return value if isinstance(value, str) else ""


def _header_of_log(path):
    import raven2_session  # numpy: only here
    try:
        return _dict(raven2_session.read_header(path))
    except raven2_session.SessionError:
        return {}


def _newest_ended(attempts):
    """As the report takes it: the newest that came to an end; else the newest."""
    ended = [a for a in attempts if a.get("status") in ("done", "failed")]
    return (ended or attempts or [{}])[-1]


def _is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _is_within(tick, attempt):
    first, last = attempt.get("first_tick"), attempt.get("last_tick")
    return _is_number(tick) and (not _is_number(first) or first <= tick) and (not _is_number(last) or tick <= last)


def _names(found):
    """Each once, in order."""
    return list(dict.fromkeys(name for name in found if isinstance(name, str)))


class Records:
    def __init__(self, folder):
        self.folder = pathlib.Path(folder)

    def directory(self, name):
        """@throw KeyError if this is no session's name, or no session has it."""
        if not isinstance(name, str) or not NAME.fullmatch(name):
            raise KeyError(name)
        path = self.folder / name
        if path.is_symlink() or not (path / "session.rlog").is_file():
            raise KeyError(name)
        return path

    def file(self, name, which):
        path = self.directory(name) / which
        if which not in FILES or path.is_symlink() or not path.is_file():
            raise KeyError(which)
        return path, FILES[which]

    def names(self):
        if not self.folder.is_dir():
            return []
        return sorted((p.name for p in self.folder.iterdir() if NAME.fullmatch(p.name) and not p.is_symlink() and
                       (p / "session.rlog").is_file()), reverse=True)

    def list(self, skip=0, most=200):
        """The newest, behind the first `skip` of them."""
        return [self.summary(name) for name in self.names()[skip:skip + most]]

    def summary(self, name):
        path = self.directory(name)
        report, meta = _dict(_json(path / "report.json")), _dict(_json(path / "meta.json"))
        session, verdict = _dict(report.get("session")), _dict(report.get("verdict"))
        acted = [h.get("scenario") for h in _dicts(report.get("hazards"))]
        if not report:  # not made yet, or it failed
            session, verdict, acted = self._without_report(path)
        return {"name": name, "start": meta.get("start_time_utc", ""), "trainee": _text(session.get("trainee")),
                "exercise": _text(session.get("exercise")), "drill": _text(session.get("drill")), "hazards": _names(acted),
                "driver": _text(meta.get("motion")), "passed": verdict.get("passed"),
                "duration": session.get("duration_s"), "report": (path / "report.html").is_file(),
                "video": (path / "video.mp4").is_file()}

    def _without_report(self, path):
        """The same facts of the log's header, score.json and metrics.json."""
        header, metrics = _header_of_log(path / "session.rlog"), _dict(_json(path / "metrics.json"))
        session = {"trainee": header.get("trainee"), "exercise": header.get("exercise"), "drill": header.get("drill"),
                   "duration_s": metrics.get("duration_s") if _is_number(metrics.get("duration_s")) else None}
        attempt = _newest_ended(_dicts(_dict(_json(path / "score.json")).get("attempts")))
        return session, {"passed": attempt.get("passed")}, [fault.get("name") for fault in _dicts(metrics.get("faults"))]

    def verdict(self, name):
        """For the end of a session: the headline and three things to improve."""
        report = _dict(_json(self.directory(name) / "report.json"))
        verdict = _dict(report.get("verdict"))
        improve = [{"what": i.get("what", ""), "how": i.get("how", "")} for i in report.get("improve") or [] if isinstance(i, dict)]
        return {"name": name, "headline": verdict.get("headline", "No report yet"), "passed": verdict.get("passed"),
                "reasons": verdict.get("reasons", []), "improve": improve[:3], "no_advice": _text(report.get("no_advice")),
                "summary": report.get("summary", ""),
                "video": (self.directory(name) / "video.mp4").is_file()}

    def exercise(self, name):
        """Of the report; of a session without one, of its log. @return "none" for a free session, or if neither can be read."""
        path = self.directory(name)
        found = _dict(_dict(_json(path / "report.json")).get("session")).get("exercise")
        return _text(found) or _text(_header_of_log(path / "session.rlog").get("exercise")) or "none"

    def delete(self, name):
        """The files first: on a full disk the index cannot be written before they are gone."""
        shutil.rmtree(self.directory(name))
        self._forget(name)

    def _forget(self, name):
        """Its attempts count no longer. Lock and exchange of the file are those of src/training/session_index.cpp."""
        path = self.folder / "index.json"
        if not path.is_file():
            return
        with open(f"{path}.lock", "a", encoding="utf-8") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            index = _dict(_json(path))
            entries = index.get("sessions")
            kept = [e for e in entries if _dict(e).get("directory") != name] if isinstance(entries, list) else entries
            if kept == entries:
                return
            part = pathlib.Path(f"{path}.part")
            part.write_text(json.dumps({**index, "sessions": kept}, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
            os.replace(part, path)

    # ---- trainees

    def _index(self):
        entries = _dict(_json(self.folder / "index.json")).get("sessions")
        return [e for e in (entries if isinstance(entries, list) else []) if isinstance(e, dict) and e.get("trainee") and
                all(isinstance(e.get(key), str) for key in ("trainee", "directory", "start_time_utc"))]

    def trainees(self):
        return sorted({e["trainee"] for e in self._index()})

    def history(self, trainee):
        """Attempts in order of time, as score_session takes them: result, score, time, hazard response."""
        found = []
        for entry in self._index():
            if entry["trainee"] != trainee:
                continue
            attempts = entry.get("attempts")
            scored, driver = self._scored(entry["directory"])
            for number, attempt in enumerate(map(_dict, attempts if isinstance(attempts, list) else [])):
                metrics = _dict(attempt.get("metrics"))
                score, hazards = scored[number] if number < len(scored) else (None, [])
                found.append({"session": entry.get("directory", ""), "start": entry.get("start_time_utc", ""),
                              "exercise": entry.get("exercise", ""), "drill": entry.get("drill", ""),
                              "status": attempt.get("status"), "passed": attempt.get("passed"), "time": metrics.get("time"),
                              "response": metrics.get("hazard_response"), "score": score, "hazards": hazards, "driver": driver})
        return sorted(found, key=lambda a: (a["start"], a["session"]))

    def _scored(self, name):
        """Of a session: (of each attempt the share [-] of its judged metrics that passed, None where nothing was judged, and the
        hazards that acted; who moved the arms)."""
        try:
            path = self.directory(name)
        except KeyError:
            return [], ""
        score = _dict(_json(path / "score.json"))
        hazards = _dicts(score.get("hazards"))
        found = []
        for attempt in _dicts(score.get("attempts")):
            share = attempt.get("composite")
            acted = [h.get("scenario") for h in hazards if _is_within(h.get("injection_tick"), attempt)]
            found.append((share if _is_number(share) else None, _names(acted)))
        return found, _text(_dict(_json(path / "meta.json")).get("motion"))

    def progress(self, trainee, curriculum):
        """@return as of curriculum.follow()."""
        return follow(curriculum, self.history(trainee) if trainee else [])

    def the_class(self, curriculum):
        """One row a trainee, one cell a stage. @param curriculum: of Library.curricula, or None."""
        rows = []
        for trainee in self.trainees():
            history = self.history(trainee)
            stages, current = follow(curriculum, history)
            rows.append({"trainee": trainee, "sessions": len({a["session"] for a in history}),
                         "demonstrations": len({a["session"] for a in history if is_demonstration(a["driver"])}), "current": current,
                         "stages": [stage.describe() for stage in stages], "last": history[-1]["start"] if history else ""})
        return rows

    def class_csv(self, curriculum):
        """Text is quoted; an ID that a spreadsheet would take for a formula gets a ' in front."""
        out = io.StringIO()
        writer = csv.writer(out)
        titles = [stage.title for stage in stages_of(curriculum)]
        writer.writerow(["trainee", "sessions", *[f"{t} {what}" for t in titles for what in ("attempts", "passes in a row", "more passes", "done")],
                         "last session (UTC)", "demonstrated sessions"])
        for row in self.the_class(curriculum):
            cells = [value for s in row["stages"] for value in (s["attempts"], s["in_a_row"], s["more"], "yes" if s["done"] else "no")]
            writer.writerow(["'" + row["trainee"] if row["trainee"].startswith(("=", "+", "-", "@", "\t", "\r")) else row["trainee"], row["sessions"], *cells,
                             row["last"], row["demonstrations"]])
        return out.getvalue()
