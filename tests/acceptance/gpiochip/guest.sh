#!/bin/sh
# In the guest: network, serial port, then the command of `share`/command; its exit code goes to `share`/code.
# What the command writes stays in memory until it has ended: a write to the host's disk stops the whole guest.
for word in $(cat /proc/cmdline); do
    case $word in
        share=*) share=${word#share=} ;;
        patience=*) patience=${word#patience=} ;;
    esac
done
busybox ifconfig lo 127.0.0.1 up
busybox hostname localhost
# An open port drops what nobody reads, as a UART does; a closed one would keep it.
if [ -c /dev/ttyS0 ]; then
    exec 9<>/dev/ttyS0
    stty -F /dev/ttyS0 raw -echo
fi
export HOME=/tmp TMPDIR=/tmp RESULTS=/run/results
mkdir -p /run/host /run/results
python3 "$(dirname "$0")/inside/stalls.py" >/run/stalls &
timeout "$patience" sh "$share/command" >/run/output 2>&1
code=$?
mount -t hostfs host /run/host -o "$share"
cp /run/output /run/stalls /run/host
cp -r /run/results/. /run/host
echo $code >/run/host/code
exec busybox poweroff -f
