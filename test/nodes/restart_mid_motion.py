#!/usr/bin/python3
"""The controller is killed at three points of a circle and comes back: nothing jumps, and the curve goes on."""

import os
import signal
import time

import rospy
from line import LineTest, Recorder, call, distance, find_pid, largest_step
from sinew.msg import ActuatorCommand, ActuatorState, ControllerState, EffectorTargets
from std_msgs.msg import Float64

RATE_MAX = 0.045  # m/s, of every cable
RATE = 100.0  # Hz
KILLS = [2.0, 6.0, 11.0]  # s along the circle


class RestartMidMotion(LineTest):
    @classmethod
    def setUpClass(cls):
        cls.states = Recorder("controller_state", ControllerState)
        cls.commands = Recorder("actuator_command", ActuatorCommand)
        cls.actuators = Recorder("actuator_state", ActuatorState)
        cls.plant = Recorder("plant/effectors", EffectorTargets)
        cls.time = Recorder("trajectory_time", Float64)

    def test_restart_mid_motion(self):
        for number, point in enumerate(KILLS):
            self.wait_for("%g s of the circle" % point, lambda: self.curve_time() >= point, 60)
            self.kill_and_come_back(number)
        self.check_commands()
        self.check_applied()

    def curve_time(self):
        newest = self.time.newest()
        return newest.data if newest else -1e9

    def kill_and_come_back(self, number):
        session = self.commands.newest().session
        curve_time = self.curve_time()
        pid = find_pid("inverse_model")
        now = time.monotonic()
        self.check("restart_mid_motion.tip_before_%d" % number, 1e3 * self.tip_travel(now - 0.2, now), ">=", 3.0, "mm")
        os.kill(pid, signal.SIGKILL)
        killed = time.monotonic()
        self.wait_for("the driver to hold", lambda: self.actuators.newest().driver_state == ActuatorState.HOLDING)
        answer = call("hardware_driver/recover")
        self.assertTrue(answer.success, answer.message)
        self.wait_for("a new session", lambda: self.commands.newest().session != session)
        back = next(t for t, command in self.commands.since(killed) if command.session != session)
        self.wait_for("the curve to go on", lambda: self.curve_time() > curve_time + 1.0)
        self.check("restart_mid_motion.away_%d" % number, back - killed, "<=", 10.0, "s")
        travel = 1e3 * self.tip_travel(killed, back)
        self.check("restart_mid_motion.tip_while_away_%d" % number, travel, "<=", 1.0, "mm")

    def tip_travel(self, begin, end):
        tips = [m.pose[m.name.index("tip")].position for t, m in self.plant.since(begin) if t <= end]
        return max(distance(tip, tips[0]) for tip in tips)

    def check_commands(self):
        step = 1e3 * RATE_MAX / RATE
        sessions = {}
        for receipt, command in self.commands.all():
            sessions.setdefault(command.session, []).append((receipt, command))
        self.check("restart_mid_motion.sessions", len(sessions), "==", len(KILLS) + 1, "1")
        for records in sessions.values():
            commands = [command for _, command in records]
            largest = 1e3 * largest_step(commands, lambda command: command.value)
            self.check("restart_mid_motion.commanded_step", largest, "<=", step * 1.001, "mm")

        for records in list(sessions.values())[1:]:  # the first one is older than this test
            self.check_first(records[0])

    def check_first(self, record):
        receipt, command = record
        before = [state for t, state in self.actuators.all() if t < receipt]
        measured = dict(zip(before[-1].name, before[-1].measured))
        jump = max(abs(value - measured[name]) for name, value in zip(command.name, command.value))
        self.check("restart_mid_motion.first_command", 1e3 * jump, "<=", 0.1, "mm")

    def check_applied(self):
        largest = 0.0
        records = self.actuators.all()
        for (_, before), (_, after) in zip(records, records[1:]):
            interval = (after.header.stamp - before.header.stamp).to_sec()
            if before.driver_state in (ActuatorState.OFF, ActuatorState.INITIALISING):
                continue
            step = max(abs(b - a) for a, b in zip(before.applied, after.applied))
            largest = max(largest, step / max(interval, 1 / RATE))
        self.check("restart_mid_motion.applied_rate", largest, "<=", RATE_MAX * 1.001, "m/s")


if __name__ == "__main__":
    import rostest

    rospy.init_node("restart_mid_motion")
    rostest.rosrun("sinew", "restart_mid_motion", RestartMidMotion)
