"""A data set in LeRobot's format, 2.1 or 3.0: parquet tables, a video for each camera and episode, and their description.

Needs pyarrow, which Debian does not have (doc/python.md says how to install it). Written from the format's description and its
reader in lerobot 0.3.3 (2.1) and 0.4.4 (3.0).
"""

import concurrent.futures
import functools
import json
import shutil
import subprocess

import numpy as np
import pyarrow
import pyarrow.parquet
from raven2_exports import dataset, episode
from raven2_progress import Bar, cancelling

ROBOT = "raven2"
CHUNK = 1000  # files in a folder
FILE_BYTES = 100 * 1024 * 1024  # of a table in 3.0
ENDS = {"next.done": "bool", "next.success": "bool", "next.reward": "float32"}
INDICES = ("timestamp", "frame_index", "episode_index", "index", "task_index")
QUANTILES = (0.01, 0.10, 0.50, 0.90, 0.99)
SAMPLES = 100  # pictures of an episode whose values its statistics use
PATHS = {
    "2.1": ("data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet",
            "videos/chunk-{episode_chunk:03d}/{video_key}/episode_{episode_index:06d}.mp4"),
    "3.0": ("data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
            "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4"),
}


def picture_key(camera):
    return f"observation.images.{camera}"


def _stream(path):
    """Codec and pixel format of a video."""
    words = ["ffprobe", "-v", "error", "-select_streams", "v:0", "-show_entries", "stream=codec_name,pix_fmt", "-of", "json", path]
    found = json.loads(subprocess.run(words, capture_output=True, check=True).stdout)["streams"][0]
    return found["codec_name"], found["pix_fmt"]


def features(fps, pictures, part):
    """The description of each column, as info.json has it; `part` is one of the episodes."""
    found = {}
    for name, (names, _, _) in episode.COLUMNS.items():
        kind = "string" if names is None else "float32"
        found[name] = {"dtype": kind, "shape": [len(names) if names else 1], "names": names or [name.split(".")[-1]]}
    width, height = pictures.size if pictures.cameras else (0, 0)
    for name, kind in ENDS.items():
        found[name] = {"dtype": kind, "shape": [1], "names": None}
    for camera in pictures.cameras:
        codec, pixels = _stream(part.video(camera))
        found[picture_key(camera)] = {
            "dtype": "video", "shape": [height, width, 3], "names": ["height", "width", "channels"],
            "info": {"video.height": height, "video.width": width, "video.codec": codec, "video.pix_fmt": pixels,
                     "video.is_depth_map": False, "video.fps": fps, "video.channels": 3, "has_audio": False}}
    for name in INDICES:
        found[name] = {"dtype": "float32" if name == "timestamp" else "int64", "shape": [1], "names": None}
    return found


class Table:
    """An episode's columns with its indices: `values` by name, as numpy arrays."""

    def __init__(self, part, number, first, task, fps):
        frames, (done, reward) = np.arange(part.length), part.ends()
        self.part, self.number, self.first, self.length = part, number, first, part.length
        self.values = {**part.columns(), "next.done": done, "next.success": reward > 0, "next.reward": reward,
                       "timestamp": (frames / fps).astype(np.float32), "frame_index": frames,
                       "episode_index": np.full(part.length, number), "index": first + frames, "task_index": np.full(part.length, task)}

    def arrow(self):
        columns = {}
        for name, values in self.values.items():
            if values.dtype.kind == "U":
                columns[name] = pyarrow.array(values.tolist(), pyarrow.string())
            elif values.ndim == 2 and values.shape[1] > 1:
                columns[name] = pyarrow.FixedSizeListArray.from_arrays(pyarrow.array(values.ravel()), values.shape[1])
            else:
                columns[name] = pyarrow.array(values.ravel())
        return pyarrow.table(columns)


def _of(values, axis, shape=None):
    """Statistics over an axis; `shape` of each result."""
    values = np.asarray(values, np.float64)
    found = {"min": values.min(axis), "max": values.max(axis), "mean": values.mean(axis), "std": values.std(axis)}
    found |= {f"q{round(100 * q):02d}": np.quantile(values, q, axis) for q in QUANTILES}
    return {key: np.reshape(value, shape or np.shape(value)).tolist() for key, value in found.items()} | {"count": [len(values)]}


def statistics(table, pictures):
    """Of each column of numbers, and of each camera's pictures on the scale 0 to 1."""
    found = {name: _of(values.reshape(table.length, -1), 0) for name, values in table.values.items() if values.dtype.kind != "U"}
    for camera in pictures.cameras:
        chosen = set(np.linspace(0, table.length - 1, min(SAMPLES, table.length)).astype(int))
        counts, number = np.zeros((3, 256), np.int64), 0
        for number, picture in enumerate(table.part.frames(camera, pictures.size), 1):
            if number - 1 in chosen:
                counts += [np.bincount(picture[:, :, channel].ravel(), minlength=256) for channel in range(3)]
        dataset.demand_all(number, table.part, camera)
        found[picture_key(camera)] = {**_of_counts(counts), "count": [len(chosen)]}
    return found


def _of_counts(counts):
    """As _of(), of the three channels' values 0 to 255 on the scale 0 to 1. `counts` (3, 256): how often each value occurs."""
    values, ranks, total = np.arange(256) / 255.0, counts.cumsum(1), counts[0].sum()

    def at(rank):
        return values[(ranks > rank).argmax(1)]

    mean = counts @ values / total
    found = {"min": at(0), "max": at(total - 1), "mean": mean, "std": np.sqrt((counts * (values - mean[:, None]) ** 2).sum(1) / total)}
    for q in QUANTILES:
        place = q * (total - 1)
        below = int(place)
        found[f"q{round(100 * q):02d}"] = at(below) + (place - below) * (at(min(below + 1, total - 1)) - at(below))
    return {key: value.reshape(3, 1, 1).tolist() for key, value in found.items()}


def _pooled(all_of_one):
    """The statistics of several episodes' together. Quantiles are the mean of the episodes', by their counts."""
    counts = np.array([each["count"][0] for each in all_of_one], np.float64)
    share = (counts / counts.sum()).reshape(-1, *[1] * np.ndim(all_of_one[0]["mean"]))
    stacked = {key: np.array([each[key] for each in all_of_one]) for key in all_of_one[0] if key != "count"}
    mean = (share * stacked["mean"]).sum(0)
    spread = np.sqrt((share * (stacked["std"] ** 2 + (stacked["mean"] - mean) ** 2)).sum(0))
    found = {key: (share * values).sum(0) for key, values in stacked.items()}
    found |= {"min": stacked["min"].min(0), "max": stacked["max"].max(0), "mean": mean, "std": spread}
    return {key: value.tolist() for key, value in found.items()} | {"count": [int(counts.sum())]}


def _json(path, value):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(value, indent=4) + "\n", encoding="utf-8")


def _lines(path, values):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("".join(json.dumps(value) + "\n" for value in values), encoding="utf-8")


def _copy_video(part, camera, path):
    path.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(part.video(camera), path)


def _parquet(path, *tables):
    """One file. Each table is a row group, as lerobot itself writes its episodes: a reader gets one without the others."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with pyarrow.parquet.ParquetWriter(path, tables[0].schema, compression="snappy") as file:
        for table in tables:
            file.write_table(table)


def _described(pictures, table):
    """For a worker of the pool."""
    return table, statistics(table, pictures)


class _Writer:
    def __init__(self, parts, path, fps, pictures, jobs):
        self.path, self.fps, self.pictures, self.parts, self.jobs = path, fps, pictures, parts, jobs
        self.tasks = sorted({part.facts["task"] for part in parts})
        self.total = sum(part.length for part in parts)

    def _tables(self):
        first = 0
        for number, part in enumerate(self.parts):
            yield Table(part, number, first, self.tasks.index(part.facts["task"]), self.fps)
            first += part.length

    def tables(self):
        """Each episode's table and statistics, in order, by all cores."""
        bar = Bar(len(self.parts), "written")
        with cancelling(concurrent.futures.ProcessPoolExecutor(self.jobs, initializer=dataset.end_with_parent)) as pool:
            for table, found in dataset.ahead(pool, functools.partial(_described, self.pictures), self._tables(), 2 * self.jobs):
                yield table, found
                bar.step(table.part.facts["session"])

    def info(self, version, **more):
        data, video = PATHS[version]
        ranges = {"train": f"0:{len(self.parts)}", **{name: f"{a}:{b}" for name, (a, b) in dataset.splits(self.parts).items()}}
        _json(self.path / "meta/info.json", {
            "codebase_version": f"v{version}", "robot_type": ROBOT, "total_episodes": len(self.parts), "total_frames": self.total,
            "total_tasks": len(self.tasks), **more, "chunks_size": CHUNK, "fps": self.fps, "splits": ranges, "data_path": data,
            "video_path": video if self.pictures.cameras else None, "features": features(self.fps, self.pictures, self.parts[0])})
        _lines(self.path / "meta/raven2_sessions.jsonl",
               [{"episode_index": number, **part.facts} for number, part in enumerate(self.parts)])

    def write_2_1(self):
        data, video = PATHS["2.1"]
        entries, stats = [], []
        for table, found in self.tables():
            chunk = table.number // CHUNK
            _parquet(self.path / data.format(episode_chunk=chunk, episode_index=table.number), table.arrow())
            for camera in self.pictures.cameras:
                _copy_video(table.part, camera, self.path / video.format(episode_chunk=chunk, episode_index=table.number,
                                                                       video_key=picture_key(camera)))
            entries.append({"episode_index": table.number, "tasks": [table.part.facts["task"]], "length": table.length})
            kept = {name: {key: each[key] for key in ("min", "max", "mean", "std", "count")} for name, each in found.items()}
            stats.append({"episode_index": table.number, "stats": kept})
        _lines(self.path / "meta/episodes.jsonl", entries)
        _lines(self.path / "meta/episodes_stats.jsonl", stats)
        _lines(self.path / "meta/tasks.jsonl", [{"task_index": i, "task": task} for i, task in enumerate(self.tasks)])
        count = len(self.parts)
        self.info("2.1", total_videos=count * len(self.pictures.cameras), total_chunks=-(-count // CHUNK))

    def write_3_0(self):
        data, video = PATHS["3.0"]
        entries, every, waiting, files = [], [], [], 0
        for table, found in self.tables():
            waiting.append(table.arrow())
            entry = {"episode_index": table.number, "tasks": [table.part.facts["task"]], "length": table.length,
                     "data/chunk_index": files // CHUNK, "data/file_index": files % CHUNK,
                     "dataset_from_index": table.first, "dataset_to_index": table.first + table.length}
            for camera in self.pictures.cameras:
                key, place = picture_key(camera), {"chunk_index": table.number // CHUNK, "file_index": table.number % CHUNK}
                _copy_video(table.part, camera, self.path / video.format(video_key=key, **place))
                entry |= {f"videos/{key}/{name}": value for name, value in place.items()}
                entry |= {f"videos/{key}/from_timestamp": 0.0, f"videos/{key}/to_timestamp": table.length / self.fps}
            entry |= {f"stats/{name}/{key}": value for name, each in found.items() for key, value in each.items()}
            entries.append({**entry, "meta/episodes/chunk_index": 0, "meta/episodes/file_index": 0})
            every.append(found)
            if sum(each.nbytes for each in waiting) >= FILE_BYTES or table.number + 1 == len(self.parts):
                _parquet(self.path / data.format(chunk_index=files // CHUNK, file_index=files % CHUNK), *waiting)
                waiting, files = [], files + 1
        _parquet(self.path / "meta/episodes/chunk-000/file-000.parquet", pyarrow.Table.from_pylist(entries))
        _parquet(self.path / "meta/tasks.parquet", _tasks(self.tasks))
        _json(self.path / "meta/stats.json", {name: _pooled([each[name] for each in every]) for name in every[0]})
        self.info("3.0", data_files_size_in_mb=FILE_BYTES // 2**20, video_files_size_in_mb=200)


def _tasks(tasks):
    """The table whose index, for pandas, is the task's text."""
    def column(name, kind, numpy_kind):
        return {"name": name, "field_name": name, "pandas_type": kind, "numpy_type": numpy_kind, "metadata": None}

    table = pyarrow.table({"task_index": pyarrow.array(range(len(tasks)), pyarrow.int64()), "task": pyarrow.array(tasks)})
    described = {"index_columns": ["task"], "column_indexes": [], "pandas_version": "1.5.3", "creator": {"library": "pyarrow", "version": pyarrow.__version__},
                 "columns": [column("task_index", "int64", "int64"), column("task", "unicode", "object")]}
    return table.replace_schema_metadata({b"pandas": json.dumps(described).encode()})


def write(parts, path, fps, pictures, jobs, version):
    writer = _Writer(parts, path, fps, pictures, jobs)
    {"2.1": writer.write_2_1, "3.0": writer.write_3_0}[version]()
