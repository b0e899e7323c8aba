#!/usr/bin/python3
"""A paused or jumping clock, a replayed bag and a second controller move nothing that should not move."""

import os
import subprocess
import tempfile
import time

import rosbag
import rospy
from geometry_msgs.msg import PoseStamped
from line import LineTest, Recorder, distance
from rosgraph_msgs.msg import Clock
from sinew.msg import ActuatorCommand, ActuatorState, ControllerState, EffectorTargets

START = 1000.0  # s, where the clock stands
STILL = 1e-6  # m that a set point may move when nothing should
TIP_STILL = 1e-4  # m
MESSAGES = 100


class CommandAuthority(LineTest):
    @classmethod
    def setUpClass(cls):
        cls.states = Recorder("controller_state", ControllerState)
        cls.commands = Recorder("actuator_command", ActuatorCommand)
        cls.actuators = Recorder("actuator_state", ActuatorState)
        cls.plant = Recorder("plant/effectors", EffectorTargets)
        cls.clock = rospy.Publisher("/clock", Clock, queue_size=1, latch=True)
        cls.intruder = rospy.Publisher("actuator_command", ActuatorCommand, queue_size=200)
        cls.targets = rospy.Publisher("target_pose", PoseStamped, queue_size=10)

    def test_command_authority(self):
        self.set_clock(START)
        self.wait_for("control", lambda: self.states.newest() and self.states.newest().status == 1, 60)
        self.wait_for("an active driver", lambda: self.actuators.newest().driver_state == ActuatorState.ACTIVE)
        time.sleep(1.0)
        self.watch("paused_clock", lambda: time.sleep(2.0))
        self.check_rate()
        self.watch("jumping_clock", self.jump_clock)
        self.watch("stamps", self.send_targets_with_wrong_stamps)
        self.watch("second_controller", self.send_foreign_commands, rejected=MESSAGES)
        self.watch("replayed_bag", self.replay_bag, rejected=MESSAGES)
        self.move_on_purpose()

    def set_clock(self, seconds):
        self.clock.publish(Clock(clock=rospy.Time.from_sec(seconds)))
        time.sleep(0.1)

    def jump_clock(self):
        for seconds in (START + 5, START, START - 5, START):
            self.set_clock(seconds)
            time.sleep(0.3)

    def check_rate(self):
        cycles = [state.cycle for _, state in self.states.since(time.monotonic() - 1.0)]
        self.check("command_authority.cycles_in_a_second_of_paused_clock", cycles[-1] - cycles[0], ">=", 90, "1")

    def watch(self, name, action, rejected=0):
        """Nothing moves during `action`, the driver stays active, and `rejected` commands are refused by session."""
        begin = time.monotonic()
        before = self.actuators.newest()
        session = self.commands.newest().session
        action()
        self.wait_for("%d refused commands" % rejected,
                      lambda: self.actuators.newest().rejected_session - before.rejected_session >= rejected, 10)
        time.sleep(0.3)
        states = [state for _, state in self.actuators.since(begin)]
        travel = max(abs(a - b) for state in states for a, b in zip(state.applied, before.applied))
        self.check("command_authority.%s.applied" % name, 1e3 * travel, "<=", 1e3 * STILL, "mm")
        tips = [m.pose[m.name.index("tip")].position for _, m in self.plant.since(begin)]
        tip = max(distance(tips[0], other) for other in tips)
        self.check("command_authority.%s.tip" % name, 1e3 * tip, "<=", 1e3 * TIP_STILL, "mm")
        self.check("command_authority.%s.rejected" % name,
                   states[-1].rejected_session - before.rejected_session, "==", rejected, "1")
        self.assertTrue(all(state.driver_state == ActuatorState.ACTIVE for state in states))
        self.assertTrue(all(state.session == session for state in states))

    def send_targets_with_wrong_stamps(self):
        for offset in (5.0, -5.0):
            self.targets.publish(self.make_target(rospy.Time.from_sec(START + offset)))
            time.sleep(0.3)

    def make_target(self, stamp):
        tip = self.tip_position()
        target = PoseStamped()
        target.header.frame_id = "trunk_base"
        target.header.stamp = stamp
        target.pose.position.x = tip.x + 0.02
        target.pose.position.y = tip.y
        target.pose.position.z = tip.z
        target.pose.orientation.w = 1.0
        return target

    def tip_position(self):
        return next(e.position for e in self.states.newest().effectors if e.name == "tip")

    def make_foreign_commands(self):
        own = self.commands.newest()
        commands = []
        for i in range(MESSAGES):
            command = ActuatorCommand()
            command.header.stamp = rospy.Time.from_sec(START)
            command.session = own.session ^ 0x5a5a5a5a
            command.sequence = own.sequence + 1000 + i
            command.name = own.name
            command.mode = own.mode
            command.value = [value + 0.01 for value in own.value]
            commands.append(command)
        return commands

    def send_foreign_commands(self):
        for command in self.make_foreign_commands():
            self.intruder.publish(command)
            time.sleep(0.01)

    def replay_bag(self):
        handle, path = tempfile.mkstemp(suffix=".bag")
        os.close(handle)
        try:
            with rosbag.Bag(path, "w") as bag:
                for i, command in enumerate(self.make_foreign_commands()):
                    bag.write(self.intruder.resolved_name, command, rospy.Time.from_sec(START + 0.01 * i))
            subprocess.run(["rosbag", "play", "-q", "--wait-for-subscribers", path], stdin=subprocess.DEVNULL,
                           stdout=subprocess.DEVNULL, check=True, timeout=30)
        finally:
            os.remove(path)

    def move_on_purpose(self):
        """The line is alive all the while: a good target moves the robot, clock paused."""
        target = self.make_target(rospy.Time.from_sec(START))
        self.targets.publish(target)
        self.wait_for("the tip at its target",
                      lambda: distance(self.plant.newest().pose[0].position, target.pose.position) < 0.01, 5)


if __name__ == "__main__":
    import rostest

    rospy.init_node("command_authority")
    rostest.rosrun("sinew", "command_authority", CommandAuthority)
