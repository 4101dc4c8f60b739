#!/bin/bash
# Builds the sdist and, from it, the wheel; installs them into fresh environments and uses them outside of the checkout:
# the base install, without the commands of the workshop and at most 55 MB, and the sdist with all extras. A minute and a half.
set -euo pipefail
cd "$(dirname "$0")/.."
uv=$PWD/build/uv/bin/uv
top=$PWD
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "$*" >&2; exit 1; }

"$uv" build -q -p /usr/bin/python3 --out-dir "$work/dist"
sdist=$(echo "$work"/dist/*.tar.gz)
wheel=$(echo "$work"/dist/*.whl)
if git rev-parse --git-dir >/dev/null 2>&1; then
    missing=$(comm -23 <(git ls-files | LC_ALL=C sort) <(tar tf "$sdist" | cut -d/ -f2- | LC_ALL=C sort))
    [ -z "$missing" ] || fail "The sdist lacks: $missing"
fi

# Nothing of the checkout or of ROS is seen from here
mkdir "$work/outside"
cd "$work/outside"
unset PYTHONPATH VIRTUAL_ENV
install() { # NAME REQUIREMENT
    "$uv" venv -q -p /usr/bin/python3 "$work/$1"
    "$uv" pip install -q --compile-bytecode -p "$work/$1/bin/python" "$2"
    eehal=$work/$1/bin/eehal
    "$eehal" --version
    "$eehal" check >/dev/null
}
play() { # FOLDER
    "$eehal" demo --no-ros --only nominal -o "$1" >"$1.log" 2>&1 || { cat "$1.log"; fail "$eehal demo failed"; }
}

install base "$wheel"
site=$(echo "$work"/base/lib/python3*/site-packages)
kilobytes=$(du -sk "$site" | cut -f 1)
echo "base install: $((kilobytes / 1024)) MB"
[ "$kilobytes" -le $((55 * 1024)) ] || { du -sk "$site"/* | sort -rn | head >&2; fail "More than 55 MB"; }
for package in matplotlib mcap numpy pymodbus rosbags zstandard; do
    [ ! -e "$site/$package" ] || fail "$package is in the base install"
done
! grep -E '\]\((docs|[A-Z]+\.md|CITATION)' "$site"/end_effector_hal-*.dist-info/METADATA || fail "A relative link is in the metadata"
"$eehal" verify >verify.log || { cat verify.log; fail "$eehal verify failed"; }
tail -n 1 verify.log
"$eehal" demo 2>demo.log && fail "The base install has the workshop"
grep -qF "pip install '.[lab]'" demo.log || fail "eehal demo does not say what to install"
! "$eehal" --help | grep -q demo || fail "eehal --help lists the workshop"

install extras "$sdist[bags,lab,modbus]"
play extras-demo
[ -s extras-demo/nominal/timeline.png ] || fail "The demo drew no figure"
"$eehal" replay extras-demo/nominal >/dev/null
"$eehal" import extras-demo/nominal/hal.mcap 2>import.log || true
grep -q 'not a bag of ROS 2' import.log || fail "No bag is read"
echo "wheel and sdist: installed, checked, verified, played"
