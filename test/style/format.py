"""Every C++ file is as clang-format leaves it. Argument: the clang-format to ask."""

import subprocess
import sys

from sources import cpp_files


def main():
    paths = cpp_files()
    result = subprocess.run([sys.argv[1], "--dry-run", "-Werror", *paths], check=False)
    print(f"{len(paths)} files")
    sys.exit(0 if paths and result.returncode == 0 else 1)


main()
