#!/bin/sh
# Installs the services of a folder that deploy/build.sh made, and starts the line arbiter and the nodes with it.
# Usage: deploy/systemd/install.sh [PREFIX]     as root; default: /opt/eehal-<version>. Run it again to update.
# DESTDIR: install below this folder, and start nothing.
set -eu
here=$(CDPATH= cd -- "$(dirname -- "$0")" && pwd)
version=$(sed -n 's/^version = "\(.*\)"/\1/p' "$here/../../pyproject.toml" | head -n 1)
prefix=${1:-/opt/eehal-$version}
dest=${DESTDIR:-}
[ -x "$prefix/bin/eehal" ] || { echo "There is no $prefix/bin/eehal: run deploy/build.sh first" >&2; exit 2; }

put() { install -D -m 644 "$here/$1" "$dest$2"; }
put eehal-arbiter.service /etc/systemd/system/eehal-arbiter.service
put eehal-hal.service /etc/systemd/system/eehal-hal.service
put eehal.sysusers /etc/sysusers.d/eehal.conf
put eehal.udev.rules /etc/udev/rules.d/60-eehal.rules
mkdir -p "$dest/opt" "$dest/etc/eehal"
ln -sfn "$prefix" "$dest/opt/eehal"
# what the user has changed stays
[ -e "$dest/etc/default/eehal" ] || put eehal.default /etc/default/eehal
if [ ! -e "$dest/etc/eehal/end_effector.yaml" ]; then
    # without a file of his own the shipped automata are taken
    "$prefix/bin/python" -c 'from end_effector_hal.description import profile_path; print(profile_path())' |
        xargs -I{} install -m 644 {} "$dest/etc/eehal/end_effector.yaml"
fi
[ -z "$dest" ] || exit 0

systemd-sysusers
# the unit of earlier releases would keep the lines; its nodes end first, while it still runs
if [ -e /etc/systemd/system/eehal-arbiter.service ]; then
    systemctl stop eehal-hal
    systemctl disable --now eehal-arbiter
    rm /etc/systemd/system/eehal-arbiter.service
fi
udevadm control --reload
udevadm trigger --subsystem-match=gpio
systemctl daemon-reload
systemctl enable eehal-arbiter eehal-hal
# the nodes first: they end in order while the arbiter still runs
systemctl stop eehal-hal
systemctl restart eehal-arbiter
systemctl start eehal-hal
EEHAL_RUN_DIR=/run/eehal "$prefix/bin/eehal" doctor /etc/eehal/end_effector.yaml --passive --only description,lines,arbiter,link
