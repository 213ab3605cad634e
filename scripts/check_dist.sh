#!/bin/sh
# Check the archives in dist/ as a registry and a user would: sh scripts/check_dist.sh PYTHON
# (one that has pip). Each is installed into a fresh environment, where roughbench computes,
# draws and reports, with pyFFTW and without.
set -eu
python=$1
case $python in */*) python=$(cd "$(dirname "$python")" && pwd)/$(basename "$python") ;; esac
cd "$(dirname "$0")/.."
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export ROUGHBENCH_CACHE="$folder/cache"

root=$PWD
spec=$root/packaging/conda/smoke.yaml
wheel=$(echo "$root"/dist/roughbench-*.whl)
source=$(echo "$root"/dist/roughbench-*.tar.gz)

fresh() { # ENVIRONMENT PACKAGE ...: nothing but these and what they need
    environment=$folder/$1
    shift
    "$python" -m venv --clear --without-pip "$environment"
    "$python" -m pip --python "$environment/bin/python" install --quiet "$@"
}

echo "== what a registry reads"
fresh tools twine cffconvert pipx
"$folder/tools/bin/twine" check --strict "$wheel" "$source"
"$folder/tools/bin/cffconvert" --validate --infile CITATION.cff
"$python" -m tarfile --list "$source" > "$folder/content"
for needed in Makefile tests/conftest.py configs/quick.yaml docs/results.md \
    packaging/Dockerfile RELEASING.md roughbench/report/plotly/LICENSE; do
    grep -q "^roughbench-[^/]*/$needed *$" "$folder/content" ||
        { echo "error: $needed is not in the source archive" >&2; exit 1; }
done

for archive in "$wheel" "$source"; do
    echo "== $(basename "$archive")"
    fresh venv "$archive"
    (
        cd "$folder"
        venv/bin/roughbench --version
        venv/bin/roughbench --help > help
        venv/bin/roughbench run "$spec" --quiet -o smoke.h5
        venv/bin/roughbench plot smoke.h5 -o figures | wc -l
        venv/bin/roughbench report smoke.h5 --resamples 20
        rm -r smoke.h5.rbrun
        venv/bin/roughbench verify smoke.h5
        rm smoke.h5
    )
done

echo "== without pyFFTW"
"$python" -m pip --python "$folder/venv/bin/python" uninstall --quiet --yes pyfftw
(
    cd "$folder"
    venv/bin/roughbench run "$spec" --quiet -o scipy.h5
    venv/bin/roughbench show scipy.h5 --json > scipy.json
    grep -q '"fft": "scipy"' scipy.json
)

echo "== pipx run"
(
    cd "$folder"
    PIPX_HOME="$folder/pipx" "$folder/tools/bin/pipx" run --python "$python" \
        --spec "$wheel" roughbench run "$spec" --quiet -o pipx.h5
    test -s pipx.h5
)
echo "dist: both archives install and run"
