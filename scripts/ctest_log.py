"""Reads what ctest leaves behind: of every test whether it passed, how long it took, and the check lines it printed."""

import collections
import os
import re
import sys

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


def read_lines(path):
    if not os.path.exists(path):
        return []
    with open(path, encoding="utf-8") as file:
        return find_checks(file.read())


def read_results(folder):
    """Every log of a folder, and the lines of tests that write them to the file `lines` instead of printing them. What
    was run again replaces what it was before."""
    runs = {}
    logs = [name for name in os.listdir(folder) if name.endswith(".log")]
    for name in sorted(logs, key=lambda name: (name.endswith(".again.log"), name)):
        runs.update(read_log(os.path.join(folder, name)))
    again = read_lines(os.path.join(folder, "lines.again"))
    replaced = {name_check(line) for line in again}
    first = [line for line in read_lines(os.path.join(folder, "lines")) if name_check(line) not in replaced]
    return runs, (*first, *again)


def name_check(line):
    return CHECK.match(line).group(1).split(".")[0]


def main():
    """Prints how many tests of the folder passed and failed; an error when none ran."""
    runs, _ = read_results(sys.argv[1])
    passed = sum(run.passed for run in runs.values())
    print(f"{passed} passed, {len(runs) - passed} failed")
    return not runs


if __name__ == "__main__":
    sys.exit(main())
