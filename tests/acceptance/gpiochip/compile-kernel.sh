#!/bin/sh
# compile-kernel.sh WORK KERNEL: makes the file KERNEL from Debian's kernel source, kernel.patch and kernel.fragment, in the
# folder WORK. Their text is part of the kernel's name.
set -eux
here=$(cd "$(dirname "$0")" && pwd)
work=$1
source=$work/linux-source-6.1
# What no User-Mode-Linux is built from stays packed, except the Kconfig files.
tar -C "$work" -xf "${LINUX_SOURCE:-/usr/src/linux-source-6.1.tar.xz}" \
    --exclude='*/drivers/gpu/*.[ch]' --exclude='*/drivers/net/*/*.[ch]' --exclude='*/drivers/media/*.[ch]' \
    --exclude='*/drivers/staging/*.[ch]' --exclude='*/sound/*.[ch]' --exclude='*/Documentation/*.[rty][sxa]*' \
    --exclude='*/arch/[a-tv-w]*/*.[chS]' --exclude='*/boot/dts/*.dts*' --exclude='*/tools/testing'
patch -d "$source" -p1 -F0 <"$here/kernel.patch"
make -C "$source" ARCH=um O="$work/out" KCONFIG_ALLCONFIG="$here/kernel.fragment" allnoconfig
for option in $(sed -n 's/^\(CONFIG_[A-Z0-9_]*=[y0-9]*\)$/\1/p' "$here/kernel.fragment"); do
    grep -qx "$option" "$work/out/.config" || { echo "This source has no $option."; exit 1; }
done
make -C "$work/out" ARCH=um -j"$(nproc)" linux
strip -o "$2" "$work/out/linux"
