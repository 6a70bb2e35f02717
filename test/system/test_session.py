"""One session of the programs as a user starts them. A signal ends it."""

import socket
import time

import pytest
from stack import Stack, await_run_level, itp, robot_states

PEDAL_UP = 2


@pytest.mark.parametrize("duration", [0, 5])
def test_waiting_for_the_pedal_is_an_error_only_if_an_end_was_asked_for(duration):
    with Stack(configure={"runtime": {"start_timeout": 0.5}}) as stack:
        daemon = stack.start_daemon("--hazard", "none", "--duration", str(duration))
        if duration:
            assert daemon.wait(60) == 1, stack.log_text("simulator")
            return
        stack.await_ticks()
        time.sleep(1.5)
        assert daemon.poll() is None, stack.log_text("simulator")
        assert stack.stop("simulator")[0] == 0


def test_a_session_ends_cleanly_at_a_signal_and_its_counters_add_up():
    with Stack() as stack:
        stack.start_robot()
        stack.start_daemon("--hazard", "none")
        await_run_level(stack.state_port, PEDAL_UP)
        stack.await_ticks()
        master = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        master.connect(("127.0.0.1", stack.master_port))
        for sequence in range(1, 1500):
            master.send(itp(sequence, sequence > 300, (10, 0, 0)))
            time.sleep(0.001)
        assert robot_states(stack.state_port).next()  # the robot still serves its states
        code, seconds = stack.stop("simulator")
        assert code == 0 and seconds < 5, stack.log_text("simulator")
        packets = stack.assert_counters_add_up()
        assert packets["master_to_daemon"]["received"] == 1499
        assert packets["robot_to_daemon"]["applied"] > 1000
        assert stack.stop("virtual_raven")[0] == 0
