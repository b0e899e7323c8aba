"""What the style tests share: the project's files, and how a complaint looks."""

import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = ("include", "src", "test", "benchmark")
CPP = (".cpp", ".h")


def cpp_files(*folders):
    return [
        path
        for folder in folders or FOLDERS
        for path in sorted((ROOT / folder).rglob("*"))
        if path.suffix in CPP
    ]


def cmake_files():
    own = [ROOT / "CMakeLists.txt", *sorted((ROOT / "cmake").glob("*.cmake"))]
    return own + [path for folder in FOLDERS for path in sorted((ROOT / folder).rglob("CMakeLists.txt"))]


def python_files():
    scripts = [path for path in sorted((ROOT / "scripts").rglob("*")) if path.is_file()]
    return sorted(ROOT.glob("src/**/*.py")) + sorted(ROOT.glob("test/**/*.py")) + [
        path for path in scripts if path.suffix == ".py" or path.read_bytes().startswith(b"#!/usr/bin/env python3")
    ]


def finish(complaints, count):
    """Prints every complaint (path, line, words) and ends the test."""
    for path, line, words in complaints:
        print(f"{path.relative_to(ROOT)}:{line}: {words}")
    print(f"{count} files, {len(complaints)} complaints")
    sys.exit(1 if complaints or not count else 0)
