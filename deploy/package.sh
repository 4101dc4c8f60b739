#!/bin/sh
# Builds a Debian package: the folder that build.sh makes as /opt/eehal, the units, users, udev rule, and `eehal` on the PATH.
# Usage: deploy/package.sh [FOLDER]     default: build. No root is needed. TARGETARCH=arm64: for that architecture.
# For the Debian (and its Python) that it is built on, which its version names; ROS as in build.sh.
set -eu
here=$(CDPATH= cd -- "$(dirname -- "$0")" && pwd)
out=$(mkdir -p "${1:-$here/../build}" && CDPATH= cd -- "${1:-$here/../build}" && pwd)
arch=${TARGETARCH:-$(dpkg --print-architecture)}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export DESTDIR="$work/root"
umask 022
"$here/build.sh" /opt/eehal

units=$DESTDIR/lib/systemd/system
for unit in "$here"/systemd/*@.service; do
    name=$(basename "$unit")
    # the nodes of a ROS only where they were built
    program=$(sed -n 's|^AssertPathExists=\(/opt/.*\)|\1|p' "$unit")
    [ -z "$program" ] || [ -e "$DESTDIR$program" ] || continue
    install -D -m 644 "$unit" "$units/$name"
    # first, so that a unit can change what is common
    [ "$name" = eehal-arbiter@.service ] || cat "$here/systemd/common.conf" "$unit" >"$units/$name"
done
for kind in sysusers tmpfiles; do
    install -D -m 644 "$here/systemd/eehal.$kind" "$DESTDIR/usr/lib/$kind.d/eehal.conf"
done
install -D -m 644 "$here/systemd/eehal.udev.rules" "$DESTDIR/lib/udev/rules.d/60-eehal.rules"
install -D -m 644 "$here/../LICENSE" "$DESTDIR/usr/share/doc/end-effector-hal/copyright"
install -d "$DESTDIR/etc/eehal" "$DESTDIR/usr/bin"
ln -s /opt/eehal/bin/eehal "$DESTDIR/usr/bin/eehal"

. /etc/os-release
version=$(sed -n 's/^version = "\(.*\)"/\1/p' "$here/../pyproject.toml" | head -n 1)+$ID$VERSION_ID
python=$(/usr/bin/python3 -c 'import sys; print(sys.version_info.minor)')
ros=$(grep '^python3-ros\|^ros-' "$here/container/packages.txt" | paste -s -d ,)
mkdir "$DESTDIR/DEBIAN"
sed -e "s/@VERSION@/$version/; s/@ARCHITECTURE@/$arch/; s/@PYTHON@/3.$python/; s/@PYTHON_NEXT@/3.$((python + 1))/" \
    -e "s/@SIZE@/$(du -sk "$DESTDIR" | cut -f 1)/; s/@ROS@/$ros/" "$here/package/control" >"$DESTDIR/DEBIAN/control"
install -m 755 "$here"/package/p* "$DESTDIR/DEBIAN/"
dpkg-deb --root-owner-group -Zxz -z2 -b "$DESTDIR" "$out/end-effector-hal_${version}_$arch.deb"
