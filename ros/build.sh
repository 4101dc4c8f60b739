#!/bin/sh
# Builds the messages and the launch package into build/catkin (or the folder given); quiet, and nothing to do the second time.
# Then: . build/catkin/devel/setup.sh
# Needs Debian's catkin, ros-message-generation, lib{std,actionlib}-msgs-dev and ros-{std,actionlib}-msgs.
set -eu
root=$(CDPATH= cd -- "$(dirname -- "$0")/.." && pwd)
space=${1:-$root/build/catkin}
stamp=$space/.built
log=$space/build.log

if ! command -v catkin_make >/dev/null 2>&1; then
    echo "ros/build.sh: catkin_make is missing: install Debian's ROS packages first (catkin, ros-message-generation)." >&2
    exit 3
fi

# The scripts are linked, not built: a change of them needs no build.
if [ -f "$stamp" ] && [ -f "$space/devel/setup.sh" ] && [ "$(cat "$stamp")" = "$root" ] &&
    [ -z "$(find "$root/ros" -newer "$stamp" \( -name '*.msg' -o -name '*.srv' -o -name '*.action' \
        -o -name '*.xml' -o -name CMakeLists.txt -o -name build.sh -o -type d \) -print -quit)" ]; then
    exit 0
fi

mkdir -p "$space/src"
for package in end_effector_msgs end_effector_hal; do
    ln -sfn "$root/ros/$package" "$space/src/$package"
done
echo "building the ROS messages into $space" >&2
# Only Python is generated; Debian's interpreter, whatever stands first in PATH.
if ! ROS_LANG_DISABLE=gencpp:genlisp catkin_make -C "$space" -DPYTHON_EXECUTABLE=/usr/bin/python3 \
    -DCATKIN_ENABLE_TESTING=OFF >"$log" 2>&1; then
    grep -m 1 -A 8 -E '^CMake Error|[Ee]rror:' "$log" >&2 || tail -n 15 "$log" >&2
    echo "ros/build.sh: catkin_make failed; the whole log: $log" >&2
    exit 1
fi
echo "$root" >"$stamp"
