#!/bin/sh
# Installs from Debian what the project needs, or the packages of another list; without a question, quick when all is there.
set -eu
list=${1:-$(dirname "$0")/debian-packages.txt}
missing=$(while read -r name; do
    dpkg-query -W -f '${Status}' "$name" 2>/dev/null | grep -q 'ok installed' || printf '%s ' "$name"
done < "$list")
[ -z "$missing" ] && exit 0
if ! command -v apt-get >/dev/null; then
    echo "This is no Debian system: apt-get is missing. Without ROS: pip install '.[lab]' && eehal demo --no-ros" >&2
    exit 3
fi
sudo=
if [ "$(id -u)" != 0 ]; then
    command -v sudo >/dev/null || { echo "Installing Debian packages needs root or sudo:$missing" >&2; exit 3; }
    sudo=sudo
fi
echo "Installing from Debian: $missing"
export DEBIAN_FRONTEND=noninteractive
log=$(mktemp)
apt() { $sudo env DEBIAN_FRONTEND=noninteractive apt-get -qq -o DPkg::Lock::Timeout=300 "$@" >"$log" 2>&1 || { tail -n 20 "$log" >&2; exit 3; }; }
apt update
# shellcheck disable=SC2086
apt install -y --no-install-recommends $missing
rm -f "$log"
