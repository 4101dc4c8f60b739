#!/bin/bash
# Builds what the emulated Verdin is made of: QEMU 10 of Debian's backports, Debian's arm64 kernel with the Verdin's device
# tree, and an arm64 root with Debian's ROS and Python packages. Nothing is installed, no root is needed, no arm64 code runs.
# build.sh PLACE REQUIREMENTS: PLACE gets qemu/, kernel, board.dtb, root.cpio; the last is there only when all is.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
place=$1
requirements=$2
say() { echo "$*" >&2; }

need() { # PROGRAM PACKAGE
    command -v "$1" >/dev/null || { say "$1 is missing: apt install $2"; exit 3; }
}
need apt-get apt
need dpkg-deb dpkg
need /usr/bin/python3.11 python3.11
/usr/bin/python3.11 -c 'import ensurepip' 2>/dev/null || { say "Python's venv is missing: apt install python3-venv"; exit 3; }
[ -r /usr/share/keyrings/debian-archive-keyring.gpg ] ||
    { say "The keys of Debian's archive are missing: apt install debian-archive-keyring"; exit 3; }
log=$place/build.log
work=$place/work

# An apt of its own: NAME, ARCHITECTURE, dpkg's list of what is installed there
apt_of() {
    local home=$work/$1
    mkdir -p "$home"/{lists/partial,cache/archives/partial,parts,trusted}
    cat >"$home/parts/debian.list" <<LIST
deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] http://deb.debian.org/debian bookworm main
deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] http://deb.debian.org/debian bookworm-backports main
deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] http://deb.debian.org/debian-security bookworm-security main
LIST
    cat >"$home/apt.conf" <<CONF
APT::Architecture "$2";
APT::Architectures { "$2"; };
APT::Install-Recommends "false";
APT::Sandbox::User "";
Dir::Etc::sourcelist "/dev/null";
Dir::Etc::sourceparts "$home/parts";
Dir::State::lists "$home/lists";
Dir::State::status "$3";
Dir::Cache "$home/cache";
Debug::NoLocking "true";
CONF
    export APT_CONFIG=$home/apt.conf
    apt-get -qq update
}

unpack() { # FROM TO
    mkdir -p "$2"
    for package in "$1"/*.deb; do
        dpkg-deb -x "$package" "$2"
    done
}

build() {
    apt_of host "$(dpkg --print-architecture)" /var/lib/dpkg/status
    apt-get -qq -y -t bookworm-backports --download-only --reinstall install qemu-system-arm
    unpack "$work/host/cache/archives" "$place/qemu"

    : >"$work/none"
    apt_of board arm64 "$work/none"
    image=$(apt-cache depends linux-image-arm64/bookworm-security 2>/dev/null | sed -n 's/.*Depends: \(linux-image.*\)/\1/p' | head -n 1)
    [ -n "$image" ] || image=$(apt-cache depends linux-image-arm64 | sed -n 's/.*Depends: \(linux-image.*\)/\1/p' | head -n 1)
    (cd "$work" && apt-get -qq download "$image" && dpkg-deb -x "$image"_*.deb kernel)
    cp "$work"/kernel/boot/vmlinuz-* "$place/kernel"
    cp "$work"/kernel/usr/lib/linux-image-*/freescale/imx8mp-verdin-wifi-dahlia.dtb "$place/board.dtb"

    # shellcheck disable=SC2046
    apt-get -qq -y --download-only install $(cat "$here/packages.txt")
    unpack "$work/board/cache/archives" "$work/root"
    root=$work/root
    rm -rf "$root"/usr/share/{doc,man,locale,info,lintian,bug} "$root"/usr/include "$root"/boot \
        "$root"/usr/lib/aarch64-linux-gnu/{gconv,perl,perl-base}
    site=$root/opt/end-effector/site
    mkdir -p "$site"
    /usr/bin/python3.11 -m venv "$work/venv"
    "$work/venv/bin/pip" install -q --disable-pip-version-check --no-compile --no-deps --only-binary :all: --target "$site" \
        --implementation cp --python-version 3.11 --platform manylinux_2_28_aarch64 --platform manylinux_2_17_aarch64 \
        --platform manylinux2014_aarch64 -r "$requirements"
    (cd "$root" && /usr/bin/python3.11 -m compileall -q -j2 -s "$root" usr/lib/python3 usr/lib/python3.11 opt || true)
    /usr/bin/python3.11 "$here/_cpio.py" "$root" "$place/root.cpio.new"
    rm -rf "$work"
    mv "$place/root.cpio.new" "$place/root.cpio"
}

mkdir -p "$work"
build >"$log" 2>&1 || { grep -v '^$' "$log" | tail -n 1 >&2; exit 1; }
