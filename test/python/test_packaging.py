"""The files for the Debian package, the container and a fresh system agree. scripts/check_package tests the package."""

import pathlib
import re
import shutil
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRIPTS = ROOT / "scripts"


def text(name):
    return (ROOT / name).read_text()


def packages(*kind):
    result = subprocess.run([SCRIPTS / "install_dependencies", "--list", *kind], capture_output=True, text=True,
                            timeout=60, check=True)
    return result.stdout.split()


def test_the_list_of_packages_is_that_of_its_kinds():
    assert packages() == packages("build") + packages("run") + packages("test")
    assert "ffmpeg" in packages("run") and "libode-dev" in packages("build") and "stress-ng" in packages("test")
    assert all(re.fullmatch(r"[a-z0-9][a-z0-9+.-]+", name) for name in packages())


@pytest.mark.parametrize("knows", [False, True])
def test_osmesa_is_installed_only_where_the_release_has_it(tmp_path, knows):
    """Everything else is there. The fake apt-get prints a word that shows its call."""
    there = "\n".join(f"ii  {name}" for kind in ("build", "run", "test") for name in packages(kind) if name != "libosmesa6")
    for name, does in (("dpkg-query", f"echo '{there}'"), ("apt-get", "echo called $*"), ("apt-cache", "true" if knows else "false")):
        (tmp_path / name).write_text(f"#!/bin/sh\n{does}\n")
        (tmp_path / name).chmod(0o755)
    result = subprocess.run([SCRIPTS / "install_dependencies"], capture_output=True, text=True, timeout=60, check=False,
                            env={"PATH": f"{tmp_path}:/usr/bin:/bin"})
    assert ("libosmesa6" in result.stdout) == knows and (result.returncode == 0 or knows), result


def test_another_kind_and_another_option_are_refused():
    for words in (["--list", "all"], ["--nonsense"]):
        result = subprocess.run([SCRIPTS / "install_dependencies", *words], capture_output=True, text=True, timeout=60,
                                check=False)
        assert result.returncode == 1 and result.stderr.startswith("E: ") and result.stdout == ""


def test_catkin_lint_finds_neither_errors_nor_warnings():
    """Runs offline. The next test checks the names that are not ROS packages."""
    result = subprocess.run(["catkin_lint", "--offline", "-W1", ROOT], capture_output=True, text=True, timeout=120,
                            check=False)
    assert result.returncode == 0 and "found 0 problems" in result.stderr, result.stdout + result.stderr


def test_package_xml_names_nothing_that_rosdep_does_not_know():
    """Known keys that are not ROS packages are in rosdep's base.yaml and python.yaml (ros/rosdistro, 2026). `ompl` is
    an exception: it is a package of ROS noetic."""
    known = set("assimp cli11 eigen ffmpeg gtest iproute2 libccd-dev libconsole-bridge-dev libfcl-dev libosmesa6-dev libsodium-dev libturbojpeg "
                "liburdfdom-dev liburdfdom-tools libx11-dev libzstd-dev nlohmann-json-dev ompl opende opengl pybind11-dev python3-aiohttp python3-h5py python3-matplotlib python3-numpy python3-pandas "
                "python3-psutil python3-pytest python3-yaml stress-ng xvfb yaml-cpp zlib".split())
    ros = set("actionlib actionlib_msgs catkin diagnostic_msgs genmsg genpy geometry_msgs message_generation "
              "message_runtime nav_msgs rosbag rosbag_storage rosbash roscpp rosgraph_msgs roslaunch rosmsg rospy rostest rostopic sensor_msgs "
              "std_msgs std_srvs tf2_msgs topic_tools trajectory_msgs visualization_msgs".split())
    keys = re.findall(r"<(?:\w+_)?depend>([^<]+)<", text("package.xml"))
    assert sorted(set(keys) - known - ros) == []
    assert len(keys) == len(set(keys)), "no key is there twice"


def test_nothing_that_runs_needs_a_development_package():
    assert [name for name in packages("run") if name.endswith("-dev")] == []


def test_a_session_needs_nothing_that_is_for_tests_alone(tmp_path):
    """The fake dpkg-query knows the packages of all other kinds. The fake apt-get prints a word that shows its call."""
    there = "\n".join(f"ii  {name}" for name in packages("build") + packages("run"))
    for name, said in (("dpkg-query", there), ("apt-get", "called")):
        (tmp_path / name).write_text(f"#!/bin/sh\necho '{said}'\n")
        (tmp_path / name).chmod(0o755)
    for option, called in (("--session", False), (None, True)):
        words = [SCRIPTS / "install_dependencies", *([option] if option else [])]
        result = subprocess.run(words, capture_output=True, text=True, timeout=60, check=False,
                                env={"PATH": f"{tmp_path}:/usr/bin:/bin"})
        assert ("called" in result.stdout or "not root" in result.stderr + result.stdout) == called, option
    assert "scripts/install_dependencies\" --session" in text("scripts/run")


def test_what_is_missing_is_told_without_installing(tmp_path):
    """The fake dpkg-query knows one package."""
    query = tmp_path / "dpkg-query"
    query.write_text("#!/bin/sh\necho 'ii  ffmpeg'\n")
    query.chmod(0o755)
    result = subprocess.run([SCRIPTS / "install_dependencies", "--missing"], capture_output=True, text=True, timeout=60,
                            check=False, env={"PATH": f"{tmp_path}:/usr/bin:/bin"})
    assert result.returncode == 1
    assert sorted(result.stdout.split() + ["ffmpeg"]) == sorted(packages())


def test_a_package_that_is_held_is_installed(tmp_path):
    """The fake dpkg-query answers as after `apt-mark hold ffmpeg`; chromium was removed, and its settings are left."""
    there = "\n".join({"ffmpeg": "hi ", "chromium": "rc "}.get(name, "ii ") + name for name in packages())
    query = tmp_path / "dpkg-query"
    query.write_text(f"#!/bin/sh\necho '{there}'\n")
    query.chmod(0o755)
    result = subprocess.run([SCRIPTS / "install_dependencies", "--missing"], capture_output=True, text=True, timeout=60,
                            check=False, env={"PATH": f"{tmp_path}:/usr/bin:/bin"})
    assert result.stdout.split() == ["chromium"], result


def test_versions_are_one():
    version = re.search(r"<version>(.*?)</version>", text("package.xml")).group(1)
    assert re.search(rf"project\(raven2_trainer VERSION {re.escape(version)} ", text("CMakeLists.txt"))
    assert text("packaging/changelog").startswith(f"raven2-trainer ({version}) ")


def test_the_copyright_is_the_licence():
    """Compares them word by word: the copyright has Debian's line format."""
    body = text("packaging/copyright").split("License: BSD-3-Clause\n")[2]
    words = [word for line in body.splitlines() if line != " ." for word in line.split()]
    licence = text("LICENSE")
    assert words == licence[licence.index("Redistribution and use"):].split()
    assert "2026, the raven2_trainer authors" in text("packaging/copyright") and "2026, the raven2_trainer" in licence


@pytest.mark.skipif(not shutil.which("dpkg-parsechangelog"), reason="dpkg-dev is not installed")
def test_dpkg_reads_the_changelog():
    result = subprocess.run(["dpkg-parsechangelog", "-l", ROOT / "packaging/changelog", "--all"], capture_output=True,
                            text=True, timeout=60, check=False)
    assert result.returncode == 0 and result.stderr == "" and "Source: raven2-trainer" in result.stdout


LISTS = """cmake_minimum_required(VERSION 3.16)
project(raven2_trainer VERSION 0.1.0 LANGUAGES NONE)
include(packaging/debian.cmake)
"""


@pytest.fixture
def installed_documentation(tmp_path):
    """The documentation that packaging/debian.cmake installs in addition to the programs."""
    source = tmp_path / "source"
    for name in ("doc", "packaging", "scripts"):
        shutil.copytree(ROOT / name, source / name)
    for name in (*(path.name for path in ROOT.glob("*.md")), "urdf/README.md"):
        (source / name).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / name, source / name)
    (source / "doc/examples/__pycache__").mkdir(exist_ok=True)  # as in a source tree that has been used
    (source / "CMakeLists.txt").write_text(LISTS)
    for command in (["cmake", "-S", source, "-B", tmp_path / "build", "-DCMAKE_INSTALL_PREFIX=/usr"],
                    ["cmake", "--install", tmp_path / "build"]):
        done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False,
                              env={"PATH": "/usr/bin:/bin", "DESTDIR": str(tmp_path / "root")})
        assert done.returncode == 0, done.stderr
    return tmp_path / "root/usr/share/doc/raven2-trainer"


def test_links_of_the_installed_documentation_lead_somewhere(installed_documentation):
    for name in ("README.md", "doc/index.md", "doc/examples/itp_master.py", "urdf/README.md", "copyright", "changelog.gz"):
        assert (installed_documentation / name).is_file(), name
    assert list(installed_documentation.rglob("__pycache__")) == []
    done = subprocess.run([SCRIPTS / "make_site", "--check", installed_documentation], capture_output=True, text=True, timeout=60,
                          check=False)
    assert done.returncode == 0, done.stderr


def installed_scripts():
    return re.findall(r"scripts/([\w.]+)", "".join(re.findall(r"install\((?:PROGRAMS|FILES|DIRECTORY) (scripts/[^)]*)\)",
                                                              text("CMakeLists.txt"))))


def test_installed_scripts_find_what_they_import(tmp_path):
    """All installed scripts are in one folder, as in the package."""
    names = installed_scripts()
    assert {"doctor", "raven2_doctor", "session_report"} <= set(names)
    for name in names:
        (shutil.copytree if (SCRIPTS / name).is_dir() else shutil.copy)(SCRIPTS / name, tmp_path / name)
    programs = [path for path in tmp_path.iterdir() if path.is_file() and path.stat().st_mode & 0o100]
    assert len(programs) >= 10
    for program in programs:
        result = subprocess.run([program, "--help"], capture_output=True, text=True, timeout=120, check=False,
                                env={"PATH": "/usr/bin:/bin", "HOME": str(tmp_path)})
        assert result.returncode == 0, f"{program.name}: {result.stderr}"


def test_the_container_runs_what_the_readme_tells():
    lines = [line for line in text("Containerfile").splitlines() if line and not line.startswith("#")]
    assert lines[0].startswith("FROM ") and lines[0].endswith("debian:12")
    for named in re.findall(r"scripts/\w+(?:\.sh)?", "\n".join(lines)):
        assert (ROOT / named).is_file(), named
    assert lines[-1] == 'CMD ["scripts/run"]'
    commands = re.findall(r"^(scripts/\w+) ", text("README.md").split("\n## Try it\n")[1].split("\n## ")[0], re.M)
    assert commands == ["scripts/run", "scripts/test", "scripts/station"]
    started = re.findall(r"^#   podman run [^#\n]* raven2_trainer\b *(scripts/\w+)?", text("Containerfile"), re.M)
    assert {name or "scripts/run" for name in started} == {"scripts/run", "scripts/test"}


def test_building_the_container_is_a_session():
    """The container's last build step is README's first command, with valid additional options."""
    steps = [line for line in text("Containerfile").splitlines() if line.startswith("RUN ")]
    match = re.fullmatch(r"RUN scripts/run( --duration \d+) --output (\S+) && rm -r \2", steps[-1])
    assert match, steps[-1]
    told = subprocess.run([SCRIPTS / "run", "--help"], capture_output=True, text=True, timeout=60, check=True).stdout
    assert "--duration S" in told and "--output DIR" in told


def test_the_container_takes_what_it_needs_of_the_source():
    ignored = text(".dockerignore").split()
    assert {"build", "sessions"} <= set(ignored) and "scripts" not in ignored


@pytest.fixture
def fresh(tmp_path):
    """Starts check_fresh_debian with a fake mmdebstrap, which makes a folder and ends with the given status."""
    if subprocess.run(["git", "-C", ROOT, "rev-parse"], capture_output=True, timeout=60, check=False).returncode:
        pytest.skip("no clone: check_fresh_debian has no commit to look at")
    made = 'for word; do case $word in */system) mkdir -p "$word/etc" ;; esac; done\necho "E: no mirror" >&2\nexit %d\n'

    def start(status):
        for name, lines in (("id", "echo 0\n"), ("chroot", "exit 1\n"), ("mmdebstrap", made % status)):
            (tmp_path / name).write_text("#!/bin/sh\n" + lines)
            (tmp_path / name).chmod(0o755)
        return subprocess.run([SCRIPTS / "check_fresh_debian", tmp_path / f"fresh{status}", "--until", "system"],
                              capture_output=True, text=True, timeout=60, check=False,
                              env={"PATH": f"{tmp_path}:/usr/bin:/bin", "HOME": str(tmp_path)})
    return start


def test_a_system_that_could_not_be_made_is_no_fresh_system(fresh):
    """The step fails when mmdebstrap fails, although the later commands of the step succeed."""
    well, failed = fresh(0), fresh(25)
    assert well.returncode == 0 and "until system, as asked for" in well.stderr, well.stderr
    assert failed.returncode == 1 and "system failed" in failed.stderr and "E: no mirror" in failed.stderr, failed.stderr


def test_the_stages_of_a_full_test_are_told_everywhere():
    source = text("scripts/test")
    stages = re.search(r"^stages=\((.*)\)$", source, re.M).group(1).split()
    assert "package" in stages
    refused = subprocess.run([SCRIPTS / "test", "--full", "--only", "nonsense"], capture_output=True, text=True, timeout=60,
                             check=False)
    assert refused.returncode == 1 and f"one of {', '.join(stages)}, debian13, learn\n" in refused.stderr
    assert f"of --full: {', '.join(stages[:-1])} or {stages[-1]}. Or one that --full leaves out: debian13," in source
    assert [name for name in (*stages, "debian13", "learn") if not re.search(rf"^ +{name}\) ", source, re.M)] == []
    assert all(name in re.search(r"`--full --only asan` \((.*)\)", text("CONTRIBUTING.md")).group(1) for name in stages if name != "asan")


def test_checks_refuse_what_they_cannot_do(tmp_path):
    """The checks reject wrong arguments before they build or download anything."""
    for words, says in ((["check_package", "--nonsense"], "unknown option"),
                        (["check_package", "--deb", tmp_path / "none.deb"], "cannot be read"),
                        (["check_fresh_debian"], "see --help"),
                        (["check_fresh_debian", tmp_path], "exists"),
                        (["check_fresh_debian", tmp_path / "new", "--until", "never"], "--until takes one of")):
        result = subprocess.run([SCRIPTS / words[0], *words[1:]], capture_output=True, text=True, timeout=60, check=False)
        assert result.returncode == 1 and says in result.stderr, (words, result.stderr)
    assert not (tmp_path / "new").exists()
