#!/usr/bin/python3
"""What stops the driver never waits for what it is about to do."""

import threading
import time

import rospy
from line import LineTest, Recorder, call
from sinew.msg import ActuatorState, SimulatedDevices
from std_msgs.msg import Bool

SOON = 2.0  # s, where homing takes thirty


class DriverServices(LineTest):
    @classmethod
    def setUpClass(cls):
        cls.states = Recorder("actuator_state", ActuatorState)
        cls.devices = Recorder("plant/devices", SimulatedDevices)
        cls.stop = rospy.Publisher("emergency_stop", Bool, queue_size=1, latch=True)

    def test_driver_services(self):
        self.wait_for("devices", lambda: self.devices.newest() and self.states.newest())
        self.interrupt("halt", lambda: call("hardware_driver/halt"))
        self.interrupt("emergency_stop", lambda: call("hardware_driver/emergency_stop"))
        self.interrupt("emergency_topic", lambda: self.stop.publish(True))
        self.assertTrue(self.states.newest().emergency_stop)
        for verb in ("init", "recover"):
            answer = call("hardware_driver/" + verb)
            self.assertFalse(answer.success, answer.message)
            self.assertIn("emergency stop is pressed", answer.message)
        self.wait_for("limp devices", lambda: not any(self.devices.newest().energised))
        self.stop.publish(False)
        self.wait_for("the stop to be let go of", lambda: not self.states.newest().emergency_stop)
        time.sleep(0.5)
        self.assertEqual(self.states.newest().driver_state, ActuatorState.SAFE, "letting go of it starts nothing")
        self.interrupt("shutdown", lambda: call("hardware_driver/shutdown"), ActuatorState.OFF)

    def interrupt(self, name, stop, state=ActuatorState.SAFE):
        answers = []
        homing = threading.Thread(target=lambda: answers.append(call("hardware_driver/init")))
        homing.start()
        self.wait_for("homing", lambda: self.states.newest().driver_state == ActuatorState.INITIALISING)
        time.sleep(0.5)
        begin = time.monotonic()
        stop()
        self.wait_for(name, lambda: self.states.newest().driver_state == state)
        self.check("driver_services." + name, time.monotonic() - begin, "<=", SOON, "s")
        homing.join(10)
        self.assertFalse(homing.is_alive(), "init answers when it has been interrupted")
        self.assertFalse(answers[0].success, answers[0].message)


if __name__ == "__main__":
    import rostest

    rospy.init_node("driver_services")
    rostest.rosrun("sinew", "driver_services", DriverServices)
