"""Gathers the lines of the benchmarks: prints them as tables, keeps them in a file, and says which of them miss a bound.
Called by scripts/benchmark.

usage: benchmark_report.py LINES BUILD [--json FILE] [--check] [--whole]

--check: bounds on times too; --whole: a bound that nothing was measured for is missed. The exit code is 1 when one is.
"""

import argparse
import datetime
import json
import os
import platform
import shlex
import shutil
import subprocess
import sys

sys.dont_write_bytecode = True

from benchmark_bounds import judge_all
from benchmark_rows import STAGES, list_scenes, pick, read_line, write_file

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PLANT = "_plant"  # ends the name of a scene's simulated robot
SAMPLE = "src/core/inverse/inverse_controller.cpp"  # whose compile flags stand for all


def ask(*command):
    if not shutil.which(command[0]):
        return ""
    result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, cwd=ROOT, check=False)
    return result.stdout.decode().strip()


def find_value(path, key, separator):
    """The first value of a key in a file of lines; empty without it."""
    if not os.path.exists(path):
        return ""
    with open(path, encoding="utf-8", errors="replace") as file:
        for line in file:
            name, _, value = line.partition(separator)
            if name.strip() == key:
                return value.strip().strip('"')
    return ""


def read_compile_command(build):
    """(compiler, flags) of the sample."""
    path = os.path.join(build, "compile_commands.json")
    if not os.path.exists(path):
        return "", ""
    with open(path, encoding="utf-8") as file:
        commands = {entry["file"]: shlex.split(entry["command"]) for entry in json.load(file)}
    words = next((words for name, words in commands.items() if name.endswith(SAMPLE)), [])
    compilers = [word for word in words if os.path.basename(word).split("-")[0] in ("c++", "g++", "clang++", "gcc", "clang")]
    flags = [word for word in words if word.startswith(("-O", "-m", "-std", "-g", "-ffast", "-fsanitize")) or word == "-DNDEBUG"]
    return compilers[0] if compilers else "", " ".join(flags)


def name_commit():
    commit = ask("git", "log", "-1", "--format=%h of %cs")
    return (commit + (" with changes" if ask("git", "status", "--porcelain") else "")) or "unknown"


def make_header(build):
    compiler, flags = read_compile_command(build)
    return {
        "date": datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%d %H:%M UTC"),
        "machine": f"{find_value('/etc/os-release', 'PRETTY_NAME', '=') or platform.system()}, {platform.machine()}",
        "cpu": find_value("/proc/cpuinfo", "model name", ":") or platform.processor() or "unknown",
        "cores": os.cpu_count(),
        "compiler": (ask(compiler, "--version").splitlines() or ["unknown"])[0] if compiler else "unknown",
        "flags": flags,
        "commit": name_commit(),
    }


def format_value(value):
    if value is None:
        return "-"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def format_time(value):
    return "-" if value is None else f"{value:.2f}"


def print_table(names, rows):
    """Texts in columns: the first to the left, the others to the right."""
    widths = [max(len(row[k]) for row in [names, *rows]) for k in range(len(names))]
    for row in [names, *rows]:
        cells = [text.ljust(width) if k == 0 else text.rjust(width) for k, (text, width) in enumerate(zip(row, widths))]
        print("  ".join(cells).rstrip())


def print_cycles(rows):
    """A line a scene, a column a stage; the step of its simulated robot is one more."""
    names = ["median ms", "dofs", "contacts", "most", "pressing", *STAGES, "p99", "plant", "thesis", "ratio"]
    plants = {row["scene"]: row["median_ms"] for row in rows if row["scene"].endswith(PLANT)}
    table = []
    for cycle in (row for row in rows if row["stage"] == "cycle" and row["scene"] not in plants):
        same = [row for row in pick(rows, cycle["scene"]) if all(row.get(k) == cycle.get(k) for k in ("dofs", "contacts"))]
        medians = {row["stage"]: row["median_ms"] for row in same}
        thesis = cycle.get("thesis_ms")
        sizes = [cycle.get(name) for name in ("dofs", "contacts", "contacts_max", "pressing")]
        times = [medians.get(stage) for stage in STAGES] + [cycle["p99_ms"], plants.get(cycle["scene"] + PLANT), thesis]
        ratio = f"{thesis / cycle['median_ms']:.1f}" if thesis else "-"
        table.append([cycle["scene"], *map(format_value, sizes), *map(format_time, times), ratio])
    print_table(names, table)


def print_others(rows):
    """A table for each scene that has no stages."""
    for scene in list_scenes(rows):
        own = pick(rows, scene)
        names = [name for name in own[0] if name != "scene"]
        print()
        print_table([scene, *names], [["", *(format_value(row.get(name)) for name in names)] for row in own])


def print_bounds(findings):
    """Whether all are kept; those that are not, line by line."""
    missed = [finding for finding in findings if not finding.ok]
    print()
    for finding in missed:
        print(f"missed: {finding.text}")
    print(f"{len(findings) - len(missed)} of {len(findings)} bounds kept")
    return not missed


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("lines")
    parser.add_argument("build")
    parser.add_argument("--json")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--whole", action="store_true")
    arguments = parser.parse_args()
    with open(arguments.lines, encoding="utf-8") as file:
        rows = [row for row in map(read_line, file) if row]
    if not rows:
        sys.exit("benchmark: nothing was measured")
    if arguments.json:
        write_file(arguments.json, make_header(arguments.build), rows)
    staged = [row for row in rows if "stage" in row]
    print()
    if staged:
        print_cycles(staged)
    print_others([row for row in rows if "stage" not in row])
    findings = judge_all(rows, arguments.check, arguments.whole)
    if findings and not print_bounds(findings):
        sys.exit(1)
    if arguments.check and not findings:
        sys.exit("benchmark: none of these scenes has a bound")


if __name__ == "__main__":
    main()
