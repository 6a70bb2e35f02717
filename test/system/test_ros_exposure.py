"""The ports and calls of our ROS nodes that others can reach."""

import socket
import xmlrpc.client

import pytest

from ros_master import RosMaster, listeners
from stack import Stack, wait_until

LOOPBACK = "127.0.0.1"
NODES = {"simulator": "/raven2_simulator", "virtual_raven": "/virtual_raven", "raven_state_bridge": "/raven_state_bridge"}
SAFER_CRTK = {f"/{arm}/{topic}" for arm in ("arm1", "arm2") for topic in ("state_command", "hold")}
SAFER = {"/stop_hazard", "/pause", "/disengage", "/cancel_plan", "/emergency_stop"}
TRAINING = {"/begin_simulation", "/end_simulation", "/begin_trial", "/end_trial", "/discard_trial", "/repeat_trial",
            "/clear_stop", "/set_view", "/set_camera_pedal", "/start_exercise", "/gold/tool_change", "/green/tool_change",
            "/end_replay"}  # not begin_replay, which reads a file that the caller names


@pytest.fixture(name="master")
def fixture_master(tmp_path):
    with RosMaster(str(tmp_path)) as master:
        master.start()
        yield master


def start(master, program, environment=None, configure=None):
    stack = Stack(configure=configure)
    for name in ("ROS_IP", "ROS_HOSTNAME"):
        stack.environment.pop(name, None)
    stack.environment.update(environment or {}, ROS_MASTER_URI=master.uri)
    if program == "simulator":
        stack.start_daemon()
    else:
        stack.start(program)
    try:
        wait_until(lambda: "registered" in stack.log_text(program) or "are there" in stack.log_text(program), 20,
                   f"{program} is registered")
    except AssertionError as error:
        stack.__exit__(type(error), error, None)  # no program may outlive a failure
        raise
    return stack, NODES[program]


@pytest.mark.parametrize("program", list(NODES))
def test_only_roscpps_own_port_listens_beyond_this_computer_and_a_shutdown_call_is_a_fault(master, program):
    stack, node = start(master, program)
    with stack:
        process = stack.processes[program]
        slave_port = int(master.ask("lookupNode", node).rstrip("/").rpartition(":")[2])
        wide = [entry for entry in listeners(process.pid) if entry[1] != LOOPBACK]
        assert wide == [("tcp", "0.0.0.0", slave_port)], listeners(process.pid)
        assert len(listeners(process.pid)) > 1, "the test can read the list of ports"
        with master.slave(node) as slave:
            for arguments in (("/stranger", "because"), ("/stranger",), ()):
                with pytest.raises(xmlrpc.client.Fault, match="refused"):
                    slave.shutdown(*arguments)
            assert slave.getPid("/stranger")[2] == process.pid
        assert process.poll() is None
        assert master.known_of(node)["published"] or master.known_of(node)["subscribed"]
        assert stack.stop(program)[0] == 0


QUERIES = {f"/{arm}/{prefix}{which}_kinematics" for arm in ("arm1", "arm2") for prefix in ("", "local/")
           for which in ("forward", "inverse")}


def test_a_network_gets_no_commands_unless_the_configuration_says_so(master):
    open_to_all = {"ROS_HOSTNAME": socket.gethostname()}
    for key, wanted in ((False, SAFER), (True, SAFER | TRAINING | {"/start_hazard", "/inject_hazard", "/engage", "/plan", "/planning_mode",
                                                        "/execute_plan", "/gold/set_collisions",
                                                        "/green/set_collisions"} | QUERIES)):
        stack, node = start(master, "simulator", open_to_all, {"runtime": {"enable_remote_control": key}})
        with stack:
            services = {s for s in master.known_of(node)["services"] if not s.startswith(node)}
            assert services == wanted
            assert "/pedals" in master.known_of(node)["subscribed"], "everybody may send the stop"
            assert ("/move_arm/goal" in master.known_of(node)["subscribed"]) == key
            heard = {name for name in master.known_of(node)["subscribed"] if name.startswith("/arm")}
            assert SAFER_CRTK <= heard
            assert (heard == SAFER_CRTK) != key
            assert "ROS serves the network" in stack.log_text("simulator")
            assert stack.stop("simulator")[0] == 0
        stack, node = start(master, "virtual_raven", open_to_all, {"runtime": {"enable_remote_control": key}})
        with stack:
            seen = master.known_of(node)
            assert ("/raven_automove" in seen["subscribed"]) == key
            assert ("/virtual_raven/press_start" in seen["services"]) == key


def test_another_node_of_the_same_name_is_not_fought_and_leaves_a_working_name(master):
    stack, node = start(master, "virtual_raven")
    with stack, xmlrpc.client.ServerProxy(master.uri) as api:
        # The stranger's address is of no process. Our node registers again at once.
        api.registerPublisher(node, "/ravenstate", "raven_2/raven_state", "http://127.0.0.1:9/")
        uri = f"http://127.0.0.1:{[p for k, a, p in listeners(stack.processes['virtual_raven'].pid) if a == '0.0.0.0'][0]}/"
        wait_until(lambda: master.ask("lookupNode", node) == uri, 5, "the name is ours again")
        assert master.known_of(node)["published"] == {"/ravenstate", "/joint_states"}
        assert stack.processes["virtual_raven"].poll() is None, "the master's own shutdown call is refused, too"


@pytest.mark.parametrize("uri", ["nonsense", "http://127.0.0.1", "http://127.0.0.1:99999"])
def test_a_master_uri_that_is_none_is_said_and_not_an_abort(uri):
    with Stack() as stack:
        stack.environment["ROS_MASTER_URI"] = uri
        process = stack.start("virtual_raven")
        assert process.wait(20) == 1
        assert "ROS_MASTER_URI" in stack.log_text("virtual_raven")
