#!/bin/bash
# Builds the image with buildah on a Debian root made by mmdebstrap: Debian's archive and PyPI, no container registry.
# Usage: deploy/container/image.sh [ARCH]     amd64 or arm64; default: this machine's. Another one is emulated by qemu-user.
# ROS=2: with ROS 2 from its wheels; localhost/end-effector-hal-ros2:amd64.
# BASE=torizon/debian:3-bookworm: on that image instead of a root made here.
# In buildah's storage, outside of the checkout: localhost/eehal-debian:bookworm-ARCH (kept; `buildah rmi` it to have it
# made again with Debian's newest), localhost/end-effector-hal:ARCH, for this machine's also :latest.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
top=$(cd "$here/../.." && pwd)
say() { echo "$*" >&2; }

for program in buildah mmdebstrap; do
    command -v "$program" >/dev/null || { say "$program is missing; on Debian 12: apt install buildah mmdebstrap uidmap"; exit 3; }
done
native=$(dpkg --print-architecture)
arch=${1:-$native}
case $arch in
amd64 | arm64) ;;
*) say "ARCH is amd64 or arm64, not $arch: for others there are no Python wheels"; exit 2 ;;
esac
case ${ROS:-1}-$arch in
1-* | 2-amd64) ;;
*) say "ROS is 1, or 2 on amd64: there are no wheels of ROS 2 for $arch"; exit 2 ;;
esac
if [ "$arch" != "$native" ]; then
    # In a container the kernel's table may not be mounted yet; where it may not be, arch-test says no.
    arch-test "$arch" >/dev/null 2>&1 || update-binfmts --enable 2>/dev/null || true
    arch-test "$arch" >/dev/null 2>&1 || {
        say "Programs for $arch do not run here; on Debian 12: apt install qemu-user-static binfmt-support arch-test"
        exit 3
    }
fi
export BUILDAH_ISOLATION=${BUILDAH_ISOLATION:-chroot}
# apt under qemu-user, where nothing else runs: no answer for so long means that it hangs
limit="timeout --foreground 5400"

debian() { # ARCH: its root as an image, made once
    local name=localhost/eehal-debian:bookworm-$1
    if [ -z "$(buildah images -q "$name" 2>/dev/null)" ]; then
        say "Making a Debian root for $1; once"
        local folder
        folder=$(mktemp -d)
        # no manuals, and quick: what is half written when the power fails is thrown away
        $limit mmdebstrap --quiet --variant=minbase --arch="$1" --dpkgopt=path-exclude=/usr/share/man/* \
            --dpkgopt=path-exclude=/usr/share/doc/* --dpkgopt=path-include=/usr/share/doc/*/copyright \
            --dpkgopt=path-exclude=/usr/share/locale/* --dpkgopt=force-unsafe-io bookworm "$folder/root.tar" >&2 ||
            { rm -rf "$folder"; say "mmdebstrap could not make a root for $1"; return 1; }
        printf 'FROM scratch\nADD root.tar /\nCMD ["bash"]\n' >"$folder/Containerfile"
        buildah build --quiet --arch "$1" --format docker -t "$name" "$folder" >/dev/null
        rm -rf "$folder"
    fi
    echo "$name"
}

size() { buildah images --format '{{.Size}}' "$1" | head -n 1; }

begun=$SECONDS
base=${BASE:-$(debian "$arch")}
build_base=$(debian "$native")
made=$SECONDS
ros=${ROS:-1}
name=localhost/end-effector-hal$([ "$ros" = 1 ] || echo "-ros$ros")
tags=(-t "$name:$arch")
[ "$arch" != "$native" ] || tags+=(-t "$name:latest")
# The machine's own certificates: a company's proxy may stand between here and PyPI.
certificates=/etc/ssl/certs/ca-certificates.crt
secret=()
[ ! -e "$certificates" ] || secret=(--secret "id=ca-certificates,src=$certificates")
$limit buildah build --layers --arch "$arch" --format docker --pull=missing "${secret[@]}" "${tags[@]}" \
    --build-arg "BASE=$base" --build-arg "BUILD_BASE=$build_base" --build-arg "TARGETARCH=$arch" --build-arg "ROS=$ros" \
    --build-arg "BUILDPLATFORM=linux/$native" --build-arg "TARGETPLATFORM=linux/$arch" \
    --ignorefile "$here/Containerfile.dockerignore" -f "$here/Containerfile" "$top" >&2
echo "$name:$arch: $(size "$name:$arch")," \
    "of which Debian's root $(size "$base"); root made in $((made - begun)) s, image in $((SECONDS - made)) s"
