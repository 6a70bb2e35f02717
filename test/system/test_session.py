"""One session of the programs as they are started by hand, ended by a signal."""

import socket
import time

from stack import RobotStates, Stack, itp, listens, wait_until

PEDAL_UP, PEDAL_DOWN = 2, 3


def test_a_session_ends_cleanly_at_a_signal_and_its_counters_add_up():
    with Stack() as stack:
        stack.start_robot()
        wait_until(lambda: listens(stack.state_port), 10, "the robot listens")
        stack.start_daemon("--hazard", "none")
        reader = RobotStates(stack.state_port)
        wait_until(lambda: reader.state()["runlevel"] == PEDAL_UP, 20, "homed")
        master = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        master.connect(("127.0.0.1", stack.master_port))
        for sequence in range(1, 1500):
            master.send(itp(sequence, sequence > 300, (10, 0, 0)))
            time.sleep(0.001)
        assert reader.next()  # still served
        code, seconds = stack.stop("simulator")
        assert code == 0 and seconds < 5, stack.log_text("simulator")
        packets = stack.assert_counters_add_up()
        assert packets["master_to_daemon"]["received"] == 1499
        assert packets["robot_to_daemon"]["applied"] > 1000
        assert stack.stop("virtual_raven")[0] == 0
