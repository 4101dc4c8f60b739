#!/bin/sh
# Builds the User-Mode-Linux kernel of the gpiochip tests from Debian's kernel source; prints where it stands.
# Once: the result is kept under the version of the source and the text of what is built.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
place=${1:-$here/../../build/uml}
archive=/usr/src/linux-source-6.1.tar.xz
say() { echo "$*" >&2; }

if [ "$(uname -m)" != x86_64 ]; then
    say "User-Mode-Linux runs on x86_64 only, this machine is $(uname -m)."
    exit 3
fi
version=$(dpkg-query -W -f '${Version}' linux-source-6.1 2>/dev/null) || version=
if [ -z "$version" ] || [ ! -r "$archive" ]; then
    say "Debian's kernel source is missing: apt install $(paste -sd' ' "$here/debian-packages.txt")"
    exit 3
fi
for program in flex bison bc gcc make xz; do
    if ! command -v "$program" >/dev/null; then
        say "$program is missing: apt install $(paste -sd' ' "$here/debian-packages.txt")"
        exit 3
    fi
done
key=$(cat "$here/kernel.fragment" "$0" | sha256sum | cut -c1-12)
kernel=$place/linux-$version-$key
if [ -x "$kernel" ]; then
    echo "$kernel"
    exit 0
fi
say "Building a User-Mode-Linux kernel from linux-source-6.1 $version; once, about five minutes"
mkdir -p "$place"
work=$(mktemp -d "$place/work.XXXXXX")
trap 'rm -rf "$work"' EXIT
trap 'exit 1' INT TERM
source=$work/linux-source-6.1
log=$place/build.log
{
    tar -C "$work" -xf "$archive"
    # A line that was throttled once is never read again (after 4094 unread bytes): it is not to be throttled.
    sed -i '/\.throttle[[:space:]]*= line_throttle,/d; /\.unthrottle[[:space:]]*= line_unthrottle,/d' \
        "$source/arch/um/drivers/ssl.c"
    # All interrupt numbers are taken; the lines of simulated chips need some.
    sed -i 's/^#define NR_IRQS[[:space:]]*UM_LAST_SIGNAL_IRQ$/#define NR_IRQS (UM_LAST_SIGNAL_IRQ + 64)/' \
        "$source/arch/um/include/asm/irq.h"
    grep -q 'define NR_IRQS (UM' "$source/arch/um/include/asm/irq.h"
    make -C "$source" ARCH=um O="$work/out" KCONFIG_ALLCONFIG="$here/kernel.fragment" allnoconfig
    nice -n 10 make -C "$work/out" ARCH=um -j"$(nproc)" linux
    strip -o "$work/linux" "$work/out/linux"
} >"$log" 2>&1 || { tail -n 15 "$log" >&2; say "The kernel was not built; all of it: $log"; exit 1; }
for option in $(sed -n 's/^\(CONFIG_[A-Z0-9_]*=y\)$/\1/p' "$here/kernel.fragment"); do
    grep -qx "$option" "$work/out/.config" || { say "This source has no $option."; exit 1; }
done
mv "$work/linux" "$kernel"
echo "$kernel"
