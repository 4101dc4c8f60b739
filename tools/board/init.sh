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
busybox date -s "@$(cat /date)" >/dev/null
# as the board's udev rules name it
ln -s ttymxc0 /dev/verdin-uart1
# Nothing here is random, and the first program that asks for chance would wait for eight seconds: RNDADDENTROPY
PYTHONHASHSEED=0 python3 -S -c "import fcntl, struct
seed = open('/seed', 'rb').read()
fcntl.ioctl(open('/dev/random', 'wb'), 0x40085203, struct.pack('ii', 8 * len(seed), len(seed)) + seed)"
export HOME=/root PYTHONPATH=/opt/end-effector/site PYTHONUNBUFFERED=1 ROS_PACKAGE_PATH=/opt/end-effector/ros:/usr/share
# The board's clock counts what is executed, and only while nothing is would it be ours: so something always is
chrt --idle 0 busybox sh -c 'while :; do :; done' &
/bin/bash /job >/run/results/output 2>&1
echo $? >/run/results/code
stty -F /dev/ttymxc1 raw -echo
busybox tar -C /run -cf - results | busybox gzip >/dev/ttymxc1
exec busybox poweroff -f
