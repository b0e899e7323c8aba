"""Includes of the core: no ROS anywhere, a folder includes lower ones only, and CHOLMOD stays behind one file."""

import re

from sources import ROOT, cpp_files, finish

DIRECTLY_BELOW = {
    "common": (),
    "linalg": ("common",),
    "mesh": ("common",),
    "contact": ("mesh",),
    "solver": ("linalg",),
    "robot": ("common",),
    "fem": ("linalg", "mesh"),
    "body": ("fem",),
    "constraint": ("body", "robot"),
    "inverse": ("body", "constraint", "contact", "solver", "robot"),
    "hardware": ("robot",),
}
ROS = re.compile(r"(ros|rosbag|rosgraph_msgs|tf2?|tf2_ros|tf2_eigen|\w+_msgs|std_srvs|diagnostic_updater|interactive_markers|sinew)/\w+\.h$")
CHOLMOD_USER = "src/core/linalg/cholmod_cholesky.cpp"


def below(folder):
    lower = {folder}
    for name in DIRECTLY_BELOW[folder]:
        lower |= below(name)
    return lower


def folder_of(path):
    parts = path.relative_to(ROOT).parts
    return parts[2]


def complain(path, include):
    own = re.match(r"sinew/(\w+)/[\w/]+\.h$", include)
    if own:
        if own.group(1) not in DIRECTLY_BELOW:
            return f"{include}: no folder of the core"
        if own.group(1) not in below(folder_of(path)):
            return f"{include}: {folder_of(path)} lies below {own.group(1)}"
    elif ROS.match(include):
        return f"{include}: the core knows no ROS"
    elif include == "cholmod.h" and str(path.relative_to(ROOT)) != CHOLMOD_USER:
        return f"{include}: only {CHOLMOD_USER} may include it"
    return None


def main():
    complaints = []
    paths = cpp_files("include", "src/core")
    for path in paths:
        if folder_of(path) not in DIRECTLY_BELOW:
            complaints.append((path, 1, f"{folder_of(path)}: no folder of the core"))
            continue
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            include = re.match(r'\s*#\s*include\s*[<"]([^>"]+)[>"]', line)
            words = include and complain(path, include.group(1))
            if words:
                complaints.append((path, number, words))
    finish(complaints, len(paths))


main()
