#!/bin/bash
# Builds the emulated Verdin board: QEMU 10 of Debian's backports, Debian's arm64 kernel with the Verdin's device tree, and
# an arm64 root with Debian's ROS and the project's Python packages. Once; nothing is installed, no root is needed, no arm64
# code is run. Prints where it stands: `qemu`, `kernel`, `board.dtb`, `root.cpio`.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
top=$(cd "$here/../.." && pwd)
uv=$top/build/uv/bin/uv
say() { echo "$*" >&2; }

for program in apt-get dpkg-deb busybox /usr/bin/python3.11; do
    command -v "$program" >/dev/null || { say "$program is missing; on Debian 12: apt install apt dpkg busybox-static python3.11"; exit 3; }
done
[ -x "$uv" ] || { say "The Python environment is missing: make setup"; exit 3; }
key=$(cat "$0" "$here/debian-packages.txt" "$top/uv.lock" | sha256sum | cut -c1-12)
place=$top/build/board/$key
if [ -e "$place/root.cpio" ]; then
    echo "$place"
    exit 0
fi
say "Building the emulated board: 250 MB of Debian packages; once, about two minutes"
rm -rf "$top/build/board"
mkdir -p "$place"
log=$top/build/board/build.log
work=$place/work
trap 'rm -rf "$work"' EXIT

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
    apt-get -qq -y --download-only install $(cat "$here/debian-packages.txt")
    unpack "$work/board/cache/archives" "$work/root"
    root=$work/root
    rm -rf "$root"/usr/share/{doc,man,locale,info,lintian,bug} "$root"/usr/include "$root"/boot \
        "$root"/usr/lib/aarch64-linux-gnu/{gconv,perl,perl-base}
    site=$root/opt/end-effector/site
    mkdir -p "$site"
    # what the HAL needs without figures
    (cd "$top" && "$uv" export -q --frozen --no-dev --no-emit-project --no-hashes) |
        grep -vE '^( |#|matplotlib|pillow|numpy|contourpy|fonttools|kiwisolver|cycler)' >"$work/requirements.txt"
    "$uv" pip install -q --no-config --target "$site" --python-platform aarch64-manylinux_2_28 --python-version 3.11 \
        --only-binary :all: --no-deps -r "$work/requirements.txt"
    (cd "$root" && nice /usr/bin/python3.11 -m compileall -q -j2 -s "$root" usr/lib/python3 usr/lib/python3.11 opt || true)
    (cd "$root" && find . | busybox cpio -o -H newc) >"$place/root.cpio.new"
    mv "$place/root.cpio.new" "$place/root.cpio"
}

build >"$log" 2>&1 || { tail -n 15 "$log" >&2; say "The board was not built; all of it: $log"; exit 1; }
echo "$place"
