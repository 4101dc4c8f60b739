#!/bin/sh
# forget-others.sh KERNEL: removes the kernels beside this one that nobody uses; who uses one has a lock on it.
set -eu
for old in "$(dirname "$1")"/linux-*; do
    [ "$old" = "$1" ] || [ ! -f "$old" ] && continue
    flock -n "$old" rm -f "$old" && echo "Removed $old, an older one" >&2 || true
done
