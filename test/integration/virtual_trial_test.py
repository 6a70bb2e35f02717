#!/usr/bin/python3
"""A virtual trial over real sockets, repeated on the robot: how near the robot's tips come to the model's in the trial,
and how fast a released pedal ends the repetition. The test is the console.

The tips are compared at equal progress, in each tick of the repetition. The robot's tip is forward kinematics of the
joints that the robot sent. The model's tip is that of the trial's tick which the repetition had reached. Both come from
the session's log. The robot's state is as old as it was when the daemon used it, which counts against us.
"""
import itertools
import os
import sys
import time
import unittest

import numpy as np
import rospy
import rostest
from pedal_stops import PEDAL_DN, PEDAL_UP, demand_released, differ, is_fast, newest_session, release_when, robot_stop, stops_of
from planning_clients import PREEMPTED, SUCCESS, Console, Daemon, until
from robot_frames import connect
from training_clients import Trainer

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "..", "scripts"))
import raven2_session  # noqa: E402

MASTER_PORT, STATE_PORT = 27180, 27183
BOTH = (0, 1)
MEAN_LIMIT = 0.003  # m
RELEASES = 3
HOLD = 0.2  # s, config/execution.yaml: hold_time, from the arms' place to the trial's start
# Strokes: (gold um per packet, green um per packet, s). The two halves go around a square at 20 mm/s, with a clutch
# between them, and end where they began. THERE and BACK go at 35 mm/s.
FIRST_HALF = (((20, 0, 0), (20, 0, 0), 0.5), ((0, 20, 6), (0, -20, 6), 0.5))
SECOND_HALF = (((-20, 0, 0), (-20, 0, 0), 0.5), ((0, -20, -6), (0, 20, -6), 0.5))
THERE, BACK = (((25, 25, 0), (25, -25, 0), 0.7),), (((-25, -25, 0), (-25, 25, 0), 0.7),)


class VirtualTrial(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("virtual_trial_test", disable_signals=True)
        cls.console = Console(MASTER_PORT)
        cls.console.start()
        cls.robot = connect(STATE_PORT)
        cls.daemon, cls.trainer = Daemon(), Trainer()
        assert cls.robot.wait(lambda s: s.runlevel == PEDAL_UP and s.homed, 60), "never homed"
        until(lambda: cls.daemon.robot.message and cls.daemon.model.message, 10, "joint states")

    def setUp(self):
        self.lift()
        self.robot.wait(lambda s: s.runlevel == PEDAL_UP)
        time.sleep(0.3)

    def lift(self):
        self.console.pedal, self.console.step_um, self.console.green_um = 0, (0, 0, 0), (0, 0, 0)

    def press(self):
        self.console.pedal = 1
        engaged = self.robot.wait(lambda s: s.runlevel == PEDAL_DN)
        self.assertIsNotNone(engaged, "the robot did not engage")
        return engaged

    def move(self, strokes):
        """Moves both arms with the pedal down, then releases the pedal."""
        self.console.pedal = 1
        self.trainer.await_mode("trial")
        for gold, green, seconds in strokes:
            self.console.step_um, self.console.green_um = gold, green
            self.console.play(int(1000 * seconds))
        self.console.step_um, self.console.green_um = (0, 0, 0), (0, 0, 0)
        time.sleep(0.1)
        self.console.pedal = 0
        self.trainer.await_mode("trial_held")

    def trial(self, *halves):
        """A whole trial, with a clutch between its halves. The robot rests."""
        stood = self.robot.states[-1]
        first = len(self.robot.states)
        self.assertEqual(self.trainer.call("begin_trial"), "accepted")
        self.trainer.await_mode("trial_held")
        for strokes in halves:
            self.move(strokes)
        self.assertEqual(self.trainer.call("end_trial"), "accepted")
        self.trainer.await_mode("trial_ready")
        self.assertEqual({s.runlevel for s in self.robot.states[first:]}, {PEDAL_UP}, "the robot was engaged")
        self.assertFalse(any(differ(s, stood, BOTH) for s in self.robot.states[first:]), "the robot moved")

    def repeat(self, on_robot=True):
        """Asks for a repetition and waits until it is armed. @return number of the execution."""
        answer = self.trainer.repeat_trial(on_robot=on_robot)
        self.assertEqual((answer.success, answer.status, answer.error_code), (True, "accepted", SUCCESS))
        self.trainer.await_mode("armed", 10)
        return answer.execution

    @staticmethod
    def tip_errors(log, report):
        """@return [m] the robot's tip from the model's in the trial, by tick and arm; the trial's span by arm."""
        model, robot = log.ticks["model"], log.ticks["robot"]
        modes = log.names("tick", "model.mode")
        before = model["tick"] < report.started
        begun = model["tick"][before & (model["mode"] == modes.index("trial_held")) & (model["trial_ticks"] == 0)][-1]
        taped = before & (model["tick"] > begun) & (model["mode"] == modes.index("trial"))
        assert (model["trial_ticks"][taped] == np.arange(1, taped.sum() + 1)).all(), "ticks of the trial are missing"
        tape = model["arms"]["p_BT"][taped]  # ticks x arms x 3
        progress = model["planning"]["progress"]
        led = (model["tick"] >= report.started) & (model["tick"] < report.ended) & (progress > 0.0) & (progress < 1.0)
        place = np.minimum((progress[led] * len(tape)).astype(int), len(tape) - 1)
        assert len(place) > 0.8 * len(tape), "the log has too few ticks of the repetition"
        return np.linalg.norm(robot["arms"]["p_BT"][led] - tape[place], axis=2), np.linalg.norm(np.ptp(tape, axis=0), axis=1)

    def test_1_the_robot_does_what_the_model_did(self):
        self.trial(FIRST_HALF, SECOND_HALF)
        number = self.repeat()
        self.press()
        report = self.daemon.await_execution(number)
        print(f"repeated {report.path_time:.2f} s: {report.end}; by the daemon's report the model is off by "
              f"{1e3 * report.model_error_mean:.2f} mm mean, {1e3 * report.model_error_largest:.2f} largest, the robot by "
              f"{1e3 * report.robot_error_mean:.2f}, {1e3 * report.robot_error_largest:.2f}")
        self.assertEqual((report.end, report.error_code), ("finished", SUCCESS))
        self.assertEqual((report.plan, report.on_robot, report.progress), (0, True, 1.0))
        self.assertLess(report.robot_error_mean, MEAN_LIMIT)
        self.assertGreater(report.robot_error_largest, 0.0, "the report covers the robot's tip")
        self.console.release()
        time.sleep(0.5)  # the recorder writes 20 times a second
        errors, spans = self.tip_errors(raven2_session.Session(newest_session("virtual_trial")).log, report)
        for arm in BOTH:
            print(f"{('gold', 'green')[arm]}: tip within {1e3 * spans[arm]:.1f} mm; the robot from the trial "
                  f"{1e3 * errors[:, arm].mean():.3f} mm mean, {1e3 * errors[:, arm].max():.3f} largest, {len(errors)} ticks")
            self.assertGreater(spans[arm], 0.010, "the trial moved this arm")
            self.assertLess(errors[:, arm].mean(), MEAN_LIMIT)

    def test_2_the_released_pedal_stops_model_and_robot_within_20_ms(self):
        strokes = itertools.cycle((THERE, BACK))
        stops_of(self, lambda k: self.release_at(0.3 + 0.2 * k, next(strokes)), RELEASES, "virtual_trial", BOTH)

    def release_at(self, share, strokes):
        """Releases the pedal in motion, about this share of the path done. @return as for stops_of()."""
        self.trial(strokes)
        number = self.repeat()
        far = self.press().cycle + int(1000 * (HOLD + share * strokes[0][2]))
        released, first = release_when(self.console, self.robot,
                                       lambda s: s.cycle > far and all(is_fast(s, arm) for arm in BOTH))
        report = self.daemon.await_execution(number, 5)
        demand_released(report)
        self.assertEqual((report.end, report.error_code), ("released", PREEMPTED))
        self.assertLess(report.progress, 1.0)
        return (released, *robot_stop(self.robot, released, first, BOTH))

    def test_3_repeated_by_the_model_alone_the_robot_rests_and_it_can_be_repeated_again(self):
        self.trial(THERE)
        stood = self.robot.states[-1]
        number = self.repeat(on_robot=False)
        first = len(self.robot.states)
        self.console.pedal = 1
        report = self.daemon.await_execution(number)
        self.assertEqual((report.end, report.on_robot), ("finished", False))
        self.assertLess(report.model_error_mean, MEAN_LIMIT)
        self.trainer.await_mode("trial_ready")
        self.console.release()
        self.assertEqual({s.runlevel for s in self.robot.states[first:]}, {PEDAL_UP})
        self.assertFalse(any(differ(s, stood, BOTH) for s in self.robot.states[first:]), "the robot moved")
        time.sleep(0.2)
        number = self.repeat()
        self.press()
        self.assertEqual(self.daemon.await_execution(number).end, "finished")

    def test_4_what_cannot_be_is_refused_with_its_reason(self):
        refused = self.trainer.repeat_trial(on_robot=True)
        self.assertEqual((refused.success, refused.status, refused.error_code, refused.execution),
                         (False, "not_now", -17, 0))
        self.assertEqual(self.trainer.call("end_trial"), "not_now")
        self.assertEqual(self.trainer.call("discard_trial"), "not_now")
        self.assertEqual(self.trainer.call("begin_trial"), "accepted")
        self.assertEqual(self.trainer.call("begin_trial"), "not_now")
        self.assertEqual(self.trainer.call("end_trial"), "accepted")
        self.assertEqual(self.trainer.repeat_trial(on_robot=True).status, "no_plan", "the trial is empty")
        self.assertEqual(self.trainer.call("discard_trial"), "accepted")
        self.trainer.await_mode("pedal_up")

    def test_5_an_armed_repetition_is_called_off(self):
        self.trial(BACK)
        number = self.repeat()
        self.assertTrue(self.daemon.cancel_plan().success)
        self.assertEqual(self.daemon.await_execution(number, 5).end, "cancelled")
        self.trainer.await_mode("pedal_up")


if __name__ == "__main__":
    rostest.rosrun("raven2_trainer", "virtual_trial", VirtualTrial)
