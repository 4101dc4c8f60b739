#!/bin/sh
# build-kernel.sh [find]: prints where the User-Mode-Linux kernel of the gpiochip tests stands; builds it when there is
# none (not with `find`).
# It is kept outside of the checkout, under the version of the source and what is made of it: a fresh clone finds it.
# Exit code 3: something is missing here; one line says what.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
cache=${XDG_CACHE_HOME:-${HOME:-/tmp}/.cache}/end-effector-hal/uml
say() { echo "$*" >&2; }
lacks() {
    say "$1 is missing, so there is no kernel to test on: apt install $(paste -sd' ' "$here/kernel-packages.txt")"
    exit 3
}
key=$(cat "$here/kernel.fragment" "$here/kernel.patch" "$here/compile-kernel.sh" | sha256sum | cut -c1-12)
version() { dpkg-query -W -f '${Version}' linux-source-6.1 2>/dev/null; }
found() {
    # without the source any version will do
    for kernel in "$cache"/linux-$(version || echo '*')-"$key"; do
        [ -x "$kernel" ] && echo "$kernel" && return
    done
    return 1
}

if [ "$(uname -m)" != x86_64 ]; then
    say "User-Mode-Linux runs on x86_64 only, this machine is $(uname -m)."
    exit 3
fi
found && exit 0
[ "${1:-}" != find ] || exit 1
"$here/../../../deploy/debian.sh" "$here/kernel-packages.txt" >&2 || true
version >/dev/null && [ -r /usr/src/linux-source-6.1.tar.xz ] || lacks linux-source-6.1
for program in bc bison flex gcc make patch xz; do
    command -v "$program" >/dev/null || lacks "$program"
done
if ! mkdir -p "$cache" 2>/dev/null || [ ! -w "$cache" ]; then
    say "The kernel cannot be kept: $cache cannot be written. Set XDG_CACHE_HOME to a folder that can."
    exit 3
fi
exec 9>"$cache/lock"
flock -n 9 || { say "Waiting: another program builds the kernel in $cache"; flock 9; }
found && exit 0 # by the one who had the lock
kernel=$cache/linux-$(version)-$key
say "Building a User-Mode-Linux kernel from linux-source-6.1 $(version) into $cache; once, two to five minutes"
# in memory where there is room: half a gigabyte of small files
in_memory=$(awk '/^MemAvailable:/ { print ($2 > 6000000) }' /proc/meminfo)
[ "$in_memory" = 1 ] && [ "$(df --output=avail /dev/shm 2>/dev/null | tail -n 1)" -gt 3000000 ] && place=/dev/shm || place=$cache
work=$(mktemp -d "$place/end-effector-uml.XXXXXX")
trap 'rm -rf "$work" "$cache/new"' EXIT
trap 'exit 1' INT TERM
if ! "$here/compile-kernel.sh" "$work" "$cache/new" >"$cache/build.log" 2>&1; then
    tail -n 15 "$cache/build.log" >&2
    say "The kernel was not built; all of it: $cache/build.log"
    exit 1
fi
mv "$cache/new" "$kernel" # at once: what stands there is whole
"$here/forget-others.sh" "$kernel"
echo "$kernel"
