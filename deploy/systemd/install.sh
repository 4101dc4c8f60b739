#!/bin/sh
# Installs the services of a folder that deploy/build.sh made, and starts the line arbiter and the nodes with it.
# Usage: deploy/systemd/install.sh [-t DESCRIPTION | -c DESCRIPTION] [PREFIX]     as root; default: /opt/eehal-<version>.
# The first time with -t: the description of the tool is copied to /etc/eehal. Run it again without -t to update.
# With -c: another description instead of the installed one. Refused while a line is active, and with any fault in it:
# then nothing has changed. The one before it stands beside it as end_effector.yaml.before.
# The nodes are those of the ROS that the folder was built for: eehal-hal (ROS 1), or eehal-hal-ros2 and eehal-logger-ros2.
# A folder without ROS has none: the line arbiter alone is installed, and what is left out is said.
# DESTDIR: install below this folder, and start nothing.
set -eu
here=$(CDPATH= cd -- "$(dirname -- "$0")" && pwd)
version=$(sed -n 's/^version = "\(.*\)"/\1/p' "$here/../../pyproject.toml" | head -n 1)
tool= changed=
while getopts t:c: option; do
    case $option in
    t) tool=$OPTARG ;;
    c) tool=$OPTARG changed=yes ;;
    *) exit 2 ;;
    esac
done
shift $((OPTIND - 1))
prefix=${1:-/opt/eehal-$version}
dest=${DESTDIR:-}
installed=$dest/etc/eehal/end_effector.yaml
[ -x "$prefix/bin/eehal" ] || { echo "There is no $prefix/bin/eehal: run deploy/build.sh first" >&2; exit 2; }
nodes='' others='' lacks=''
for unit in eehal-hal-ros2 eehal-logger-ros2 eehal-hal; do
    program=$(sed -n 's|^ExecStart=/opt/eehal/\([^ ]*\).*|\1|p' "$here/$unit.service")
    if [ ! -x "$prefix/$program" ]; then
        others="$others $unit" lacks="$lacks $prefix/$program"
    elif [ ! -f "$prefix/ros/setup.bash" ]; then
        others="$others $unit" lacks="$lacks $prefix/ros/setup.bash"
    elif [ "$unit" = eehal-hal ] && [ -n "$nodes" ]; then
        others="$others $unit"  # one generation drives the tool
    else
        nodes="$nodes $unit"
    fi
done
if [ -n "$changed" ]; then
    [ -e "$installed" ] || { echo "There is no tool yet: name it with -t" >&2; exit 2; }
    EEHAL_RUN_DIR=${EEHAL_RUN_DIR:-/run/eehal} "$prefix/bin/eehal" check "$tool" --instead-of "$installed" >/dev/null || exit
    cp -p "$installed" "$installed.before"
elif [ -n "$tool" ]; then
    [ ! -e "$installed" ] || { echo "There is a tool already: put this one in the place of $installed with -c, or leave out -t" >&2; exit 2; }
    "$prefix/bin/eehal" check "$tool" >/dev/null || exit 2
elif [ ! -e "$installed" ]; then
    echo "No tool is driven by default: name yours, $0 -t DESCRIPTION; eehal init FOLDER writes one to start from" >&2
    exit 2
fi

if [ -z "$nodes" ]; then
    echo "Left out:$others. deploy/build.sh has not made what they need:" >&2
    # shellcheck disable=SC2086
    printf '%s\n' $lacks | sort -u | sed 's/^/  /' >&2
    echo "Only the line arbiter is installed. Without ROS give commands with: $prefix/bin/eehal run /etc/eehal/end_effector.yaml" >&2
fi

put() { install -D -m 644 "$here/$1" "$dest$2"; }
put eehal-arbiter.service /etc/systemd/system/eehal-arbiter.service
for unit in $nodes; do put "$unit.service" "/etc/systemd/system/$unit.service"; done
put eehal.sysusers /etc/sysusers.d/eehal.conf
put eehal.udev.rules /etc/udev/rules.d/60-eehal.rules
mkdir -p "$dest/opt" "$dest/etc/eehal"
ln -sfn "$prefix" "$dest/opt/eehal"
# what the user has changed stays
[ -e "$dest/etc/default/eehal" ] || put eehal.default /etc/default/eehal
if [ -n "$tool" ]; then
    install -m 644 "$tool" "$installed"
    # its own automata, which stand beside it
    automata=$("$prefix/bin/python" -c 'import sys; from end_effector_hal.description import load
print(load(sys.argv[1]).automata.file)' "$tool")
    beside=$(dirname "$tool")/$automata
    [ ! -f "$beside" ] || install -D -m 644 "$beside" "$dest/etc/eehal/$automata"
    "$prefix/bin/eehal" check "$installed" >/dev/null || exit 2
fi
[ -z "$dest" ] || exit 0

systemd-sysusers
# those that are left out
for unit in $others; do
    [ ! -e "/etc/systemd/system/$unit.service" ] || systemctl disable --now "$unit"
    rm -f "/etc/systemd/system/$unit.service"
done
udevadm control --reload
udevadm trigger --subsystem-match=gpio
systemctl daemon-reload
# shellcheck disable=SC2086
systemctl enable eehal-arbiter $nodes
# the nodes first: they end in order while the arbiter still runs
# shellcheck disable=SC2086
[ -z "$nodes" ] || systemctl stop $nodes
systemctl restart eehal-arbiter
# shellcheck disable=SC2086
[ -z "$nodes" ] || systemctl start $nodes
EEHAL_RUN_DIR=/run/eehal "$prefix/bin/eehal" doctor /etc/eehal/end_effector.yaml --passive --only description,lines,arbiter,link
