#!/bin/sh
# First process of the emulated board; its root is memory. Runs /job, whose results it sends over the second serial port.
PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin
export PATH
mount -t proc proc /proc
mount -t sysfs sysfs /sys
mount -t devtmpfs devtmpfs /dev
mkdir -p /dev/pts /dev/shm /run/results
mount -t devpts devpts /dev/pts
mount -t tmpfs shm /dev/shm
busybox ifconfig lo 127.0.0.1 up
busybox hostname localhost
echo '127.0.0.1 localhost' >/etc/hosts
# as the board's udev rules name it
ln -s ttymxc0 /dev/verdin-uart1
export HOME=/root PYTHONPATH=/opt/end-effector/site PYTHONUNBUFFERED=1 ROS_PACKAGE_PATH=/opt/end-effector/ros:/usr/share
/bin/bash /job >/run/results/output 2>&1
echo $? >/run/results/code
stty -F /dev/ttymxc1 raw -echo
tar -C /run -cf - results | cat >/dev/ttymxc1
exec busybox poweroff -f
