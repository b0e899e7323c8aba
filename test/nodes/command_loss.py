#!/usr/bin/python3
"""The controller is gone for good: the driver holds, then relaxes, in its own times, and says why."""

import os
import signal
import time

import rospy
from line import LineTest, Recorder, find_pid, largest_step
from sinew.msg import ActuatorCommand, ActuatorState, BodyState
from std_msgs.msg import Float64

COMMAND_TIMEOUT = 0.1  # s, these three of config/trunk/hardware.yaml
HOLD_LIMIT = 2.0  # s
RELAX_TIME = 1.0  # s
LIMP_TENSION = 0.5  # N that the gear of a limp simulated servo holds by its friction
CYCLE = 0.05  # s that the driver may take to notice on a busy machine


class CommandLoss(LineTest):
    @classmethod
    def setUpClass(cls):
        cls.commands = Recorder("actuator_command", ActuatorCommand)
        cls.actuators = Recorder("actuator_state", ActuatorState)
        cls.body = Recorder("plant/body_state", BodyState)
        cls.time = Recorder("trajectory_time", Float64)

    def test_command_loss(self):
        self.wait_for("the circle", lambda: self.time.newest() and self.time.newest().data > 2, 60)
        tension = max(self.actuators.newest().effort)
        self.check("command_loss.tension_before", tension, ">=", 0.5, "N")
        os.kill(find_pid("inverse_model"), signal.SIGKILL)
        self.wait_for("the safe state", lambda: self.actuators.newest().driver_state == ActuatorState.SAFE, 10)
        time.sleep(RELAX_TIME + 0.5)

        last_command = self.commands.all()[-1][0]
        holding = self.first(ActuatorState.HOLDING, last_command)
        safe = self.first(ActuatorState.SAFE, last_command)
        self.check_near("command_loss.time_to_hold", holding[0] - last_command, COMMAND_TIMEOUT)
        self.check_near("command_loss.time_to_relax", safe[0] - holding[0], HOLD_LIMIT)
        for _, state in (holding, safe):
            print("reason: " + state.reason, flush=True)
            self.assertIn("command", state.reason)

        held = [m for t, m in self.actuators.since(holding[0]) if m.driver_state == ActuatorState.HOLDING]
        self.check("command_loss.step_while_holding", 1e3 * largest_step(held, lambda m: m.applied), "<=", 1e-6, "mm")
        relaxed = self.actuators.newest()
        self.assertEqual(relaxed.driver_state, ActuatorState.SAFE)
        self.check("command_loss.current_relaxed", max(abs(current) for current in relaxed.current), "<=", 0.003, "A")
        tensions = self.body.newest().cable_tension
        self.check("command_loss.tension_relaxed", max(tensions), "<=", LIMP_TENSION + 0.1, "N")

    def first(self, driver_state, begin):
        return next((t, m) for t, m in self.actuators.since(begin) if m.driver_state == driver_state)

    def check_near(self, name, value, expected):
        self.check(name, value, ">=", expected - 0.02, "s")
        self.check(name, value, "<=", expected + CYCLE, "s")


if __name__ == "__main__":
    import rostest

    rospy.init_node("command_loss")
    rostest.rosrun("sinew", "command_loss", CommandLoss)
