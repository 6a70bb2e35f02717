"""The data sets for learning of export_dataset and make_dataset: their options, and the export itself."""

import argparse
import functools
import os
import sys

import raven2_session

FORMATS = {"hdf5": "dataset.hdf5", "lerobot": "dataset"}  # format: default output
LEROBOT_VERSIONS = ("2.1", "3.0")
NO_PYARROW = ("the format lerobot needs the Python module {}. Debian has no pyarrow. In an environment of your own: "
              "/usr/bin/python3 -m venv --system-site-packages ENV; ENV/bin/pip install pyarrow==18.1.0; . ENV/bin/activate; then the same command again")


def in_environment():
    """Starts again in the activated Python environment, which may have pyarrow. Without one: returns."""
    environment = os.environ.get("VIRTUAL_ENV", "")
    python = os.path.join(environment, "bin/python3")
    if environment and os.path.exists(python) and os.path.realpath(sys.prefix) != os.path.realpath(environment):
        os.execv(python, [python, os.path.realpath(sys.argv[0]), *sys.argv[1:]])


def writer(options):
    """write(parts, path, fps, pictures, jobs) of the format. @throw SessionError if its library is missing."""
    if options.format == "hdf5":
        from raven2_exports import hdf5

        return hdf5.write
    try:
        from raven2_exports import lerobot
    except ImportError as error:
        in_environment()
        raise raven2_session.SessionError(NO_PYARROW.format(error.name)) from None
    return functools.partial(lerobot.write, version=options.lerobot)


def export(options):
    write = writer(options)
    import raven2_lockstep
    from raven2_exports import dataset

    pictures = dataset.Pictures(options.cameras, options.size, raven2_lockstep.program("render_session"))
    output = options.output or FORMATS[options.format]
    parts = dataset.export(options.directories, output, functools.partial(write, fps=options.fps, pictures=pictures, jobs=options.jobs),
                           options.fps, pictures, options.jobs)
    shares = ", ".join(f"{last - first} {name}" for name, (first, last) in dataset.splits(parts).items())
    return f"{output}: {len(parts)} episodes ({shares}), {sum(part.length for part in parts)} frames"


def size_of(text):
    width, _, height = text.partition("x")
    if not (width.isdigit() and height.isdigit() and all(64 <= int(n) <= 4096 and int(n) % 2 == 0 for n in (width, height))):
        raise argparse.ArgumentTypeError(f"{text}: expected WIDTHxHEIGHT, each even and 64 to 4096")
    return int(width), int(height)


def names_of(text):
    names = [name for name in text.split(",") if name]
    if len(set(names)) != len(names):
        raise argparse.ArgumentTypeError(f"{text}: a name is given twice")
    return names


def number_from(least, most, text):
    if not text.isdigit() or not least <= int(text) <= most:
        raise argparse.ArgumentTypeError(f"{text}: expected a whole number from {least} to {most}")
    return int(text)


def add_options(made):
    """The options of data sets, also for make_dataset."""
    group = made.add_argument_group("hdf5 and lerobot")
    group.add_argument("--cameras", metavar="A,B", type=names_of, default=[], help="cameras of config/render.yaml (default: no pictures)")
    group.add_argument("--size", metavar="WxH", type=size_of, default=(320, 240), help="size of the pictures (default: 320x240)")
    group.add_argument("--fps", metavar="N", type=functools.partial(number_from, 1, 120), default=30, help="frames per second, 1 to 120 (default: 30)")
    group.add_argument("--lerobot", metavar="V", choices=LEROBOT_VERSIONS, default=LEROBOT_VERSIONS[-1],
                       help="version of the format lerobot: 2.1, or 3.0 (default)")
    group.add_argument("--jobs", metavar="N", type=functools.partial(number_from, 1, 1024), default=len(os.sched_getaffinity(0)),
                       help="sessions at the same time (default: all processors)")
