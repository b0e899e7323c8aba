"""Reads what ctest leaves behind: of every test whether it passed, how long it took, and the check lines it printed."""

import collections
import os
import re

TestRun = collections.namedtuple("TestRun", "passed seconds lines")

CHECK = re.compile(r"^check=(\S+) value=(\S+) op=(<=|>=|==) bound=(\S+) unit=(\S+)")
NONE = TestRun(False, 0.0, ())


def find_checks(text):
    """Each line once: what a test prints may reach us twice."""
    return list(dict.fromkeys(line for line in text.splitlines() if CHECK.match(line)))


def read_log(path):
    """TestRun by name, from a LastTest.log."""
    with open(path, encoding="utf-8", errors="replace") as file:
        text = file.read()
    runs = {}
    for part in re.split(r"^\d+/\d+ Testing: ", text, flags=re.MULTILINE)[1:]:
        seconds = re.search(r"^Test time =\s*([\d.]+) sec", part, re.MULTILINE)
        runs[part.splitlines()[0].strip()] = TestRun(
            bool(re.search(r"^Test Passed\.", part, re.MULTILINE)),
            float(seconds.group(1)) if seconds else 0.0,
            tuple(find_checks(part)),
        )
    return runs


def read_results(folder):
    """Every log of a folder, and the lines of tests that write them to the file `lines` instead of printing them."""
    runs = {}
    for name in sorted(os.listdir(folder)):
        if name.endswith(".log"):
            runs.update(read_log(os.path.join(folder, name)))
    lines = ()
    path = os.path.join(folder, "lines")
    if os.path.exists(path):
        with open(path, encoding="utf-8") as file:
            lines = tuple(find_checks(file.read()))
    return runs, lines
