#!/usr/bin/python3
"""A cylinder that a tracker follows pushes the trunk, whose tip is to stay where it is.

The trunk's way round the cylinder is longer, and cables cannot push: the tip is held a little nearer to the base than it
hangs, so that there is something to give away.
"""

import unittest

import rospy
from geometry_msgs.msg import Point, Pose
from line import LineTest, Recorder, distance
from sinew.msg import ActiveLimit, ContactArray, ControllerState, EffectorTargets, TrackedObstacles

FRAME = "trunk_base"
STROKES = 3
NEARER = 0.02  # m
CONTACT_DISTANCE = 0.001  # m, of the robot's description
PATIENCE = 90.0  # s


def limited(state):
    """Whether a limit keeps the tip from its target; a slack cable does not."""
    return any(limit.kind != ActiveLimit.EFFORT_MIN for limit in state.limits)


def tip(state):
    return next(effector for effector in state.effectors if effector.name == "tip")


class MovingCylinder(LineTest):
    @classmethod
    def setUpClass(cls):
        cls.states = Recorder("controller_state", ControllerState)
        cls.plant = Recorder("plant/effectors", EffectorTargets)
        cls.contacts = Recorder("plant/contacts", ContactArray)
        cls.truth = Recorder("true_obstacles", TrackedObstacles)
        cls.targets = rospy.Publisher("targets", EffectorTargets, queue_size=10)

    def test_moving_cylinder(self):
        amplitude = rospy.get_param("moving_obstacle/amplitude")
        speed = rospy.get_param("moving_obstacle/speed")
        dwell = rospy.get_param("moving_obstacle/dwell")
        self.wait_for("control", lambda: self.states.newest()
                      and self.states.newest().status != ControllerState.DISABLED, PATIENCE)
        self.send_target(tip(self.states.newest()).position)
        self.wait_for("the tip", lambda: tip(self.states.newest()).targeted and tip(self.states.newest()).error < 1e-4)
        start = self.wait_for("the cylinder", self.truth.newest).pose[0].position
        self.assertEqual(self.find_begin(start), None, "the cylinder has moved before the tip was there")
        begin = self.wait_for("the cylinder to move", lambda: self.find_begin(start))
        stroke = 2 * (amplitude / speed + dwell)
        self.wait_for("the strokes", lambda: self.truth.all()[-1][0] > begin + STROKES * stroke, PATIENCE)
        self.judge(begin, start, amplitude)

    def send_target(self, position):
        message = EffectorTargets()
        message.header.frame_id = FRAME
        message.name = ["tip"]
        pose = Pose()
        pose.position = Point(position.x, position.y, position.z - NEARER)
        pose.orientation.w = 1.0
        message.pose = [pose]
        self.targets.publish(message)

    def find_begin(self, start):
        return next((when for when, message in self.truth.all()
                     if distance(message.pose[0].position, start) > 1e-4), None)

    def judge(self, begin, start, amplitude):
        states = [state for _, state in self.states.since(begin)]
        furthest = max(distance(message.pose[0].position, start) for _, message in self.truth.since(begin))
        self.check("moving_cylinder.stroke", 1e3 * furthest, ">=", 0.99e3 * amplitude, "mm")
        touching = [state for state in states if state.contacts > 0]
        self.check("moving_cylinder.cycles_in_contact", len(touching), ">=", 0.3 * len(states), "1")
        held = sum(state.status == ControllerState.HELD for state in states)
        self.check("moving_cylinder.held_cycles", held, "<=", 0, "1")

        free = [tip(state).error for state in states if not limited(state)]
        print("cycles %d, within limits %d, in contact %d, worst error of all %.3f mm, searches proved %d" % (
            len(states), len(free), len(touching), 1e3 * max(tip(state).error for state in states),
            sum(state.contacts_global for state in touching)), flush=True)
        self.check("moving_cylinder.cycles_within_limits", len(free), ">=", 0.3 * len(states), "1")
        self.check("moving_cylinder.model_error_mean", 1e3 * sum(free) / len(free), "<=", 2.0, "mm")
        self.check("moving_cylinder.model_error_max", 1e3 * max(free), "<=", 2.0, "mm")
        self.judge_plant(begin)

    def judge_plant(self, begin):
        gaps = [contact.gap for _, message in self.contacts.since(begin) for contact in message.contacts]
        self.assertTrue(gaps, "the simulated body never came near the cylinder")
        penetration = max(0.0, -(min(gaps) + CONTACT_DISTANCE))
        self.check("moving_cylinder.plant_penetration", 1e3 * penetration, "<=", 1.0, "mm")
        forces = [sum(contact.force for contact in message.contacts) for _, message in self.contacts.since(begin)]
        target = tip(self.states.newest()).target
        errors = [distance(message.pose[message.name.index("tip")].position, target)
                  for _, message in self.plant.since(begin)]
        self.check("moving_cylinder.plant_force", max(forces), ">=", 0.5, "N")
        print("plant error mean %.3f mm, largest %.3f mm" % (
            1e3 * sum(errors) / len(errors), 1e3 * max(errors)), flush=True)


if __name__ == "__main__":
    import rostest

    rospy.init_node("moving_cylinder")
    rostest.rosrun("sinew", "moving_cylinder", MovingCylinder)
