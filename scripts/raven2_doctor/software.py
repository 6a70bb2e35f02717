"""Packages, Python, the build, ffmpeg, OpenGL, a display."""

import os
import pathlib
import re
import socket
import sys

from .findings import fail, last_line, ok, text_of, warn

SOURCES = ("src", "include", "CMakeLists.txt")
PROBE = pathlib.Path(__file__).with_name("draw_probe.py")
DEBIAN = pathlib.Path("/etc/debian_version")


def system(machine):
    version = DEBIAN.read_text().strip() if DEBIAN.exists() else ""
    if version.partition(".")[0] in ("12", "13"):
        return [ok(f"Debian {version}")]
    name = f"Debian {version}" if version else "not Debian"
    return [warn(f"{name}; built and tested on Debian 12 and 13 alone", "use one of them, or the Containerfile")]


def packages(machine):
    if machine.root is None:
        return [ok("installed as a package: dpkg keeps what it depends on")]
    script = machine.root / "scripts/install_dependencies"
    status, text = machine.run(script, "--missing")
    if status == 0:
        return [ok("all packages of scripts/install_dependencies are installed")]
    missing = text.split()
    if status != 1 or not missing or not all(re.fullmatch(r"[a-z0-9][a-z0-9+.-]*", name) for name in missing):
        return [fail(f"scripts/install_dependencies: {last_line(text)}", "use Debian 12 or 13: it asks dpkg-query")]
    for_tests = set(machine.run(script, "--list", "test")[1].split())
    needed = [name for name in missing if name not in for_tests]
    remedy = f"as root: {script}"
    found = [fail("missing packages: " + " ".join(needed), remedy)] if needed else []
    rest = [name for name in missing if name in for_tests]
    return found + ([warn("missing packages, of the tests alone: " + " ".join(rest), remedy)] if rest else [])


def python(machine):
    """A second Python ahead of Debian's has no catkin, no rospy and another numpy."""
    found = []
    first = machine.which("python3")
    if first is None or str(pathlib.Path(first).parent) not in ("/usr/bin", "/bin"):
        found.append(warn(f"python3 in PATH is {first or 'not there'}: it shadows Debian's, for which ROS is packaged",
                          "put /usr/bin first in PATH, and configure with -DPYTHON_EXECUTABLE=/usr/bin/python3"))
    for name in ("PYTHONHOME", "VIRTUAL_ENV", "CONDA_PREFIX"):
        if machine.environ.get(name):
            found.append(warn(f"{name} is {machine.environ[name]}: scripts of /usr/bin/python3 may find other modules",
                              f"unset {name}, or leave that environment"))
    status, text = machine.run("/usr/bin/python3", "-c", "import numpy, yaml, matplotlib")
    if status != 0:
        found.append(fail(f"/usr/bin/python3: {last_line(text)}",
                          "as root: apt-get install python3-numpy python3-yaml python3-matplotlib"))
    return found or [ok(f"Debian's Python {sys.version.split()[0]}, with numpy, yaml and matplotlib")]


def newest(folder):
    """Time and path of the newest source below it."""
    paths = [path for name in SOURCES for path in ([folder / name] if (folder / name).is_file() else
                                                   (folder / name).rglob("*.*"))]
    return max(((path.stat().st_mtime, path) for path in paths if path.is_file()), default=(0.0, folder))


def configured_python(machine):
    cache = machine.build / "CMakeCache.txt"
    used = re.search(r"^PYTHON_EXECUTABLE:\w+=(.*)$", cache.read_text(), re.MULTILINE) if cache.exists() else None
    if used is None or used.group(1).startswith("/usr/bin/"):
        return []
    return [fail(f"{machine.build} was configured for {used.group(1)}",
                 f"remove {machine.build}, then scripts/run, or cmake with -DPYTHON_EXECUTABLE=/usr/bin/python3")]


def build(machine):
    remedy = f"cmake --build {machine.build} --target programs (scripts/run does)"
    simulator = machine.program("simulator")
    if simulator is None:
        return [fail(f"not built: no simulator in {machine.build or 'the package'}",
                     remedy if machine.build else "install the package again")]
    status, text = machine.run(simulator, "--version")
    if status != 0:
        return [fail(f"simulator does not start: {last_line(text)}", remedy)]
    version = text.strip()
    if machine.root is None:
        return [ok(f"version {version}")]
    return versions(machine, version, remedy) + configured_python(machine)


def versions(machine, version, remedy):
    wanted = re.search(r"<version>(.*?)</version>", (machine.root / "package.xml").read_text()).group(1)
    if version != wanted:
        return [fail(f"built is version {version}, the source is {wanted}", remedy)]
    time, path = newest(machine.root)
    if time > machine.program("simulator").stat().st_mtime:
        return [warn(f"simulator is older than {path.relative_to(machine.root)}", remedy)]
    return [ok(f"version {version}, built after the last change of its source")]


def ffmpeg(machine):
    if machine.which("ffmpeg") is None:
        return [fail("no ffmpeg: no videos, no stills in reports", "as root: apt-get install ffmpeg")]
    status, text = machine.run("ffmpeg", "-hide_banner", "-encoders")
    if status != 0 or "libx264" not in text:
        return [fail("ffmpeg has no encoder libx264", "as root: apt-get install ffmpeg (Debian's has it)")]
    return [ok("ffmpeg with libx264")]


def opengl(machine):
    """One picture, as the daemon draws, in memory: with OSMesa or EGL. In a separate process, which may crash."""
    status, text = machine.run("/usr/bin/python3", PROBE)
    if status != 0:
        return [fail(f"OpenGL draws nothing: {last_line(text)}",
                     "as root: apt-get install --reinstall libosmesa6, or libegl1; unset RAVEN2_TRAINER_GL, LIBGL_DRIVERS_PATH "
                     "and GALLIUM_DRIVER")]
    return [ok(f"OpenGL draws: {last_line(text)}")]


def display(machine):
    """Needed by console_view alone."""
    name = machine.environ.get("DISPLAY", "")
    if not name:
        return [warn("no X display: console_view cannot open a window; all else runs", "set DISPLAY, or use ssh -X")]
    host, _, number = name.rpartition(":")
    number = number.split(".")[0]
    if not number.isdigit() or not answers(host, int(number)):
        return [warn(f"DISPLAY is {name}, where no X server answers: console_view cannot open a window",
                     "start one, or set DISPLAY to one that runs")]
    return [ok(f"an X server answers at {name}")]


def answers(host, number):
    is_local = host in ("", "unix") or os.path.sep in host
    family = socket.AF_UNIX if is_local else socket.AF_INET
    address = f"/tmp/.X11-unix/X{number}" if is_local else (host, 6000 + number)
    with socket.socket(family, socket.SOCK_STREAM) as link:
        link.settimeout(1.0)
        try:
            link.connect(address)
        except OSError:
            return False
    return True


def configuration(machine):
    """The files that the root file names are there; the daemon says the rest, with file and line."""
    if not machine.config.is_file():
        return [fail(f"{machine.config} is not there", "name one with --config, or install the package again")]
    missing = [key for key in ("network", "runtime", "model", "arms", "render")
               if not machine.section(key).is_file()]
    if missing:
        return [fail(f"{machine.config} names files that are not there: {', '.join(missing)}",
                     f"copy them from the packaged config/ to {machine.config.parent}")]
    return [ok(f"{machine.config}, network {text_of(machine.config, 'network', 'network.yaml')}")]
