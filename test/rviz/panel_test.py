#!/usr/bin/python3
"""Somebody operates a robot with the mouse alone: rviz on a display that nobody sees, and real clicks on the panel."""

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import numpy
import rospy
from sinew.msg import ActuatorState, ControllerState
from std_msgs.msg import Bool

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "nodes"))
from line import LineTest, Recorder, find_pid

PROGRAMS = ("Xvfb", "xdotool", "import", "rviz")
MISSING = [program for program in PROGRAMS if not shutil.which(program)]
WIDTH, HEIGHT = 1200, 900  # px, the window of the robots' rviz files

STOP_LOOSE = (0xD8, 0x1E, 0x1E)
STOP_PRESSED = (0x6E, 0x0D, 0x0D)
GOOD = (32, 135, 75)
STALE = (140, 146, 156)
BADGE = 1000  # px that a badge has of its colour at least

BUTTONS = ("Init", "Recover", "Halt", "Enable", "Disable")  # in a row above the stop
STOP_BORDER, SPACING, BUTTON_HEIGHT, TEXT = 3, 6, 28, 40  # px
DARK = 80  # brightest channel of a text that is black
STILL = 1.0  # s in which nothing may happen


class Screen:
    """A display with rviz on it."""

    def __init__(self, display_config):
        self.home = tempfile.mkdtemp()
        read, write = os.pipe()
        self.server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write), "-screen", "0", "%dx%dx24" % (WIDTH, HEIGHT), "+extension", "GLX",
             "-nolisten", "tcp"], pass_fds=(write,), stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as pipe:
            number = pipe.readline().strip()
        self.environment = dict(os.environ, DISPLAY=":" + number, HOME=self.home)
        self.rviz = subprocess.Popen(["rviz", "-d", display_config], env=self.environment)

    def close(self):
        for process in (self.rviz, self.server):
            process.kill()
            process.wait()
        shutil.rmtree(self.home, ignore_errors=True)

    def look(self):
        """Pixels, height x width x 3."""
        raw = subprocess.run(["import", "-silent", "-window", "root", "-depth", "8", "rgb:-"], env=self.environment,
                             stdout=subprocess.PIPE, check=True).stdout
        return numpy.frombuffer(raw, dtype=numpy.uint8).reshape(HEIGHT, WIDTH, 3)

    def mouse(self, *arguments):
        subprocess.run(["xdotool", *map(str, arguments)], env=self.environment, check=True)


def where(picture, colour):
    return numpy.argwhere((picture == numpy.array(colour)).all(axis=2))


def box(pixels):
    """Left, top, right and bottom pixel."""
    top, left = pixels.min(axis=0)
    bottom, right = pixels.max(axis=0)
    return left, top, right, bottom


@unittest.skipIf(MISSING, "not installed: " + ", ".join(MISSING))
class Panel(LineTest):
    @classmethod
    def setUpClass(cls):
        cls.actuators = Recorder("actuator_state", ActuatorState)
        cls.controller = Recorder("controller_state", ControllerState)
        cls.stop = Recorder("emergency_stop", Bool)
        cls.screen = Screen(rospy.get_param("~display_config"))

    @classmethod
    def tearDownClass(cls):
        cls.screen.close()

    def tearDown(self):
        for name, recorder in (("driver", self.actuators), ("controller", self.controller)):
            print("the %s's last reason: %s" % (name, recorder.newest() and recorder.newest().reason), flush=True)

    def test_panel(self):
        self.find_the_stop()
        self.start()
        self.stop_and_recover()
        self.halt_and_initialise()
        self.disable()
        self.lose_the_driver()

    def find_the_stop(self):
        self.wait_for("the panel", lambda: self.seen(STOP_LOOSE) > 10000, 90)
        self.left, self.top, self.right, self.bottom = box(where(self.screen.look(), STOP_LOOSE))
        self.assertEqual(self.stop.newest(), None, "nobody has pressed the emergency stop yet")

    def start(self):
        self.wait_for_state(ActuatorState.OFF, 60)
        self.assertLess(self.seen(GOOD), BADGE)
        self.click("Init")
        self.wait_for_state(ActuatorState.READY)
        self.click("Enable")
        self.wait_for_state(ActuatorState.ACTIVE)
        self.wait_for_status(ControllerState.TRACKING)
        self.wait_for("two green badges", lambda: self.seen(GOOD) > 2 * BADGE)

    def stop_and_recover(self):
        self.move_to_stop()
        self.screen.mouse("mousedown", 1)
        self.wait_for("the stop, with the mouse still down", lambda: self.stop.newest() and self.stop.newest().data)
        self.wait_for_state(ActuatorState.SAFE)
        self.screen.mouse("mouseup", 1)
        self.wait_for("the pressed stop", lambda: self.seen(STOP_PRESSED) > 10000 and not self.seen(STOP_LOOSE))
        self.wait_for("no green badge", lambda: self.seen(GOOD) < BADGE)
        self.assertFalse(self.is_enabled("Recover"))
        self.screen.mouse("mousemove", *self.middle_of("Recover"), "click", 1)
        time.sleep(STILL)
        self.assertTrue(self.stop.newest().data, "letting go of the mouse lets go of nothing")
        self.assertTrue(self.actuators.newest().emergency_stop)
        self.assertEqual(self.actuators.newest().driver_state, ActuatorState.SAFE, "nothing recovers from a pressed stop")

        self.move_to_stop()
        self.screen.mouse("click", 1)
        self.wait_for("the end of the stop", lambda: not self.stop.newest().data)
        self.wait_for("the loose stop", lambda: self.seen(STOP_LOOSE) > 10000)
        time.sleep(STILL)
        self.assertEqual(self.actuators.newest().driver_state, ActuatorState.SAFE, "letting go moves nothing")
        self.click("Recover")
        self.wait_for_state(ActuatorState.READY)
        self.assertEqual([message.data for _, message in self.stop.all()], [True, False])

    def halt_and_initialise(self):
        self.click("Halt")
        self.wait_for_state(ActuatorState.SAFE)
        self.assertIn("halted", self.actuators.newest().reason)
        self.assertFalse(self.actuators.newest().emergency_stop)
        self.click("Init")
        self.wait_for_state(ActuatorState.READY)

    def disable(self):
        self.click("Enable")
        self.wait_for_state(ActuatorState.ACTIVE)
        self.click("Disable")
        self.wait_for_status(ControllerState.DISABLED)
        self.wait_for_state(ActuatorState.HOLDING)
        self.click("Recover")
        self.wait_for_state(ActuatorState.READY)

    def lose_the_driver(self):
        self.wait_for("a green badge", lambda: self.seen(GOOD) > BADGE)
        os.kill(find_pid("hardware_driver"), signal.SIGKILL)
        self.wait_for("a driver that is not shown as ready", lambda: self.seen(GOOD) < BADGE and self.seen(STALE) > BADGE)
        self.assertGreater(self.seen(STOP_LOOSE), 10000)

    # --- Eyes and hands ---

    def seen(self, colour):
        return len(where(self.screen.look(), colour))

    def move_to_stop(self):
        self.screen.mouse("mousemove", (self.left + self.right) // 2, (self.top + self.bottom) // 2)

    def click(self, button):
        self.wait_for("the button %s to be black on white" % button, lambda: self.is_enabled(button))
        self.screen.mouse("mousemove", *self.middle_of(button), "click", 1)

    def is_enabled(self, button):
        """By its text, which is grey otherwise."""
        x, y = self.middle_of(button)
        text = self.screen.look()[y - BUTTON_HEIGHT // 4 : y + BUTTON_HEIGHT // 4, x - TEXT // 2 : x + TEXT // 2]
        return text.max(axis=2).min() < DARK

    def middle_of(self, button):
        pitch = (self.right - self.left + 1 + 2 * STOP_BORDER + SPACING) / len(BUTTONS)
        x = self.left - STOP_BORDER + (BUTTONS.index(button) + 0.5) * pitch - SPACING / 2
        return int(x), int(self.top - STOP_BORDER - SPACING - BUTTON_HEIGHT // 2)

    def wait_for_state(self, state, timeout=20.0):
        self.wait_for("driver state %d" % state,
                      lambda: self.actuators.newest() and self.actuators.newest().driver_state == state, timeout)

    def wait_for_status(self, status):
        self.wait_for("controller status %d" % status,
                      lambda: self.controller.newest() and self.controller.newest().status == status)


if __name__ == "__main__":
    import rostest

    rospy.init_node("panel_test")
    rostest.rosrun("sinew", "panel_test", Panel)
