"""A data set as one HDF5 file, in robomimic's layout: data/demo_N with obs, actions, rewards, dones; mask/SPLIT."""

import concurrent.futures
import json
import zlib

import h5py
import numpy as np
from raven2_exports import dataset, episode
from raven2_progress import Bar, cancelling

STRING = h5py.string_dtype("utf-8")
LEVEL = 4  # of zlib


def _scale(parts):
    """The largest command of each column in all episodes; 1 for a column that is 0 throughout."""
    largest = np.max([np.abs(part.columns()["action"]).max(0) for part in parts], axis=0)
    return np.where(largest > 0, largest, 1).astype(np.float32)


def _write_demo(group, part, fps, scale):
    columns = part.columns()
    group.attrs["num_samples"] = part.length
    group.attrs["task"] = part.facts["task"]
    for name in ("session", "exercise", "split"):
        group.attrs[name] = part.facts[name]
    group.attrs["seed"] = part.facts["seed"]
    group.attrs["hazards"] = json.dumps(part.facts["hazards"])
    group.attrs["object_names"] = json.dumps(part.facts["objects"])
    for name, values in columns.items():
        place = {"action": "commands"}.get(name, name.replace("observation.", "obs/").replace("truth.", "truth/"))
        is_text = values.dtype.kind == "U"
        stored = group.create_dataset(place, data=values.astype(object) if is_text else values, dtype=STRING if is_text else None,
                                      compression="gzip", compression_opts=LEVEL)
        names, unit, meaning = episode.COLUMNS[name]
        stored.attrs["unit"], stored.attrs["meaning"] = unit, meaning
        if names:
            stored.attrs["names"] = json.dumps(names)
    actions = group.create_dataset("actions", data=columns["action"] / scale, compression="gzip", compression_opts=LEVEL)
    actions.attrs["scale"], actions.attrs["meaning"] = scale, "commands / scale: -1 to 1, as robomimic's policies have it"
    done, reward = part.ends()
    group.create_dataset("dones", data=done.astype(np.int64))
    group.create_dataset("rewards", data=reward)
    group.create_dataset("states", (part.length, 0), np.float64)  # MuJoCo's; of other simulators the layout wants it empty
    group.create_dataset("timestamps", data=np.arange(part.length) / fps)


def _write_pictures(group, part, pictures, pool, jobs):
    """Compressed by all cores, each picture a chunk: HDF5 itself compresses with one."""
    shape = (*pictures.size[::-1], 3)
    for camera in pictures.cameras:
        stored = group.create_dataset(f"obs/{camera}_image", (part.length, *shape), np.uint8, chunks=(1, *shape), compression="gzip",
                                      compression_opts=LEVEL)
        packed = dataset.ahead(pool, lambda picture: zlib.compress(picture, LEVEL), part.frames(camera, pictures.size), 2 * jobs)
        number = -1
        for number, chunk in enumerate(packed):
            if number == part.length:
                break
            stored.id.write_direct_chunk((number, 0, 0, 0), chunk)
        dataset.demand_all(number + 1, part, camera)


def _write_next(group):
    """next_obs, which offline learners read: obs of the next frame, at the end of the last one. Views, which take no space."""
    for name, stored in group["obs"].items():
        layout, source = h5py.VirtualLayout(stored.shape, stored.dtype), h5py.VirtualSource(stored)
        layout[:-1] = source[1:]
        layout[-1:] = source[-1:]
        group.create_virtual_dataset(f"next_obs/{name}", layout)


def write(parts, path, fps, pictures, jobs):
    bar = Bar(len(parts), "written")
    with h5py.File(path, "w") as file, cancelling(concurrent.futures.ThreadPoolExecutor(jobs)) as pool:
        data, scale = file.create_group("data"), _scale(parts)
        data.attrs["total"] = sum(part.length for part in parts)
        data.attrs["fps"] = fps
        data.attrs["env_args"] = json.dumps({"env_name": "raven2_trainer", "env_version": "1", "type": 2, "env_kwargs": {}})
        for number, part in enumerate(parts):
            demo = data.create_group(f"demo_{number}")
            _write_demo(demo, part, fps, scale)
            _write_pictures(demo, part, pictures, pool, jobs)
            _write_next(demo)
            bar.step(part.facts["session"])
        for split in episode.SPLITS:
            names = [f"demo_{number}" for number, part in enumerate(parts) if part.facts["split"] == split]
            if names:
                file.create_dataset(f"mask/{split}", data=np.array(names, "S"))
