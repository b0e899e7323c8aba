# Sourced by the scripts: where things are, and an environment in which ROS builds and runs. Not a command.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=${SINEW_BUILD:-$root/build}
devel=${SINEW_DEVEL:-$root/devel}

# A conda or pyenv python ahead of the system's has no catkin_pkg, and a host name that nobody resolves stops ROS.
export PATH=/usr/bin:/usr/sbin:/bin:/sbin:$PATH
unset PYTHONHOME PYTHONPATH
export ROS_HOSTNAME=${ROS_HOSTNAME:-localhost}
export ROSCONSOLE_STDOUT_LINE_BUFFERED=1 PYTHONUNBUFFERED=1
# One thread for the dense kernels: the matrices of a robot are too small for more.
export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1
cores=$(env -u OMP_NUM_THREADS nproc)  # which would take that variable for the number of cores
[ -f /opt/ros/noetic/setup.bash ] && . /opt/ros/noetic/setup.bash

say() { printf '\n== %s\n' "$*"; }

fail() {
  printf '%s: %s\n' "${0##*/}" "$*" >&2
  exit 1
}

# Prints the comment block below the first line of the calling script.
print_help() { awk 'NR > 1 && /^#/ { sub(/^# ?/, ""); print; next } NR > 1 { exit }' "$0"; }

# Compiler processes at once: one a core, and 1.5 GB of memory for each.
count_jobs() {
  awk -v cores="$cores" '/^MemAvailable/ { jobs = int($2 / 1.5e6) } END {
    if (jobs > cores) jobs = cores
    print jobs < 1 ? 1 : jobs }' /proc/meminfo
}

# configure FOLDER DEVEL [CMAKE_OPTION...]: only where nothing is configured; CMake itself sees later changes.
configure() {
  local folder=$1 prefix=$2 options=("${@:3}")
  [ ! -f "$folder/build.ninja" ] && [ ! -f "$folder/Makefile" ] || return 0
  say "configuring $folder"
  mkdir -p "$folder"
  if command -v ccache >/dev/null; then options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
  cmake -S "$root" -B "$folder" -G Ninja -DCATKIN_DEVEL_PREFIX="$prefix" -DCMAKE_BUILD_TYPE=Release "${options[@]}" \
    >"$folder/configure.log" 2>&1 || {
    cat "$folder/configure.log" >&2
    fail "configuring failed"
  }
}

# compile FOLDER TARGET...: what is stale, with progress.
compile() {
  local folder=$1
  shift
  say "building in $folder"
  cmake --build "$folder" -j "$(count_jobs)" --target "$@"
}

use_devel() {
  set +u
  . "$devel/setup.bash"
  set -u
}
