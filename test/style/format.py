"""Every C++ file is as clang-format leaves it. Argument: the clang-format to ask."""

import subprocess
import sys

from sources import cpp_files, finish


def main():
    paths = cpp_files()
    complaints = []
    for path in paths:
        formatted = subprocess.run([sys.argv[1], path], stdout=subprocess.PIPE, check=True).stdout.decode()
        for number, (ours, theirs) in enumerate(zip(path.read_text().splitlines(), formatted.splitlines()), 1):
            if ours != theirs:
                complaints.append((path, number, f"clang-format would write: {theirs}"))
                break
    finish(complaints, len(paths))


main()
