#!/usr/bin/env python3
"""Listens to a running robot while its targets go along a curve, and ends with a table of how well it followed.

usage: tracking_recorder.py [--duration S] [--out FILE]   (in the robot's namespace: __ns:=trunk)
"""

import argparse
import collections
import math
import sys
import time

import rospy
from sinew.msg import ControllerState, EffectorTargets
from std_msgs.msg import Float64

RECENT = 100  # targets, one a cycle, that count as the path just gone along
SILENCE = 60.0  # s without an enabled controller, after which nobody is there


def distance(a, b):
    return math.sqrt((a.x - b.x) ** 2 + (a.y - b.y) ** 2 + (a.z - b.z) ** 2)


def mean(values):
    return sum(values) / len(values) if values else math.nan


def quantile(values, share):
    """The value that `share` of all lie below or at."""
    if not values:
        return math.nan
    return sorted(values)[max(math.ceil(share * len(values)), 1) - 1]


class TrackingRecorder:
    """Errors count while the curve is run through, that is, at trajectory times of 0 and more; cycles always."""

    def __init__(self):
        self.on_curve = False
        self.enabled_since = None  # s, steady
        self.targets = collections.defaultdict(lambda: collections.deque(maxlen=RECENT))  # by effector
        self.first = self.last = None  # (receipt s, state)
        self.model_errors, self.plant_errors, self.path_errors = [], [], []  # m
        self.cycles = []  # s
        options = {"queue_size": 1000, "tcp_nodelay": True}
        rospy.Subscriber("trajectory_time", Float64, self.on_time, **options)
        rospy.Subscriber("controller_state", ControllerState, self.on_state, **options)
        rospy.Subscriber("plant/effectors", EffectorTargets, self.on_plant, **options)

    def on_time(self, message):
        self.on_curve = message.data >= 0

    def on_state(self, state):
        if state.status == ControllerState.DISABLED:
            return
        self.last = (time.monotonic(), state)
        if self.first is None:
            self.first = self.last
            self.enabled_since = self.last[0]
        self.cycles += [stage.last for stage in state.stages if stage.stage == "cycle"]
        for effector in state.effectors:
            if effector.targeted:
                self.targets[effector.name].append(effector.target)
                if self.on_curve:
                    self.model_errors.append(effector.error)

    def on_plant(self, message):
        if not self.on_curve:
            return
        for name, pose in zip(message.name, message.pose):
            if name in self.targets:
                distances = [distance(pose.position, target) for target in self.targets[name]]
                self.plant_errors.append(distances[-1])
                self.path_errors.append(min(distances))

    def rate(self):
        """Hz: cycles counted by the controller over the time between their receipts."""
        if self.first is None or self.last[0] == self.first[0]:
            return math.nan
        return (self.last[1].cycle - self.first[1].cycle) / (self.last[0] - self.first[0])

    def deadline_misses(self):
        return self.last[1].deadline_misses - self.first[1].deadline_misses if self.first else math.nan

    def write_table(self, file):
        file.write("%-34s %9s %9s %9s\n" % ("", "mean", "99 %", "largest"))
        for name, values in (
            ("error of the model, mm", self.model_errors),
            ("error of the simulated robot, mm", self.plant_errors),
            ("its distance from the path, mm", self.path_errors),
            ("computation of a cycle, ms", self.cycles),
        ):
            row = (name, 1e3 * mean(values), 1e3 * quantile(values, 0.99), 1e3 * quantile(values, 1))
            file.write("%-34s %9.3f %9.3f %9.3f\n" % row)
        for name, value in (
            ("tracking_error_model_mm", 1e3 * mean(self.model_errors)),
            ("tracking_error_plant_mm", 1e3 * mean(self.plant_errors)),
            ("rate_hz", self.rate()),
            ("deadline_misses", self.deadline_misses()),
            ("cycle_median_ms", 1e3 * quantile(self.cycles, 0.5)),
            ("cycle_p99_ms", 1e3 * quantile(self.cycles, 0.99)),
        ):
            file.write("%s=%.3f\n" % (name, value))

    def complete(self):
        return bool(self.model_errors and self.plant_errors)


def wait(recorder, duration):
    """Until the duration is over, counted from the enabled controller on."""
    begin = time.monotonic()
    while not rospy.is_shutdown():
        now = time.monotonic()
        if recorder.enabled_since is None:
            if now - begin > SILENCE:
                print("no enabled controller on %s" % rospy.resolve_name("controller_state"), file=sys.stderr)
                return
        elif duration and now - recorder.enabled_since >= duration:
            return
        time.sleep(0.05)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--duration", type=float, default=0, help="s from the enabled controller on; 0: until the end")
    parser.add_argument("--out", help="file of the table; standard output otherwise")
    arguments = parser.parse_args(rospy.myargv()[1:])
    rospy.init_node("tracking_recorder", anonymous=True)
    recorder = TrackingRecorder()
    wait(recorder, arguments.duration)
    if arguments.out:
        with open(arguments.out, "w") as file:
            recorder.write_table(file)
    else:
        recorder.write_table(sys.stdout)
    return 0 if recorder.complete() else 1


if __name__ == "__main__":
    sys.exit(main())
