"""How the arguments of training.launch and hardware.launch change the programs' command lines. Starts nothing."""

import os
import pathlib
import shlex

import pytest

roslaunch_config = pytest.importorskip("roslaunch.config")

LAUNCH = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "launch", "training.launch")
HARDWARE = os.path.join(os.path.dirname(LAUNCH), "hardware.launch")
STATION = os.path.join(os.path.dirname(LAUNCH), "station.launch")


@pytest.fixture(autouse=True)
def fixture_package(monkeypatch):
    """$(find raven2_trainer) is this source tree, whatever else is installed."""
    monkeypatch.setenv("ROS_PACKAGE_PATH", os.path.dirname(os.path.dirname(LAUNCH)))
    monkeypatch.setenv("HOME", "/nowhere")


def options(*arguments, more=()):
    """{node: {option: value}} of training.launch."""
    seen = nodes(LAUNCH, *arguments)
    assert set(seen) == {"virtual_raven", "master_console", "simulator", *more}
    return seen


def nodes(launch, *arguments):
    loaded = roslaunch_config.load_config_default([(launch, list(arguments))], None, verbose=False)
    assert not loaded.config_errors
    words = {node.type: [word for word in shlex.split(node.args) if word != "--strict"] for node in loaded.nodes}
    return {name: dict(zip(w[::2], w[1::2])) for name, w in words.items()}


def chosen(of):
    return [of["--" + key] for key in ("exercise", "drill", "hazard")]


def test_without_an_exercise_a_hazard_is_armed():
    for of in options().values():
        assert chosen(of) == ["none", "none", "sudden_jump"]


def test_an_exercise_runs_into_none_by_itself_and_all_programs_have_it():
    seen = options("exercise:=peg_transfer", "motion:=expert")
    for of in seen.values():
        assert chosen(of) == ["peg_transfer", "none", "none"]
    assert seen["master_console"]["--motion"] == seen["simulator"]["--motion-label"] == "expert"


def test_all_programs_have_the_seed_and_the_arms_contacts():
    seen = options("seed:=7", "arm_contacts:=off", "impair:=wifi", more=["impair"])
    assert {of["--seed"] for of in seen.values()} == {"7"}
    assert {of["--arm-contacts"] for name, of in seen.items() if name != "impair"} == {"off"}
    seen = nodes(HARDWARE, "robot_host:=192.168.7.2", "seed:=7", "arm_contacts:=off", "console:=true")
    assert set(seen) == {"master_console", "simulator"}
    assert {(of["--seed"], of["--arm-contacts"]) for of in seen.values()} == {("7", "off")}


def test_what_is_asked_for_counts():
    for of in options("exercise:=peg_transfer", "drill:=own", "hazard:=joint_drift").values():
        assert chosen(of) == ["peg_transfer", "own", "joint_drift"]


def test_a_master_takes_the_place_of_the_motion():
    seen = options("master:=omni_pair")
    assert seen["master_console"]["--master"] == "omni_pair"
    assert "--motion" not in seen["master_console"]
    assert seen["simulator"]["--motion-label"] == "master:omni_pair"
    assert "--master" not in options()["master_console"]


@pytest.mark.parametrize("more, label", [((), "own_console"), (("impair:=net_delay_2",), "own_console-over-net_delay_2"),
                                         (("master:=omni_pair",), "master:omni_pair")])
def test_your_own_console_is_recorded_as_such(more, label):
    seen = nodes(LAUNCH, "console:=false", *more)
    assert "master_console" not in seen and seen["simulator"]["--motion-label"] == label
    assert options()["simulator"]["--motion-label"] == "scripted"


def test_the_simulated_surgeon_at_a_real_robot_is_recorded_as_such():
    seen = nodes(HARDWARE, "robot_host:=192.168.7.2", "console:=true")
    assert seen["simulator"]["--motion-label"] == seen["master_console"]["--motion"] == "scripted"
    assert "--motion-label" not in nodes(HARDWARE, "robot_host:=192.168.7.2")["simulator"]


def test_console_and_daemon_have_the_same_scale():
    seen = options("master:=mtm", "scale:=0.2")
    assert float(seen["master_console"]["--scale"]) == float(seen["simulator"]["--scale"]) == 0.2
    assert all("--scale" not in of for of in options("master:=omni_pair").values())


HARDWARE = os.path.join(os.path.dirname(LAUNCH), "hardware.launch")


def hardware(*arguments):
    """{type: node}, and the loaded configuration."""
    loaded = roslaunch_config.load_config_default([(HARDWARE, list(arguments))], None, verbose=False)
    assert not loaded.config_errors
    return {node.type: node for node in loaded.nodes}, loaded


def test_a_real_robot_gets_the_daemon_alone_strict_and_without_a_hazard():
    nodes, _ = hardware("robot_host:=192.168.7.2")
    assert set(nodes) == {"simulator"}
    words = nodes["simulator"].args.split()
    of = dict(zip(words[::2], words[1::2]))
    assert of["--robot-host"] == "192.168.7.2"
    assert chosen(of) == ["none", "none", "none"]
    assert words[-1] == "--strict"
    assert "--strict" not in hardware("robot_host:=192.168.7.2", "strict:=false")[0]["simulator"].args


def test_the_robots_address_must_be_said():
    with pytest.raises(Exception, match="robot_host"):
        hardware()


def test_scripted_hands_at_a_real_robot_are_slow():
    nodes, _ = hardware("robot_host:=192.168.7.2", "console:=true", "master_port:=4711")
    words = nodes["master_console"].args.split()
    assert float(words[words.index("--scale") + 1]) == 0.05
    words = nodes["simulator"].args.split()
    assert float(words[words.index("--scale") + 1]) == 0.05
    for node in nodes.values():
        assert "--master-port 4711" in " ".join(node.args.split())


def test_the_daemon_receives_the_scale_of_the_surgeons_master():
    nodes, _ = hardware("robot_host:=192.168.7.2", "scale:=0.03")
    words = nodes["simulator"].args.split()
    assert float(words[words.index("--scale") + 1]) == 0.03
    assert words[-1] == "--strict"
    assert "--scale" not in hardware("robot_host:=192.168.7.2")[0]["simulator"].args


def test_the_bridge_runs_on_the_robots_computer_and_serves_its_network():
    nodes, loaded = hardware("robot_host:=192.168.7.2", "bridge:=true", "robot_env:=/ws/devel/env.sh")
    bridge = nodes["raven_state_bridge"]
    assert loaded.machines[bridge.machine_name].address == "192.168.7.2"
    assert loaded.machines[bridge.machine_name].env_loader == "/ws/devel/env.sh"
    assert bridge.args.split()[:2] == ["--bind-address", "192.168.7.2"]
    assert nodes["simulator"].machine_name != bridge.machine_name


RVIZ = os.path.join(os.path.dirname(os.path.dirname(LAUNCH)), "config", "rviz", "raven2_trainer.rviz")


def displays():
    yaml = pytest.importorskip("yaml")
    with open(RVIZ, encoding="utf-8") as file:
        return yaml.safe_load(file)["Visualization Manager"]["Displays"]


def test_rviz_is_given_the_robot_and_its_configuration():
    launch = os.path.join(os.path.dirname(LAUNCH), "rviz.launch")
    loaded = roslaunch_config.load_config_default([(launch, [])], None, verbose=False)
    assert not loaded.config_errors
    assert "<robot" in loaded.params["/robot_description"].value
    (node,) = loaded.nodes
    assert node.type == "rviz"
    assert os.path.realpath(shlex.split(node.args)[1]) == os.path.realpath(RVIZ)


def test_rviz_shows_topics_that_there_are():
    sources = pathlib.Path(LAUNCH).parent.parent / "src/ros"
    text = "".join(path.read_text(encoding="utf-8") for path in sources.rglob("*.cpp"))
    topics = {shown[key] for shown in displays() for key in shown if key.endswith("Topic")}
    assert {"/markers", "/plan/tip_path", "/view/image_raw"} <= topics
    assert [topic for topic in topics if f'"{topic[1:]}"' not in text] == []


def test_rviz_shows_model_and_robot_by_the_prefixes_of_their_frames():
    robots = [shown for shown in displays() if shown["Class"] == "rviz/RobotModel"]
    assert [shown["TF Prefix"] for shown in robots] == ["model", "robot"]
    assert robots[1]["Alpha"] < 0.5 < robots[0]["Alpha"]


@pytest.mark.parametrize("trainee", ["tim", "007", "1e3"])
def test_trainee_and_curriculum_reach_all_programs(trainee):
    for seen in (options(f"trainee:={trainee}", "curriculum:=frs_basics", "exercise:=peg_transfer"),
                 nodes(HARDWARE, "robot_host:=10.0.0.2", f"trainee:={trainee}", "curriculum:=frs_basics")):
        assert all((of["--trainee"], of["--curriculum"]) == (trainee, "frs_basics") for of in seen.values()), seen
    assert all("--trainee" not in of and "--curriculum" not in of for of in options().values())


def test_scripted_hands_react_if_asked_to():
    assert options("reaction:=400")["master_console"]["--reaction"] == "400"
    assert options()["master_console"]["--reaction"] == "none"
    assert nodes(HARDWARE, "robot_host:=10.0.0.2", "console:=true", "reaction:=250")["master_console"]["--reaction"] == "250"
    assert "--reaction" not in options("master:=omni_pair", "reaction:=400")["master_console"]


def test_a_bad_link_is_between_console_and_daemon():
    seen = options("impair:=net_delay_2", "motion:=expert", "master_port:=4000", more=["impair"])
    assert (seen["simulator"]["--master-port"], seen["simulator"]["--force-port"]) == ("4000", "36001")
    console = seen["master_console"]
    assert [console[f"--{which}-port"] for which in ("master", "force", "sight")] == ["26020", "26021", "26022"]
    assert seen["impair"]["--profile"] == "net_delay_2"
    assert seen["simulator"]["--motion-label"] == "expert-over-net_delay_2"
    (links,) = [node.args for node in roslaunch_config.load_config_default(
        [(LAUNCH, ["impair:=net_delay_2", "master_port:=4000"])], None, verbose=False).nodes if node.type == "impair"]
    for link in ("26020:127.0.0.1:4000", "36001:127.0.0.1:26021", "26002:127.0.0.1:26022"):
        assert f"--udp {link}" in links
    assert "impair" not in options()


def test_blanks_in_the_names_of_files_stay_in_them():
    config, output = "config:=/my files/trainer.yaml", "output:=/my sessions/one"
    seen = options(config, output, "impair:=/my links/bad.yaml", "motion:=recording:/my hands/one.csv", more=["impair"])
    simulator = seen["simulator"]
    assert all(seen[name]["--config"] == "/my files/trainer.yaml" for name in ("virtual_raven", "master_console", "simulator"))
    assert simulator["--output"] == "/my sessions/one" and seen["impair"]["--profile"] == "/my links/bad.yaml"
    assert seen["master_console"]["--motion"] == "recording:/my hands/one.csv"
    assert simulator["--motion-label"] == "recording:/my hands/one.csv-over-bad"
    assert options("master:=/my masters/omni.yaml")["master_console"]["--master"] == "/my masters/omni.yaml"
    of = nodes(HARDWARE, "robot_host:=10.0.0.2", config, output)["simulator"]
    assert (of["--config"], of["--output"]) == ("/my files/trainer.yaml", "/my sessions/one")


def test_a_real_robot_has_its_drill_only_if_asked_for():
    assert nodes(HARDWARE, "robot_host:=10.0.0.2")["simulator"]["--drill"] == "none"
    seen = nodes(HARDWARE, "robot_host:=10.0.0.2", "exercise:=peg_transfer", "drill:=own")["simulator"]
    assert chosen(seen) == ["peg_transfer", "own", "none"]


def test_the_station_gets_the_arguments_of_its_launch_file():
    plain = nodes(STATION, "sessions:=/tmp/a b")["station"]
    assert plain == {"--port": "8080", "--sessions": "/tmp/a b"}
    seen = nodes(STATION, "port:=9000", "config:=/my own/trainer.yaml", "robot_host:=192.168.7.2", "scale:=0.1")["station"]
    assert (seen["--port"], seen["--config"], seen["--robot-host"], seen["--scale"]) == ("9000", "/my own/trainer.yaml", "192.168.7.2", "0.1")
