#!/bin/sh
# compile-kernel.sh WORK KERNEL: makes the file KERNEL from Debian's kernel source and kernel.fragment, in the folder WORK.
# Its text is part of the kernel's name.
set -eux
here=$(cd "$(dirname "$0")" && pwd)
work=$1
source=$work/linux-source-6.1
# What no User-Mode-Linux is built from stays packed, except the Kconfig files.
tar -C "$work" -xf /usr/src/linux-source-6.1.tar.xz \
    --exclude='*/drivers/gpu/*.[ch]' --exclude='*/drivers/net/*/*.[ch]' --exclude='*/drivers/media/*.[ch]' \
    --exclude='*/drivers/staging/*.[ch]' --exclude='*/sound/*.[ch]' --exclude='*/Documentation/*.[rty][sxa]*' \
    --exclude='*/arch/[a-tv-w]*/*.[chS]' --exclude='*/boot/dts/*.dts*' --exclude='*/tools/testing'
# A line that was throttled once is never read again (after 4094 unread bytes): it is not to be throttled.
sed -i '/\.throttle[[:space:]]*= line_throttle,/d; /\.unthrottle[[:space:]]*= line_unthrottle,/d' \
    "$source/arch/um/drivers/ssl.c"
# All interrupt numbers are taken; the lines of simulated chips need some.
sed -i 's/^#define NR_IRQS[[:space:]]*UM_LAST_SIGNAL_IRQ$/#define NR_IRQS (UM_LAST_SIGNAL_IRQ + 64)/' \
    "$source/arch/um/include/asm/irq.h"
grep -q 'define NR_IRQS (UM' "$source/arch/um/include/asm/irq.h"
make -C "$source" ARCH=um O="$work/out" KCONFIG_ALLCONFIG="$here/kernel.fragment" allnoconfig
for option in $(sed -n 's/^\(CONFIG_[A-Z0-9_]*=y\)$/\1/p' "$here/kernel.fragment"); do
    grep -qx "$option" "$work/out/.config" || { echo "This source has no $option."; exit 1; }
done
make -C "$work/out" ARCH=um -j"$(nproc)" linux
strip -o "$2" "$work/out/linux"
