"""What the black-box tests of the whole line share: results, waiting, recording."""

import os
import threading
import time
import unittest
import xmlrpc.client

import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from std_srvs.srv import Trigger

OPERATORS = {
    "<=": lambda value, bound: value <= bound,
    ">=": lambda value, bound: value >= bound,
    "==": lambda value, bound: value == bound,
}


class Recorder:
    """Every message of a topic with its receipt on the steady clock [s], oldest first."""

    def __init__(self, topic, kind):
        self.lock = threading.Lock()
        self.records = []
        self.subscriber = rospy.Subscriber(topic, kind, self.receive, queue_size=1000, tcp_nodelay=True)

    def receive(self, message):
        with self.lock:
            self.records.append((time.monotonic(), message))

    def since(self, begin):
        with self.lock:
            return [record for record in self.records if record[0] >= begin]

    def all(self):
        return self.since(0.0)

    def newest(self):
        with self.lock:
            return self.records[-1][1] if self.records else None


class Diagnostics:
    """The newest diagnostics of every part, by name."""

    def __init__(self):
        self.lock = threading.Lock()
        self.parts = {}
        self.subscriber = rospy.Subscriber("/diagnostics", DiagnosticArray, self.receive, queue_size=100)

    def receive(self, message):
        with self.lock:
            for status in message.status:
                self.parts[status.name] = status

    def value(self, part, key):
        with self.lock:
            for name, status in self.parts.items():
                if name.endswith(part):
                    for entry in status.values:
                        if entry.key == key:
                            return entry.value
        return None


class LineTest(unittest.TestCase):
    def check(self, name, value, operator, bound, unit):
        line = "check=%s value=%.6g op=%s bound=%.6g unit=%s" % (name, value, operator, bound, unit)
        print(line, flush=True)
        results = os.environ.get("SINEW_RESULTS")
        if results:
            with open(results, "a") as file:
                file.write(line + "\n")
        self.assertTrue(OPERATORS[operator](value, bound), line)

    def wait_for(self, what, condition, timeout=20.0):
        """By the steady clock, whatever /clock does."""
        end = time.monotonic() + timeout
        while time.monotonic() < end:
            result = condition()
            if result:
                return result
            time.sleep(0.01)
        self.fail("waited %g s in vain for: %s" % (timeout, what))


def find_pid(node):
    """Process id of the node, asked of the node itself."""
    caller = rospy.get_name()
    uri = rosgraph.Master(caller).lookupNode(rospy.resolve_name(node))
    code, message, pid = xmlrpc.client.ServerProxy(uri).getPid(caller)
    assert code == 1, message
    return pid


def call(service):
    rospy.wait_for_service(service, 10)
    return rospy.ServiceProxy(service, Trigger)()


def largest_step(messages, values):
    """Largest change of any entry of values(message) from one message to the next, 0 for fewer than two."""
    largest = 0.0
    for before, after in zip(messages, messages[1:]):
        for a, b in zip(values(before), values(after)):
            largest = max(largest, abs(b - a))
    return largest


def distance(a, b):
    return ((a.x - b.x) ** 2 + (a.y - b.y) ** 2 + (a.z - b.z) ** 2) ** 0.5
