#!/usr/bin/python3
"""Poses of obstacles: good ones are believed, bad ones refused whole and counted, and a lost obstacle stops the robot."""

import math
import threading
import time
import unittest

import rospy
from geometry_msgs.msg import Point, Pose, Quaternion, TransformStamped, Vector3
from line import Diagnostics, LineTest, Recorder, call, distance
from sinew.msg import ControllerState, EffectorTargets, TrackedObstacles
from tf2_msgs.msg import TFMessage

FRAME = "finger_base"
HOME = Point(0.0, 0.06, 0.07)  # m, clear of the finger
HEIGHT = 0.06  # m of the finger's base above the world
RATE = 50.0  # Hz


class Tracker:
    """Reports the post at its place, again and again, while it sees it."""

    def __init__(self, publisher):
        self.publisher = publisher
        self.seen = threading.Event()
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def run(self):
        while True:
            self.seen.wait()
            self.publisher.publish(make())
            time.sleep(1 / RATE)


def make(position=HOME, names=("post",), poses=1, present=1, frame=FRAME, age=0.0, turn=(0.0, 0.0, 0.0, 1.0)):
    message = TrackedObstacles()
    message.header.frame_id = frame
    if age is not None:
        message.header.stamp = rospy.Time.now() - rospy.Duration(age)
    message.name = list(names)
    message.pose = [Pose(position, Quaternion(*turn)) for _ in range(poses)]
    message.present = [True] * present
    return message


class ObstacleInput(LineTest):
    @classmethod
    def setUpClass(cls):
        cls.states = Recorder("controller_state", ControllerState)
        cls.believed = Recorder("obstacles", TrackedObstacles)
        cls.diagnostics = Diagnostics()
        cls.targets = rospy.Publisher("targets", EffectorTargets, queue_size=10)
        cls.tracked = rospy.Publisher("tracked_obstacles", TrackedObstacles, queue_size=10)
        cls.transforms = rospy.Publisher("/tf", TFMessage, queue_size=10)
        cls.tracker = Tracker(cls.tracked)

    def test_obstacle_input(self):
        self.wait_for("the controller", self.states.newest)
        self.wait_for("connections", lambda: min(p.get_num_connections() for p in (self.targets, self.tracked)) > 0)
        self.start()
        self.assert_good()
        self.assert_frame_is_followed()
        self.tracker.seen.set()
        self.wait_for("the tracker to be believed", lambda: self.is_post_at(HOME))
        self.assert_bad()
        self.assert_outlier()
        self.assert_lost()

    def start(self):
        post = self.wait_for("what the controller believes", self.believed.newest)
        self.assertEqual(post.name, ["post", "table"])
        self.assertLess(distance(post.pose[0].position, Point(0.0, 0.026, 0.07)), 1e-9, "the description's place")
        answer = call("inverse_model/enable")
        self.assertTrue(answer.success, answer.message)
        message = EffectorTargets()
        message.header.frame_id = FRAME
        message.name = ["tip"]
        message.pose = [Pose(self.states.newest().effectors[0].position, Quaternion(0, 0, 0, 1))]
        self.targets.publish(message)
        self.wait_for("control", lambda: self.states.newest().effectors[0].targeted)

    def post(self):
        message = self.believed.newest()
        return message.pose[0], message.present[0]

    def is_post_at(self, position, tolerance=1e-6):
        pose, present = self.post()
        return present and distance(pose.position, position) < tolerance

    def assert_good(self):
        near = Point(0.0, 0.05, 0.07)
        self.tracked.publish(make(near, age=None))
        self.wait_for("a pose without a stamp", lambda: self.is_post_at(near), 1.0)
        time.sleep(0.6)  # forgotten: the next pose may be anywhere
        self.tracked.publish(make(Point(0.0, 0.055, 0.07 + HEIGHT), frame="world"))
        self.wait_for("a pose in another frame", lambda: self.is_post_at(Point(0.0, 0.055, 0.07)), 1.0)
        absent = make(Point(math.nan, 0.0, 0.0))
        absent.present = [False]
        self.tracked.publish(absent)
        self.wait_for("the post to be absent", lambda: not self.post()[1], 1.0)
        time.sleep(0.8)
        self.assertEqual(self.states.newest().status, ControllerState.TRACKING, "what is absent cannot be lost")
        self.tracked.publish(make())
        self.wait_for("the post to be back", lambda: self.is_post_at(HOME), 1.0)

    def assert_frame_is_followed(self):
        there = Point(0.01, 0.07, 0.07)

        def send_and_look():
            frame = TransformStamped()
            frame.header.frame_id = FRAME
            frame.header.stamp = rospy.Time.now()
            frame.child_frame_id = "seen_post"
            frame.transform.translation = Vector3(there.x, there.y, there.z)
            frame.transform.rotation.w = 1.0
            self.transforms.publish(TFMessage([frame]))
            time.sleep(1 / RATE)
            return self.is_post_at(there, 1e-4)

        self.wait_for("a frame of tf to be followed", send_and_look, 5.0)
        time.sleep(0.6)

    def assert_bad(self):
        self.assert_refused("wrong_size", make(poses=2))
        self.assert_refused("wrong_size", make(present=0))
        self.assert_refused("wrong_size", make(names=(), poses=0, present=0))
        self.assert_refused("unknown_name", make(names=("lamp",)))
        self.assert_refused("duplicate_name", make(names=("post", "post"), poses=2, present=2))
        self.assert_refused("not_tracked", make(names=("post", "table"), poses=2, present=2))
        self.assert_refused("not_finite", make(Point(0.0, math.nan, 0.07)))
        self.assert_refused("not_finite", make(turn=(0.0, math.inf, 0.0, 1.0)))
        self.assert_refused("orientation", make(turn=(0.0, 0.0, 0.0, 0.0)))
        self.assert_refused("unknown_frame", make(frame="nowhere"))
        self.assert_refused("unknown_frame", make(frame=""))
        self.assert_refused("stamp", make(age=5.0))
        self.assert_refused("stamp", make(age=-5.0))
        self.assert_refused("jump", make(Point(2000.0, 0.0, 0.0)))

    def count(self, part, key):
        value = self.diagnostics.value(part, key)
        return int(value) if value is not None else 0

    def assert_refused(self, reason, message):
        self.assert_counted("inputs", "obstacles refused: " + reason, message)
        self.assertTrue(self.diagnostics.value("inputs", "obstacles last refused"))

    def assert_counted(self, part, key, message):
        before = self.count(part, key)
        begin = time.monotonic()
        self.tracked.publish(message)
        self.wait_for("one more of: " + key, lambda: self.count(part, key) == before + 1, 5.0)
        for _, believed in self.believed.since(begin):
            self.assertLess(distance(believed.pose[0].position, HOME), 1e-6, key)
        for _, state in self.states.since(begin):
            self.assertEqual(state.status, ControllerState.TRACKING, key)
            self.assertTrue(all(math.isfinite(value) for value in state.displacement))

    def assert_outlier(self):
        far = Point(HOME.x, HOME.y + 0.1, HOME.z)
        self.assert_counted("obstacles", "post outliers", make(far))
        self.assertEqual(self.diagnostics.value("obstacles", "post"), "present")

    def assert_lost(self):
        self.tracker.seen.clear()
        begin = time.monotonic()
        self.wait_for("the post to be lost", lambda: self.states.newest().status == ControllerState.HELD, 2.0)
        self.check("obstacle_input.time_until_held", time.monotonic() - begin, "<=", 0.8, "s")
        held = self.states.newest()
        self.assertIn("post", held.reason)
        self.wait_for("diagnostics", lambda: self.diagnostics.value("obstacles", "post") == "lost", 3.0)
        later = self.states.newest()
        drift = max(abs(a - b) for a, b in zip(held.displacement, later.displacement))
        self.check("obstacle_input.drift_while_held", 1e3 * drift, "<=", 0.05, "mm")
        self.assertTrue(self.is_post_at(HOME), "the last pose stays")
        self.tracker.seen.set()
        self.wait_for("control by itself", lambda: self.states.newest().status == ControllerState.TRACKING, 1.0)
        self.assertTrue(self.states.newest().effectors[0].targeted)


if __name__ == "__main__":
    import rostest

    rospy.init_node("obstacle_input")
    rostest.rosrun("sinew", "obstacle_input", ObstacleInput)
