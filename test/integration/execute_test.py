#!/usr/bin/python3
"""Planning and executing over real sockets: services, topics and a stock actionlib client; the test is the console."""
import time
import unittest

import actionlib
import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from nav_msgs.msg import Path
from pedal_stops import PEDAL_DN, PEDAL_UP, demand_released, is_fast, release_when, robot_stop, stops_of
from planning_clients import PREEMPTED, SUCCESS, Console, Daemon, Newest, plan_to, until
from raven2_trainer.msg import MoveArmAction, MoveArmGoal
from robot_frames import connect
from trajectory_msgs.msg import JointTrajectory

MASTER_PORT, STATE_PORT = 27170, 27173
AWAY = (0.12, 0.08, 0.015, 0.3, 0.2, 0.0, 0.0)  # from home, clear of the scene
RELEASES = 3


def error_message(response):
    return f"{response.status} ({response.error_code})"


class Execute(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("execute_test", disable_signals=True)
        cls.console = Console(MASTER_PORT)
        cls.console.start()
        cls.robot = connect(STATE_PORT)
        cls.daemon = Daemon()
        cls.paths, cls.trajectories = Newest("plan/tip_path", Path), Newest("plan/trajectory", JointTrajectory)
        assert cls.robot.wait(lambda s: s.runlevel == PEDAL_UP and s.homed, 60), "never homed"
        until(lambda: cls.daemon.robot.message and cls.daemon.model.message, 10, "joint states")
        time.sleep(0.5)  # the model is where the robot is
        cls.home = cls.daemon.joints(cls.daemon.robot)
        cls.away = [a + b for a, b in zip(cls.home, AWAY)]

    def setUp(self):
        self.console.pedal, self.console.step_um = 0, (0, 0, 0)
        self.robot.wait(lambda s: s.runlevel == PEDAL_UP)
        time.sleep(0.3)

    def plan(self, joints):
        response = self.daemon.plan(**plan_to(joints))
        self.assertTrue(response.success, error_message(response))
        self.assertEqual(response.error_code, SUCCESS)
        self.assertTrue(response.robot_follows, "the robot's own inverse kinematics would leave the path")
        return response

    def arm(self, joints):
        """Planned and armed. @return (answer of plan, number of the execution)."""
        plan = self.plan(joints)
        answer = self.daemon.execute_plan(on_robot=True, plan=plan.plan)
        self.assertTrue(answer.success, error_message(answer))
        self.daemon.await_status("armed")
        return plan, answer.execution

    def press(self):
        self.console.pedal = 1
        self.assertIsNotNone(self.robot.wait(lambda s: s.runlevel == PEDAL_DN), "the robot did not engage")

    def assert_at(self, source, joints, what):
        """Compares the first five joints, within settle_tolerance (1.5 mm). The tool's own joints only rotate it."""
        for here, there, limit in zip(self.daemon.joints(source), joints, (0.015, 0.015, 0.0015, 0.05, 0.05)):
            self.assertAlmostEqual(here, there, delta=limit, msg=what)

    def test_1_a_whole_execution_reaches_the_goal_on_model_and_robot(self):
        plan, number = self.arm(self.away)
        until(lambda: self.trajectories.message and len(self.trajectories.message.points) == len(plan.trajectory.points),
              5, "plan/trajectory")
        until(lambda: self.paths.message, 5, "plan/path, published after it")
        self.assertEqual(self.trajectories.message.points[-1].positions, plan.trajectory.points[-1].positions)
        self.assertEqual(self.paths.message.header.frame_id, "world")
        self.assertGreater(len(self.paths.message.poses), len(plan.trajectory.points))
        self.press()
        report = self.daemon.await_execution(number)
        print(f"executed {report.path_time:.2f} s of path: {report.end}; model {1e3 * report.model_error_mean:.2f} mm mean, "
              f"{1e3 * report.model_error_largest:.2f} largest, {1e3 * report.model_error_at_end:.2f} at the end; robot "
              f"{1e3 * report.robot_error_mean:.2f}, {1e3 * report.robot_error_largest:.2f}, "
              f"{1e3 * report.robot_error_at_end:.2f}")
        self.assertEqual((report.end, report.error_code), ("finished", SUCCESS))
        self.assertEqual((report.plan, report.arm, report.on_robot), (plan.plan, "gold", True))
        self.assertEqual(report.contact_ticks, 0)
        self.assertAlmostEqual(plan.clearance, report.planned_clearance, delta=1e-9)
        self.assertGreater(plan.clearance, 0.0)
        self.assertGreater(report.robot_error_largest, 0.0, "the report covers the robot's tip")
        time.sleep(0.2)
        self.assert_at(self.daemon.robot, self.away, "the robot is not at the goal")
        self.assert_at(self.daemon.model, self.away, "the model is not at the goal")
        statuses = [m.status for m in self.daemon.progress.messages]
        self.assertIn("executing", statuses)
        shares = [m.progress for m in self.daemon.progress.messages if m.status == "executing"]
        self.assertEqual(shares, sorted(shares))
        self.assertGreaterEqual(len(shares), 4, "progress is published ten times a second")

    def test_2_the_released_pedal_stops_model_and_robot_within_20_ms(self):
        stops_of(self, lambda k: self.release_at(0.3 + 0.2 * k), RELEASES, "execute")

    def release_at(self, share):
        """Releases the pedal in motion, after this share of the shoulder's path. @return as for stops_of()."""
        start = self.daemon.joints(self.daemon.robot)
        goal = max((self.home, self.away), key=lambda joints: abs(joints[0] - start[0]))
        _, number = self.arm(goal)
        begin = self.robot.states[-1].q[0][0]
        way = share * abs(goal[0] - start[0])
        self.press()
        released, first = release_when(self.console, self.robot, lambda s: abs(s.q[0][0] - begin) > way and is_fast(s))
        report = self.daemon.await_execution(number, 5)
        demand_released(report)
        self.assertEqual((report.end, report.error_code), ("released", PREEMPTED))
        self.assertLess(report.progress, 1.0)
        return (released, *robot_stop(self.robot, released, first))

    def test_3_a_goal_shown_by_hand_is_planned_to_and_reached(self):
        held = self.daemon.joints(self.daemon.robot)
        answer = self.daemon.planning_mode(command="begin", arm="gold")
        self.assertTrue(answer.success, error_message(answer))
        self.daemon.await_status("choosing")
        self.console.pedal, self.console.step_um = 1, (-10, 20, 0)
        time.sleep(0.6)  # some 500 packets: 12 mm
        self.console.pedal, self.console.step_um = 0, (0, 0, 0)
        time.sleep(0.2)
        chosen = self.daemon.joints(self.daemon.model)
        self.assertGreater(max(abs(a - b) for a, b in zip(chosen[:2], held[:2])), 0.01, "the model was not moved")
        self.assertEqual({s.runlevel for s in self.robot.states[-1000:]}, {PEDAL_UP}, "the robot was engaged")
        self.assert_at(self.daemon.robot, held, "the robot moved")

        answer = self.daemon.planning_mode(command="record_goal")
        self.assertTrue(answer.success, error_message(answer))
        armed = self.daemon.execute_plan(on_robot=True, plan=answer.plan)
        self.assertTrue(armed.success, error_message(armed))
        self.press()
        report = self.daemon.await_execution(armed.execution)
        self.assertEqual(report.end, "finished")
        time.sleep(0.2)
        self.assert_at(self.daemon.robot, chosen, "the robot is not where the surgeon pointed")

    def test_4_planning_mode_can_be_left_and_refuses_what_it_cannot_do(self):
        held = self.daemon.joints(self.daemon.robot)
        self.assertEqual(self.daemon.planning_mode(command="record_goal").status, "not_now")
        self.assertIn("known: gold", self.daemon.planning_mode(command="begin", arm="third").status)
        self.assertIn("known: begin", self.daemon.planning_mode(command="fly").status)
        self.assertTrue(self.daemon.planning_mode(command="begin", arm="gold").success)
        self.assertTrue(self.daemon.planning_mode(command="end").success)
        self.daemon.await_status("idle")
        self.assert_at(self.daemon.model, held, "the model is not back")
        refused = self.daemon.execute_plan(on_robot=True)
        self.assertEqual((refused.success, refused.status, refused.error_code), (False, "no_plan", -2))

    def test_5_a_stock_actionlib_client_plans_and_executes(self):
        client = actionlib.SimpleActionClient("move_arm", MoveArmAction)
        self.assertTrue(client.wait_for_server(rospy.Duration(20)))
        told = []
        goal = MoveArmGoal(on_robot=True, **plan_to(self.home))
        client.send_goal(goal, feedback_cb=told.append)
        self.daemon.await_status("armed", 20)
        self.press()
        self.assertTrue(client.wait_for_result(rospy.Duration(60)))
        result = client.get_result()
        self.assertEqual(client.get_state(), GoalStatus.SUCCEEDED, result)
        self.assertEqual((result.error_code, result.status, result.report.end), (SUCCESS, "finished", "finished"))
        self.assertIn("executing", [m.progress.status for m in told])
        errors = [m.robot_error for m in told if m.progress.status == "executing"]
        self.assertGreater(max(errors), 0.0)
        self.assertLess(max(errors), 0.02, "[m] deviation_limit plus the lag of the robot's state")
        of_model = [m.model_error for m in told if m.progress.status == "executing"]
        self.assertGreater(max(of_model), 0.0)
        self.assertNotEqual(of_model, errors, "model and robot have an error each")
        time.sleep(0.2)
        self.assert_at(self.daemon.robot, self.home, "the robot is not at the goal")

    def test_6_the_action_is_cancelled_while_it_waits_for_the_pedal(self):
        client = actionlib.SimpleActionClient("move_arm", MoveArmAction)
        self.assertTrue(client.wait_for_server(rospy.Duration(20)))
        client.send_goal(MoveArmGoal(on_robot=True, **plan_to(self.away)))
        self.daemon.await_status("armed", 20)
        client.cancel_goal()
        self.assertTrue(client.wait_for_result(rospy.Duration(5)))
        self.assertEqual(client.get_state(), GoalStatus.PREEMPTED)
        self.assertEqual((client.get_result().error_code, client.get_result().report.end), (PREEMPTED, "cancelled"))
        self.daemon.await_status("idle")
        # WHEN a goal makes no sense
        client.send_goal(MoveArmGoal(arm="third", default_goal=True))
        self.assertTrue(client.wait_for_result(rospy.Duration(5)))
        self.assertEqual((client.get_state(), client.get_result().error_code), (GoalStatus.ABORTED, -15))


if __name__ == "__main__":
    rostest.rosrun("raven2_trainer", "execute", Execute)
