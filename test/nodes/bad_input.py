#!/usr/bin/python3
"""Bad targets are refused whole, counted by reason and named; good ones work at once afterwards."""

import math
import time
import unittest

import rospy
from geometry_msgs.msg import Pose, PoseStamped
from line import Diagnostics, LineTest, Recorder, call, distance
from sinew.msg import ActuatorState, ControllerState, EffectorTargets, TrackedObstacles

FRAME = "trunk_base"


class BadInput(LineTest):
    @classmethod
    def setUpClass(cls):
        cls.states = Recorder("controller_state", ControllerState)
        cls.diagnostics = Diagnostics()
        cls.targets = rospy.Publisher("targets", EffectorTargets, queue_size=10)
        cls.poses = rospy.Publisher("target_pose", PoseStamped, queue_size=10)
        cls.obstacles = rospy.Publisher("tracked_obstacles", TrackedObstacles, queue_size=10)
        cls.actuators = rospy.Publisher("actuator_state", ActuatorState, queue_size=10)

    def test_bad_input(self):
        self.wait_for("the controller", lambda: self.states.newest())
        publishers = [self.targets, self.poses, self.obstacles, self.actuators]
        self.wait_for("connections", lambda: all(p.get_num_connections() > 0 for p in publishers))
        self.assertEqual(self.states.newest().status, ControllerState.DISABLED)
        answer = call("inverse_model/enable")
        self.assertTrue(answer.success, answer.message)
        self.wait_for("control", lambda: self.states.newest().status == ControllerState.TRACKING)
        time.sleep(0.2)

        held = self.states.newest()
        self.assertFalse(any(effector.targeted for effector in held.effectors))
        time.sleep(0.5)
        drift = max(abs(a - b) for a, b in zip(held.displacement, self.states.newest().displacement))
        self.check("bad_input.drift_without_target", 1e3 * drift, "<=", 1e-3, "mm")

        self.home = {effector.name: effector.position for effector in held.effectors}
        self.assert_good(0.001)
        self.assert_refused("not_finite", self.make(dx=math.nan))
        self.assert_refused("not_finite", self.make(dx=math.inf))
        self.assert_refused("jump", self.make(dx=0.03))
        self.assert_refused("unknown_frame", self.make(frame="nowhere"))
        self.assert_refused("unknown_frame", self.make(frame=""))
        self.assert_refused("stamp", self.make(age=5.0))
        self.assert_refused("stamp", self.make(age=-5.0))
        self.assert_refused("wrong_size", self.make(names=["tip", "middle"], poses=1))
        self.assert_refused("wrong_size", self.make(names=[], poses=0))
        self.assert_refused("duplicate_name", self.make(names=["tip", "tip"], poses=2))
        self.assert_refused("unknown_name", self.make(names=["tip", "nose"], poses=2))
        self.assert_pose_refused()
        self.assert_driver_refused()
        self.assert_obstacle_refused()
        self.assert_good(0.002, age=None)

    def make(self, dx=0.0, names=("tip",), poses=1, frame=FRAME, age=0.0):
        message = EffectorTargets()
        message.header.frame_id = frame
        if age is not None:
            message.header.stamp = rospy.Time.now() - rospy.Duration(age)
        message.name = list(names)
        for i in range(poses):
            pose = Pose()
            pose.orientation.w = 1.0
            home = self.home[names[i] if names[i] in self.home else "tip"]
            pose.position.x, pose.position.y, pose.position.z = home.x + dx, home.y, home.z
            message.pose.append(pose)
        return message

    def tip(self):
        return next(e for e in self.states.newest().effectors if e.name == "tip")

    def assert_good(self, dx, age=0.0):
        message = self.make(dx=dx, age=age)
        begin = time.monotonic()
        self.targets.publish(message)
        self.wait_for("the target to be taken",
                      lambda: self.tip().targeted and distance(self.tip().target, message.pose[0].position) < 1e-9, 1.0)
        self.check("bad_input.good_target_taken", time.monotonic() - begin, "<=", 0.5, "s")

    def count(self, reason, of="targets"):
        value = self.diagnostics.value("inputs", "%s refused: %s" % (of, reason))
        return int(value) if value is not None else 0

    def assert_refused(self, reason, message):
        self.assert_counted(reason, lambda: self.targets.publish(message))

    def assert_pose_refused(self):
        pose = PoseStamped()
        pose.header.frame_id = FRAME
        pose.pose.position.x = math.nan
        self.assert_counted("not_finite", lambda: self.poses.publish(pose))

    def assert_driver_refused(self):
        state = ActuatorState()
        state.name = ["cable_1"]
        self.assert_counted("wrong_size", lambda: self.actuators.publish(state), of="actuator state")

    def assert_obstacle_refused(self):
        message = TrackedObstacles()
        message.header.frame_id = FRAME
        message.name = ["cylinder"]
        message.pose = [Pose()]
        self.assert_counted("wrong_size", lambda: self.obstacles.publish(message), of="obstacles")
        message.present = [True]
        self.assert_counted("unknown_name", lambda: self.obstacles.publish(message), of="obstacles")

    def assert_counted(self, reason, publish, of="targets"):
        before = self.count(reason, of)
        target = self.tip().target
        begin = time.monotonic()
        publish()
        self.wait_for("the refusal to be counted: " + reason, lambda: self.count(reason, of) == before + 1, 5.0)
        self.assertTrue(self.diagnostics.value("inputs", of + " last refused"))
        for _, state in self.states.since(begin):
            tip = next(e for e in state.effectors if e.name == "tip")
            self.assertLess(distance(tip.target, target), 1e-12)
            self.assertEqual(state.status, ControllerState.TRACKING)
            self.assertTrue(all(math.isfinite(value) for value in state.displacement))


if __name__ == "__main__":
    import rostest

    rospy.init_node("bad_input")
    rostest.rosrun("sinew", "bad_input", BadInput)
