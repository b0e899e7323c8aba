#!/usr/bin/python3
"""Any node is killed at any moment: the devices are safe in their own time, and the robot comes back with recover."""

import os
import random
import signal
import time

import rospy
from geometry_msgs.msg import Pose
from line import LineTest, Recorder, call, find_pid
from sinew.msg import ActuatorState, ControllerState, EffectorTargets, SimulatedDevices
from std_srvs.srv import Trigger

KILLS = 100 if "SINEW_FULL" in os.environ else 20
SEED = 1
NODES = ["inverse_model", "hardware_driver", "simulated_robot", "visualization"]
COMMAND_TIMEOUT = 0.1  # s, these four of config/trunk/hardware.yaml
HOLD_LIMIT = 2.0  # s
RELAX_TIME = 1.0  # s
BUS_WATCHDOG = 0.2  # s
LATE = 0.25  # s that a busy machine may take to notice, and to tell
RATE_MAX = 0.045  # m/s, of every cable
TAKES_COMMANDS = (ActuatorState.READY, ActuatorState.ACTIVE, ActuatorState.HOLDING)


class KillNode(LineTest):
    @classmethod
    def setUpClass(cls):
        cls.random = random.Random(SEED)
        cls.states = Recorder("controller_state", ControllerState)
        cls.actuators = Recorder("actuator_state", ActuatorState)
        cls.devices = Recorder("plant/devices", SimulatedDevices)
        cls.targets = rospy.Publisher("targets", EffectorTargets, queue_size=1)

    def test_kill_node(self):
        worst = {}
        self.wait_for("the robot to be controlled", self.controlled, 90)
        order = [NODES[n % len(NODES)] for n in range(KILLS)]
        self.random.shuffle(order)
        for number, node in enumerate(order):
            self.lead(0.5 + self.random.random())
            self.come_back()  # a busy machine may have stopped it by itself
            took = self.kill(node)
            worst[node] = max(worst.get(node, 0.0), took)
            print("kill %d of %d: %s, safe after %.3f s" % (number + 1, KILLS, node, took), flush=True)
            self.come_back()
        for node, took in sorted(worst.items()):
            self.check("kill_node.%s" % node, took, "<=", self.bound(node), "s")
        self.check("kill_node.kills", KILLS, ">=", 20, "1")
        self.check("kill_node.fastest", 1e3 * self.fastest(), "<=", 1e3 * 1.3 * RATE_MAX, "mm/s")

    @staticmethod
    def bound(node):
        if node == "inverse_model":  # holding at once, let go in the end
            return COMMAND_TIMEOUT + HOLD_LIMIT + RELAX_TIME + LATE
        if node == "hardware_driver":
            return BUS_WATCHDOG + LATE
        return LATE  # nothing that moves depends on it, or there is nothing left that could

    # --- Killing ---

    def kill(self, node):
        """Kills, and gives the time [s] until the devices are safe."""
        pid = find_pid(node)
        respawned = lambda: self.pid_of(node) not in (None, pid)
        killed = time.monotonic()
        os.kill(pid, signal.SIGKILL)
        if node == "inverse_model":
            took = self.until_relaxed(killed, respawned)
        elif node == "hardware_driver":
            took = self.until(killed, self.limp)
        else:
            took = 0.0
        self.wait_for("%s to be started again" % node, respawned, 30)
        return took

    def until(self, begin, condition):
        self.wait_for("safe devices", condition, 10)
        return time.monotonic() - begin

    def until_relaxed(self, begin, respawned):
        """Holding is safe as long as somebody comes back in time; if nobody does, the driver lets go."""
        safe = lambda: self.driver_state() in (ActuatorState.HOLDING, ActuatorState.SAFE)
        took = self.until(begin, safe)
        self.assertLessEqual(took, COMMAND_TIMEOUT + LATE, "holding")
        if self.random.random() < 0.5:
            return took  # recovers in mid-motion
        return self.until(begin, lambda: self.driver_state() == ActuatorState.SAFE and self.limp())

    def limp(self):
        newest = self.devices.newest()
        return newest is not None and not any(newest.energised)

    # --- Coming back ---

    def come_back(self):
        """By recover alone, of the driver; the simulated launch enables its controller by itself."""
        end = time.monotonic() + 60
        while not self.controlled():
            self.assertLess(time.monotonic(), end, "the robot did not come back: " + self.actuators.newest().reason)
            state = self.driver_state()
            if state not in (ActuatorState.INITIALISING, ActuatorState.ACTIVE):
                self.recover()
            time.sleep(0.3)

    def recover(self):
        try:
            rospy.wait_for_service("hardware_driver/recover", 5)
            before = self.devices.newest()
            rospy.ServiceProxy("hardware_driver/recover", Trigger)()
            self.assertIsNotNone(before)
        except (rospy.ServiceException, rospy.ROSException):
            pass  # it may be dying or being born

    def controlled(self):
        now = time.monotonic()
        fresh = [m for _, m in self.states.since(now - 0.5)]
        driven = [m for _, m in self.actuators.since(now - 0.5)]
        seen = self.devices.since(now - 0.5)
        enabled = fresh and fresh[-1].status in (ControllerState.TRACKING, ControllerState.DEGRADED)
        return bool(
            enabled
            and driven
            and seen
            and driven[-1].driver_state == ActuatorState.ACTIVE
            and all(seen[-1][1].energised)
        )

    # --- The rest ---

    def driver_state(self):
        newest = self.actuators.newest()
        return newest.driver_state if newest else None

    def pid_of(self, node):
        try:
            return find_pid(node)
        except Exception:  # not registered yet, or no longer there
            return None

    def lead(self, seconds):
        """Keeps the robot moving between two points."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            message = EffectorTargets()
            message.header.frame_id = "trunk_base"
            message.name = ["tip"]
            pose = Pose()
            side = 1 if int(time.monotonic()) % 2 else -1
            pose.position.x, pose.position.z, pose.orientation.w = 0.02 * side, 0.19, 1.0
            message.pose = [pose]
            self.targets.publish(message)
            time.sleep(0.05)

    def fastest(self):
        """m/s of any cable while its motor was on, over 50 ms."""
        worst = 0.0
        records = self.devices.all()
        for (_, a), (_, b) in zip(records, records[5:]):
            time_between = (b.header.stamp - a.header.stamp).to_sec()
            if not 0.03 < time_between < 0.2 or not all(a.energised) or not all(b.energised):
                continue
            worst = max([worst] + [abs(y - x) / time_between for x, y in zip(a.value, b.value)])
        return worst


if __name__ == "__main__":
    import rostest

    rospy.init_node("kill_node")
    rostest.rosrun("sinew", "kill_node", KillNode)
