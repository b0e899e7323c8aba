#!/usr/bin/python3
"""The trunk on its rail is brought through between two cylinders by the launch file that is shipped."""

import rospy
from line import LineTest, Recorder, distance
from sensor_msgs.msg import JointState
from sinew.msg import ControllerState, EffectorTargets

PATIENCE = 90.0  # s
DEEP = 0.12  # m of travel, when the tip is behind the cylinders
APPROACH = 1.5  # s from the first motion, in which the tip goes to where the path begins


def tip(state):
    return next(effector for effector in state.effectors if effector.name == "tip")


def travel(state):
    return state.displacement[state.actuator.index("rail")]


class TrunkRail(LineTest):
    @classmethod
    def setUpClass(cls):
        cls.states = Recorder("controller_state", ControllerState)
        cls.plant = Recorder("plant/effectors", EffectorTargets)
        cls.joints = Recorder("joint_states", JointState)

    def test_trunk_rail(self):
        self.wait_for("control", lambda: self.states.newest() and travel(self.states.newest()) > 0.005, PATIENCE)
        begin = self.states.all()[-1][0] + APPROACH
        self.wait_for("the tip to be through", lambda: travel(self.states.newest()) > DEEP, PATIENCE)
        touched = self.wait_for("the cylinders to be leant on", lambda: self.states.newest().contacts, PATIENCE)
        self.assertGreater(touched, 0)
        self.wait_for("the way back", lambda: travel(self.states.newest()) < DEEP, PATIENCE)
        self.judge(begin)

    def judge(self, begin):
        states = [state for _, state in self.states.since(begin)]
        held = sum(state.status == ControllerState.HELD for state in states)
        errors = [tip(state).error for state in states]
        self.check("trunk_rail_line.held_cycles", held, "<=", 0, "1")
        self.check("trunk_rail_line.model_error_max", 1e3 * max(errors), "<=", 1.0, "mm")
        target = tip(self.states.newest()).target
        pose = self.plant.newest().pose[self.plant.newest().name.index("tip")]
        self.check("trunk_rail_line.plant_error", 1e3 * distance(pose.position, target), "<=", 2.0, "mm")
        shown = self.joints.newest()
        self.assertEqual(shown.name, ["rail"])
        self.assertLess(abs(shown.position[0] - travel(self.states.newest())), 0.01)


if __name__ == "__main__":
    import rostest

    rospy.init_node("trunk_rail")
    rostest.rosrun("sinew", "trunk_rail", TrunkRail)
