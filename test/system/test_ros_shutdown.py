"""Every program ends within a second of a signal: with a ROS master, without one, with one that hangs, and while a plan
is searched. Afterwards no force is left on the hand, the record is complete, and the ports are free."""

import os
import re
import signal
import socket
import time

import pytest

from ros_master import RosMaster, SlowMaster
from stack import Stack, effort, wait_until
from surgeon import LatestState, Surgeon

E_STOP, PEDAL_UP, PEDAL_DOWN = 0, 2, 3
ROUNDS = effort(1, 10)  # for each list of signals
JUMPS = 4  # at most, before a new robot is started
WITHIN = 1.0  # [s] from the signal to the end of the process
GOODBYE = 2.0  # [s] at most for unregistering, while the master answers
ENDLESS_PLAN = {"runtime": {"plan_at": 0.3}, "planner": {"samples": 100000, "time_limit": 3600.0}}


def early_jump(stack):
    """Moves the packaged hazard to 0.2 s after pedal-down, so that the hand feels a force soon."""
    path = os.path.join(stack.folder, "share", "config", "faults", "sudden_jump.yaml")
    with open(path, encoding="utf-8") as file:
        text = re.sub("first_tick: [0-9]+", "first_tick: 200", file.read())
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def thread_seconds(pid, name):
    """CPU time [s] of the thread with this name, or 0 without such a thread."""
    for task in os.listdir(f"/proc/{pid}/task"):
        with open(f"/proc/{pid}/task/{task}/stat", encoding="ascii") as file:
            words = file.read()
        if f"({name})" in words:
            fields = words.rpartition(")")[2].split()
            return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    return 0.0


def assert_ports_are_free(stack):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as again:
        again.bind(("127.0.0.1", stack.master_port))


def assert_record_is_whole(stack):
    packets = stack.assert_counters_add_up()
    assert packets["master_to_daemon"]["applied"] > 0
    assert stack.meta()["realtime"]
    with open(os.path.join(stack.output, "session.rlog"), "rb") as log:
        assert log.seek(0, os.SEEK_END) > 1000


def end_daemon(stack, surgeon, signals, report):
    """Sends the signals one after the other. Checks the end of the daemon."""
    process = stack.processes["simulator"]
    begin = time.monotonic()
    for sign in signals:
        process.send_signal(sign)
    code = process.wait(20)
    seconds = time.monotonic() - begin
    del stack.processes["simulator"]
    report.append(seconds)
    assert code == 0, stack.log_text("simulator")
    surgeon.read_forces()
    assert not any(surgeon.last_force), "the last packet has no force"
    assert_ports_are_free(stack)
    assert_record_is_whole(stack)


class Once:
    """A condition that remembers whether it ever held."""

    def __init__(self, condition):
        self._condition = condition
        self.was_true = False

    def __call__(self):
        self.was_true = self.was_true or bool(self._condition())
        return self.was_true


class Bench:
    """A homed robot, and a new daemon with a new surgeon each round. The robot keeps running."""

    def __init__(self, within=WITHIN, **options):
        self.stack = Stack(**options)
        self.within = within
        self.times, self.begun = [], 0
        early_jump(self.stack)

    def run(self, ways, ready, master=None, before=lambda: None, after=lambda: None,
            hazard="sudden_jump"):
        if master:
            self.stack.environment["ROS_MASTER_URI"] = master.uri
        self.stack.start_robot()
        robot = LatestState(self.stack.state_port)
        wait_until(lambda: robot.runlevel() == PEDAL_UP, 20, "homed")
        for number in range(ROUNDS * len(ways)):
            # A jump may end in the robot's own emergency stop. Each jump moves the shoulder by 0.08 rad. A seventh jump
            # would find the shoulder at its joint limit, where it cannot move.
            if robot.runlevel() != PEDAL_UP or number % JUMPS == JUMPS - 1:
                self.stack.stop("virtual_raven")
                self.stack.start_robot()
            self.stack.output = os.path.join(self.stack.folder, f"session{number}")
            self.stack.start_daemon("--hazard", hazard)
            surgeon = Surgeon(self.stack)
            try:
                wait_until(lambda: robot.runlevel() == PEDAL_UP and surgeon.read_forces(), 20, "ready")
                surgeon.press(lambda: robot.runlevel() in (PEDAL_DOWN, E_STOP))
                begun = Once(lambda: ready(self.stack, surgeon))
                wait_until(lambda: begun() or robot.runlevel() == E_STOP, 20, "the work to interrupt has begun")
                self.begun += begun.was_true
                before()
                end_daemon(self.stack, surgeon, ways[number % len(ways)], self.times)
                after()
                wait_until(lambda: robot.runlevel() not in (None, PEDAL_DOWN), 2, "the robot is not left with the pedal down")
            finally:
                surgeon.close()
        robot.close()

    def __enter__(self):
        return self

    def __exit__(self, *error):
        print(f"  {len(self.times)} ends, seconds:", " ".join(f"{t:.2f}" for t in self.times))
        self.stack.__exit__(*error)  # comes first: no program may outlive a failure
        if error[0] is None:
            assert max(self.times) < self.within, self.times
            assert self.begun > len(self.times) / 2, "the robot's own emergency stop came first too often"


def feels_force(_, surgeon):
    return surgeon.feels_force()


def is_planning(stack, surgeon):
    if surgeon.pedal:
        time.sleep(0.4)
        surgeon.pedal = False  # a plan needs the pedal up
    return thread_seconds(stack.processes["simulator"].pid, "planner") > 0.1  # [s] the goal search is over


def test_without_a_master_the_daemon_takes_the_force_away_and_ends():
    with Bench() as bench:
        bench.run([[signal.SIGTERM], [signal.SIGINT], [signal.SIGTERM] * 2], feels_force)


def test_while_a_plan_is_searched_the_daemon_ends():
    with Bench(configure=ENDLESS_PLAN) as bench:
        bench.run([[signal.SIGTERM]], is_planning, hazard="none")


def test_with_a_master_the_daemon_ends_and_is_no_longer_registered():
    with Bench() as bench, RosMaster(bench.stack.folder) as master:
        master.start()

        def is_ready(stack, surgeon):
            return "/start_hazard" in master.known_of("/raven2_simulator")["services"] and feels_force(stack, surgeon)
        bench.run([[signal.SIGTERM]], is_ready, master)
        assert master.known_of("/raven2_simulator")["published"] == set()
        code, seconds = bench.stack.stop("virtual_raven")
        assert code == 0 and seconds < WITHIN, bench.stack.log_text("virtual_raven")
        assert master.known_of("/virtual_raven")["published"] == set()


def heard_by(master, node, topic):
    """Publishers of a topic to which a node is connected; 0 before it answers."""
    try:
        code, _, connections = master.slave(node).getBusInfo("/test")
    except OSError:
        return 0
    return sum(code == 1 and connection[2] == "i" and connection[4] == topic for connection in connections)


def test_while_clients_stream_twists_the_daemon_ends():
    # The C library overwrites freed memory: a message for a receiver that ends would end the daemon.
    freed = {"GLIBC_TUNABLES": "glibc.malloc.tcache_count=0:glibc.malloc.perturb=165"}
    topics = ["/arm1/servo_cv", "/arm2/servo_cv"]
    with Stack(environment=freed) as stack, RosMaster(stack.folder) as master:
        master.start()
        stack.environment["ROS_MASTER_URI"] = master.uri
        clients = [master.popen("rostopic", "pub", "-r", "1000", topic, "geometry_msgs/TwistStamped", "{}") for topic in topics]
        try:
            for number in range(effort(2, 10)):
                stack.output = os.path.join(stack.folder, f"session{number}")
                stack.start_daemon()
                wait_until(lambda: "/arm2/servo_cv" in master.known_of("/raven2_simulator")["subscribed"], 20, "it listens")
                wait_until(lambda: all(heard_by(master, "/raven2_simulator", topic) for topic in topics), 20, "it hears")
                code, _ = stack.stop("simulator")
                assert code == 0, stack.log_text("simulator")
                assert "unknown" not in stack.meta()["realtime"], "its record is complete"
        finally:
            for client in clients:
                client.kill()
                client.wait()


def test_a_master_that_hangs_holds_nobody_up():
    with Bench() as bench, RosMaster(bench.stack.folder) as master:
        master.start()

        def is_ready(stack, surgeon):
            return master.known_of("/raven2_simulator")["services"] and feels_force(stack, surgeon)
        bench.run([[signal.SIGTERM]], is_ready, master, before=lambda: master.signal(signal.SIGSTOP),
                  after=lambda: master.signal(signal.SIGCONT))
        assert "leaving without a goodbye" in bench.stack.log_text("simulator")


@pytest.mark.parametrize("seconds", [0.5, 60.0])
def test_a_slow_master_that_answers_gets_its_goodbye_within_a_bound(seconds):
    with Bench(GOODBYE + WITHIN) as bench, RosMaster(bench.stack.folder) as master:
        master.start()

        def is_ready(*_):
            return "/start_hazard" in master.known_of("/raven2_simulator")["services"]
        with SlowMaster(master, seconds) as slow:
            bench.run([[signal.SIGTERM]], is_ready, slow, before=slow.delay_next, hazard="none")
        left = any(master.known_of("/raven2_simulator").values())
        assert left == ("leaving without a goodbye" in bench.stack.log_text("simulator"))
        assert bench.times[-1] > (GOODBYE if left else seconds), "it left early, or the master was not slow"
        assert left or seconds < GOODBYE


@pytest.mark.parametrize("program", ["virtual_raven", "master_console", "raven_state_bridge"])
def test_the_other_programs_end_at_a_signal_without_a_master(program):
    times = []
    for number in range(max(2, ROUNDS)):
        with Stack() as stack:
            stack.start(program)
            wait_until(lambda: thread_is_there(stack.processes[program].pid), 20, "its threads run")
            code, seconds = stack.stop(program, (signal.SIGTERM, signal.SIGINT)[number % 2])
            assert code == 0, stack.log_text(program)
            if program != "master_console":
                with socket.create_server(("127.0.0.1", stack.state_port)):
                    pass  # the port is free again
            times.append(seconds)
    print(f"  {program}, seconds:", " ".join(f"{t:.2f}" for t in times))
    assert max(times) < WITHIN, times


def thread_is_there(pid):
    names = ("raven_state", "console")
    return any(thread_exists(pid, name) for name in names)


def thread_exists(pid, name):
    for task in os.listdir(f"/proc/{pid}/task"):
        with open(f"/proc/{pid}/task/{task}/comm", encoding="ascii") as file:
            if file.read().strip() == name:
                return True
    return False


def lifts_the_pedal(_, surgeon):
    surgeon.pedal = False
    time.sleep(0.1)  # the packet is still in the network, for 406 ms at least
    return True


def test_the_robot_is_told_pedal_up_though_a_bad_network_still_holds_it():
    with Bench() as bench:
        bench.run([[signal.SIGTERM]], lifts_the_pedal, hazard="net_delay_3")
