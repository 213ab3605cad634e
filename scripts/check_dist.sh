#!/bin/sh
# Install the wheel and the source archive of dist/, each into a fresh environment, and
# use roughbench from there: sh scripts/check_dist.sh PYTHON (one that has pip).
set -eu
python=$1
case $python in */*) python=$(cd "$(dirname "$python")" && pwd)/$(basename "$python") ;; esac
cd "$(dirname "$0")/.."
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

spec=$PWD/configs/smoke.yaml
for archive in "$PWD"/dist/roughbench-*.whl "$PWD"/dist/roughbench-*.tar.gz; do
    echo "== $(basename "$archive")"
    "$python" -m venv --clear --without-pip "$folder/venv"
    "$python" -m pip --python "$folder/venv/bin/python" install --quiet "$archive"
    (
        cd "$folder"
        venv/bin/roughbench --version
        venv/bin/roughbench --help > /dev/null
        venv/bin/roughbench run "$spec" --quiet -o smoke.h5
        venv/bin/roughbench plot smoke.h5 -o figures | wc -l
        venv/bin/roughbench report smoke.h5 --resamples 20
    )
done
echo "dist: both archives install and run"
