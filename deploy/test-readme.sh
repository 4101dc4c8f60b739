#!/bin/bash
# Runs the README's block of shell commands word for word, as somebody who reads nothing else: in a clone of what is
# committed here, with a home folder of its own, nothing of this checkout or of ROS in the environment. Only the address
# of the repository is put in, and `make test` is left out: CI runs it as a stage of its own. The caches of pip and uv
# are those of this user: what is known is not fetched again.
set -euo pipefail
cd "$(dirname "$0")/.."
top=$PWD
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "$*" >&2; exit 1; }

block=$(sed -n '/^```sh$/,/^```$/p' README.md | sed '1d;$d')
grep -q '^git clone URL ' <<<"$block" || fail "The README's block of shell commands does not begin with git clone URL."
git rev-parse -q --verify HEAD >/dev/null || fail "This is no clone: there is nothing to be cloned from it."

export PIP_CACHE_DIR=${PIP_CACHE_DIR:-$HOME/.cache/pip} UV_CACHE_DIR=${UV_CACHE_DIR:-$HOME/.cache/uv}
export HOME=$work/home PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin
unset PYTHONPATH VIRTUAL_ENV LD_LIBRARY_PATH ROS_DISTRO ROS_VERSION ROS_PACKAGE_PATH
mkdir "$HOME"
cd "$work"
grep -q '^make test ' <<<"$block" || fail "The README does not say how its tests are run: make test."
block=$(grep -v '^make test ' <<<"$block")
printf '%s\n' "${block/git clone URL /git clone -q "$top" }" >readme.sh
bash -euxo pipefail readme.sh

for picture in demo demo-ros2; do
    for scenario in nominal fails-once never-confirms; do
        [ -s "end-effector-hal/runs/$picture/$scenario/timeline.png" ] || fail "No figure of $picture, $scenario"
    done
done
"$HOME/eehal/bin/eehal" check end-effector-hal/examples/tools/epick_commanded/end_effector.yaml
"$HOME/eehal/bin/python" -c 'import pymodbus, starlette'
echo "README: what it says was done, and left what it says"
