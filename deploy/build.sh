#!/bin/sh
# Puts the project into one folder that needs no source any more: a Python environment with the wheel, the locked
# dependencies and the extras modbus, page and recordings (figures are drawn elsewhere), the messages and launch files as a
# ROS install space in PREFIX/ros, and PREFIX/bin/eehal-hal; where ROS 2 is sourced: for ROS 2, with PREFIX/bin/eehal-hal-ros2.
# Usage: deploy/build.sh [PREFIX]     default: /opt/eehal; what stands there is replaced.
# DESTDIR: built below this folder, used as PREFIX (deploy/package.sh).
# Needs the packages of debian-packages.txt (deploy/debian.sh); ROS is left out where catkin is not installed. For ROS 2:
# colcon, and python3-venv.
# ROS=2: for ROS 2 by its wheels (the image), which need no ROS 2 on the machine; x86-64 only.
# TARGETARCH=arm64 (Docker's variable): for that architecture, made on any.
set -eu
root=$(CDPATH= cd -- "$(dirname -- "$0")/.." && pwd)
installed=${1:-/opt/eehal}
prefix=${DESTDIR:-}$installed
native=$(dpkg --print-architecture 2>/dev/null || true)
target=${TARGETARCH:-$native}
case $target in
"$native") platform= ;;
amd64) platform='--python-platform x86_64-manylinux_2_28' ;;
arm64) platform='--python-platform aarch64-manylinux_2_28' ;;
*) echo "There are no Python wheels for $target: TARGETARCH is amd64 or arm64" >&2; exit 2 ;;
esac
group='' sites=--system-site-packages
if [ "${ROS:-}" = 2 ]; then
    [ "$target" = amd64 ] || { echo "There are no wheels of ROS 2 for $target: ROS=2 is for amd64" >&2; exit 2; }
    # Debian's packages of ROS 1 have the same import names
    group='--group ros2-wheels' sites=''
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
[ ! -e "$prefix" ] || [ -f "$prefix/pyvenv.cfg" ] || { echo "$prefix exists and was not made by this script" >&2; exit 2; }
rm -rf "$prefix"

# Debian's interpreter, and its packages, or rospy is missing; the environment's own packages win.
/usr/bin/python3 -m venv "$work/uv"
"$work/uv/bin/pip" install -q --disable-pip-version-check 'uv>=0.5,<1'
# shellcheck disable=SC2086
"$work/uv/bin/uv" venv -q --relocatable $sites -p /usr/bin/python3 "$prefix"
cd "$root"
# shellcheck disable=SC2086
VIRTUAL_ENV='' UV_PROJECT_ENVIRONMENT=$prefix UV_LINK_MODE=copy \
    "$work/uv/bin/uv" sync -q --frozen --no-dev --extra modbus --extra page --extra recordings \
    --no-editable --reinstall-package end-effector-hal $group $platform -p /usr/bin/python3
# The parser's tables, beside the bytecode
"$prefix/bin/python" -c 'from timed_automata.language import parse_system; from timed_automata.document import Text
parse_system(Text.plain("system a;", ""))'
# Compiled here: its users may not write there. An interpreter of another architecture reads the same.
compiled() { "$prefix/bin/python" -m compileall -q -s "${DESTDIR:-}" -p / "$@"; }
compiled "$prefix"/lib/python3*/site-packages
rm -f "$prefix/.lock" "$prefix/.gitignore"
mkdir -p "$prefix/share/doc"
cp docs/how-to/deployment.md docs/how-to/wiring.md SAFETY.md "$prefix/share/doc/"

if [ "${ROS:-}" = 2 ]; then
    "$prefix/bin/python" ros/wheels/build_messages.py ros/end_effector_msgs
    compiled "$prefix"/lib/python3*/site-packages/end_effector_msgs
    mkdir "$prefix/ros"
    echo "export ROS_VERSION=2 AMENT_PREFIX_PATH=$installed" >"$prefix/ros/setup.bash"
    install -m 755 deploy/eehal-hal-ros2 deploy/container/eehal-container deploy/container/eehal-healthy "$prefix/bin/"
elif [ "${ROS_VERSION:-}" = 2 ]; then
    colcon --log-base "$work/log" build --merge-install --install-base "$prefix/ros" --build-base "$work/build" \
        --base-paths ros/end_effector_msgs ros/end_effector_hal >"$work/colcon.log" 2>&1 ||
        { tail -n 20 "$work/colcon.log" >&2; exit 1; }
    install -m 755 deploy/eehal-hal-ros2 "$prefix/bin/"
elif command -v catkin_make >/dev/null 2>&1; then
    mkdir -p "$work/ws/src"
    ln -s "$root/ros/end_effector_msgs" "$root/ros/end_effector_hal" "$work/ws/src/"
    # only Python is generated
    ROS_LANG_DISABLE=gencpp:genlisp catkin_make -C "$work/ws" -DPYTHON_EXECUTABLE=/usr/bin/python3 \
        -DCATKIN_ENABLE_TESTING=OFF "-DCMAKE_INSTALL_PREFIX=$installed/ros" install >"$work/catkin.log" 2>&1 ||
        { tail -n 20 "$work/catkin.log" >&2; exit 1; }
    install -m 755 deploy/eehal-hal deploy/container/eehal-container deploy/container/eehal-healthy "$prefix/bin/"
else
    echo "Neither catkin is installed nor ROS 2 sourced: without the ROS nodes" >&2
fi
if [ -z "$platform" ]; then "$prefix/bin/eehal" --version; fi
echo "$prefix: for $target"
