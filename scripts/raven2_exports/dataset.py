"""Many sessions as one data set: episodes on all cores, kept until the data set is complete, so that an export that was
killed continues."""

import collections
import concurrent.futures
import ctypes
import hashlib
import json
import os
import pathlib
import shutil
import signal
import subprocess

import numpy as np
from raven2_exports import episode
from raven2_progress import Bar, cancelling

import raven2_session


class Pictures:
    """Cameras and their pictures: `cameras` of config/render.yaml, `size` (width, height)."""

    def __init__(self, cameras, size, program):
        self.cameras, self.size, self.program = tuple(cameras), size, program


class Part:
    """One session's episode on the disk: table.npz, part.json and CAMERA.mp4."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.facts = json.loads((self.folder / "part.json").read_text(encoding="utf-8"))
        self.length = self.facts["length"]

    def columns(self):
        with np.load(self.folder / "table.npz", allow_pickle=False) as table:
            return {name: table[name] for name in table.files}

    def ends(self):
        """(done, reward) of each frame: an episode is done with its last frame; the reward is 1 there if the exercise is."""
        done = np.zeros(self.length, bool)
        done[-1] = True
        return done, done.astype(np.float32) * np.float32(self.facts["success"])

    def video(self, camera):
        return self.folder / f"{camera}.mp4"

    def frames(self, camera, size):
        """Each picture of the video, (height, width, 3) uint8. Only one is in memory: a session of three minutes has a gigabyte."""
        command = ["ffmpeg", "-loglevel", "error", "-i", self.video(camera), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
        with subprocess.Popen(command, stdout=subprocess.PIPE) as decoder:
            while raw := decoder.stdout.read(3 * size[0] * size[1]):
                yield np.frombuffer(raw, np.uint8).reshape(size[1], size[0], 3)
        if decoder.returncode != 0:
            raise OSError(f"{self.video(camera)}: ffmpeg ended with {decoder.returncode}")


def _key(directory, fps, pictures):
    """Changes with the session's log and score, the export's options and this program."""
    words = [str(fps), *pictures.cameras, str(pictures.size)]
    for name in ("session.rlog", "score.json", "metrics.json"):
        path = os.path.join(directory, name)
        if os.path.exists(path):
            status = os.stat(path)
            words += [name, str(status.st_size), str(status.st_mtime_ns)]
    words += [hashlib.sha256(pathlib.Path(module.__file__).read_bytes()).hexdigest() for module in (episode,)]
    return hashlib.sha256("\n".join([os.path.abspath(directory), *words]).encode()).hexdigest()[:16]


def _draw(directory, folder, fps, pictures, length):
    for camera in pictures.cameras:
        path = folder / f"{camera}.mp4"
        size = "x".join(map(str, pictures.size))
        done = subprocess.run([pictures.program, directory, "--camera", camera, "--inset", "none", "--overlay", "none", "--size", size,
                               "--fps", str(fps), "--processes", "1", "--output", path], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise raven2_session.SessionError(f"{directory}: render_session: {(done.stderr.strip().splitlines() or ['no word'])[-1]}")
        drawn = int(subprocess.run(["ffprobe", "-v", "error", "-count_packets", "-select_streams", "v:0", "-show_entries",
                                    "stream=nb_read_packets", "-of", "csv=p=0", path], capture_output=True, text=True, check=True).stdout)
        if drawn != length:
            raise raven2_session.SessionError(f"{directory}: the video of {camera} has {drawn} frames, the session {length}")


def make_part(directory, folder, fps, pictures):
    """Writes a session's part, unless it is there. @return None, or the reason why there is no part."""
    folder = pathlib.Path(folder)
    if (folder / "part.json").exists():
        return None
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    try:
        made = episode.Episode(directory, fps)
        columns = {name: np.array(values) if isinstance(values, list) else np.asarray(values, np.float32)
                   for name, values in made.columns.items()}
        bad = [name for name, values in columns.items() if values.dtype.kind == "f" and not np.isfinite(values).all()]
        if bad:
            raise raven2_session.SessionError(f"{directory}: NaN or infinity in {bad[0]}")
        np.savez(folder / "table.npz", **columns)
        _draw(directory, folder, fps, pictures, made.length)
    except (raven2_session.SessionError, OSError, ValueError, KeyError, IndexError) as error:
        shutil.rmtree(folder, ignore_errors=True)
        return f"{directory}: {error}" if str(directory) not in str(error) else str(error)
    facts = {"length": made.length, "task": made.task, "objects": made.objects, **made.summary}
    (folder / "part.json.new").write_text(json.dumps(facts), encoding="utf-8")
    os.replace(folder / "part.json.new", folder / "part.json")  # last: a part with it is complete
    return None


def end_with_parent():
    """A worker whose parent was killed would wait for work for ever."""
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    ctypes.CDLL(None).prctl(1, signal.SIGTERM)  # PR_SET_PDEATHSIG


def make_parts(directories, work, fps, pictures, jobs):
    """Parts of all sessions, in the order of splits and names. @throw SessionError with the first reason, after all others."""
    folders = {directory: pathlib.Path(work) / _key(directory, fps, pictures) for directory in directories}
    bar, refused = Bar(len(directories), "exported"), []
    with cancelling(concurrent.futures.ProcessPoolExecutor(jobs, initializer=end_with_parent)) as pool:
        waiting = {pool.submit(make_part, directory, folder, fps, pictures): directory for directory, folder in folders.items()}
        for each in concurrent.futures.as_completed(waiting):
            refused += [each.result()] if each.result() else []
            bar.step(os.path.basename(os.path.abspath(waiting[each])))
    if refused:
        raise raven2_session.SessionError(refused[0] + (f" (and {len(refused) - 1} more sessions)" if len(refused) > 1 else ""))
    parts = [Part(folders[directory]) for directory in directories]
    return sorted(parts, key=lambda part: (episode.SPLITS.index(part.facts["split"]), part.facts["session"]))


def demand_all(count, part, camera):
    """@throw OSError if that is not the number of pictures that the episode has."""
    if count != part.length:
        raise OSError(f"the video of {camera} of session {part.facts['session']} has {count} pictures, the session {part.length}")


def ahead(pool, work, items, most):
    """work(item) of each item, in order. At most `most` are computed or wait: a pool's map() would take all items at once."""
    waiting = collections.deque()
    for item in items:
        waiting.append(pool.submit(work, item))
        if len(waiting) >= most:
            yield waiting.popleft().result()
    while waiting:
        yield waiting.popleft().result()


def splits(parts):
    """Split to (first, behind the last) episode; empty splits are left out."""
    names = [part.facts["split"] for part in parts]
    return {name: (names.index(name), names.index(name) + names.count(name)) for name in episode.SPLITS if name in names}


def export(directories, output, write, fps, pictures, jobs):
    """Calls write(parts, path) for a path next to `output`, and renames it when it is complete."""
    output = pathlib.Path(output)
    if output.exists():
        raise raven2_session.SessionError(f"{output} exists; delete it or choose another --output")
    if len({os.path.abspath(directory) for directory in directories}) != len(directories):
        raise raven2_session.SessionError("a session is given twice")
    work = output.with_name(output.name + ".parts")
    work.mkdir(parents=True, exist_ok=True)
    parts = make_parts(directories, work, fps, pictures, jobs)
    fresh = work / "dataset"
    shutil.rmtree(fresh, ignore_errors=True) if fresh.is_dir() else fresh.unlink(missing_ok=True)
    write(parts, fresh)
    os.replace(fresh, output)
    shutil.rmtree(work, ignore_errors=True)
    return parts
