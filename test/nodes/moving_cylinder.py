#!/usr/bin/python3
"""A cylinder that a tracker follows pushes the trunk, whose tip is to stay where it is.

The trunk's way round the cylinder is longer, and cables cannot push: the tip is held nearer to the base than it hangs,
so that the trunk bows. Before each stroke it is bowed towards the cylinder, which then pushes its middle through to
the other side. At every place of the cylinder the tip can be where it should, so that every cycle counts.
"""

import unittest

import rospy
from geometry_msgs.msg import Point, Pose
from line import LineTest, Recorder, distance
from sinew.msg import ContactArray, ControllerState, EffectorTargets, TrackedObstacles

FRAME = "trunk_base"
STROKES = 3
NEARER = 0.02  # m
ASIDE = 0.05  # m to the side that the cylinder pushes to: on the way back from there the trunk bows to the other one
BOW = 0.015  # m of the middle
CONTACT_DISTANCE = 0.001  # m, of the robot's description
PATIENCE = 90.0  # s


def effector(state, name):
    return next(effector for effector in state.effectors if effector.name == name)


class MovingCylinder(LineTest):
    @classmethod
    def setUpClass(cls):
        cls.states = Recorder("controller_state", ControllerState)
        cls.plant = Recorder("plant/effectors", EffectorTargets)
        cls.contacts = Recorder("plant/contacts", ContactArray)
        cls.truth = Recorder("true_obstacles", TrackedObstacles)
        cls.targets = rospy.Publisher("targets", EffectorTargets, queue_size=10)
        direction = rospy.get_param("moving_obstacle/direction")
        length = sum(part * part for part in direction) ** 0.5
        cls.direction = [part / length for part in direction]

    def test_moving_cylinder(self):
        self.wait_for("control", lambda: self.states.newest()
                      and self.states.newest().status != ControllerState.DISABLED, PATIENCE)
        self.hanging = effector(self.states.newest(), "tip").position
        self.start = self.wait_for("the cylinder", self.truth.newest).pose[0].position
        strokes = []
        for _ in range(STROKES):
            self.bow()
            begin = self.wait_for("the cylinder to come", lambda: not self.is_waiting() and self.truth.all()[-1][0],
                                  PATIENCE)
            end = self.wait_for("the cylinder to go", lambda: self.is_waiting() and self.truth.all()[-1][0], PATIENCE)
            strokes.append((begin, end))
        self.judge(strokes)

    def is_waiting(self):
        return distance(self.truth.newest().pose[0].position, self.start) < 1e-4

    def along(self, point):
        """m on the cylinder's way."""
        return point.x * self.direction[0] + point.y * self.direction[1]

    def bow(self):
        self.send_tip(ASIDE)
        self.send_tip(0.0)
        self.wait_for("the trunk to bow", lambda: self.along(effector(self.states.newest(), "middle").position) < -BOW)
        self.assertTrue(self.is_waiting(), "the cylinder has moved before the trunk was bowed")

    def send_tip(self, aside):
        pose = Pose()
        pose.position = Point(self.hanging.x + aside * self.direction[0], self.hanging.y + aside * self.direction[1],
                              self.hanging.z - NEARER)
        pose.orientation.w = 1.0
        message = EffectorTargets()
        message.header.frame_id = FRAME
        message.name = ["tip"]
        message.pose = [pose]

        def rests():
            state = self.states.newest()
            tip = effector(state, "tip")
            if tip.targeted and distance(tip.target, pose.position) < 1e-6:
                return tip.error < 1e-4 and state.residual_relative < 1e-6
            self.targets.publish(message)

        self.wait_for("the tip", rests)

    def during(self, recorder, strokes):
        return [message for begin, end in strokes for when, message in recorder.since(begin) if when <= end]

    def judge(self, strokes):
        amplitude = rospy.get_param("moving_obstacle/amplitude")
        for stroke in strokes:
            self.judge_push(stroke, amplitude)
        states = self.during(self.states, strokes)
        held = sum(state.status == ControllerState.HELD for state in states)
        self.check("moving_cylinder.held_cycles", held, "<=", 0, "1")
        errors = [effector(state, "tip").error for state in states]
        proved = sum(state.contacts_global for state in states)
        print("cycles %d, searches proved %d" % (len(states), proved), flush=True)
        self.check("moving_cylinder.model_error_mean", 1e3 * sum(errors) / len(errors), "<=", 2.0, "mm")
        self.check("moving_cylinder.model_error_max", 1e3 * max(errors), "<=", 2.0, "mm")
        self.judge_plant(strokes)

    def judge_push(self, stroke, amplitude):
        furthest = max(distance(message.pose[0].position, self.start) for message in self.during(self.truth, [stroke]))
        self.check("moving_cylinder.stroke", 1e3 * furthest, ">=", 0.99e3 * amplitude, "mm")
        states = self.during(self.states, [stroke])
        middle = [self.along(effector(state, "middle").position) for state in states]
        self.check("moving_cylinder.middle_pushed", 1e3 * (max(middle) - middle[0]), ">=", 0.75e3 * amplitude, "mm")
        touching = sum(state.contacts > 0 for state in states)
        self.check("moving_cylinder.cycles_in_contact", touching, ">=", 0.5 * len(states), "1")

    def judge_plant(self, strokes):
        contacts = self.during(self.contacts, strokes)
        gaps = [contact.gap for message in contacts for contact in message.contacts]
        self.assertTrue(gaps, "the simulated body never came near the cylinder")
        penetration = max(0.0, -(min(gaps) + CONTACT_DISTANCE))
        self.check("moving_cylinder.plant_penetration", 1e3 * penetration, "<=", 1.5, "mm")
        forces = [sum(contact.force for contact in message.contacts) for message in contacts]
        self.check("moving_cylinder.plant_force", max(forces), ">=", 0.5, "N")
        target = effector(self.states.newest(), "tip").target
        errors = [distance(message.pose[message.name.index("tip")].position, target)
                  for message in self.during(self.plant, strokes)]
        print("plant error mean %.3f mm, largest %.3f mm" % (
            1e3 * sum(errors) / len(errors), 1e3 * max(errors)), flush=True)


if __name__ == "__main__":
    import rostest

    rospy.init_node("moving_cylinder")
    rostest.rosrun("sinew", "moving_cylinder", MovingCylinder)
