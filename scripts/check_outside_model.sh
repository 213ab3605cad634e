#!/bin/sh
# A model from outside, end to end: written by init, installed as a package into a fresh
# environment beside roughbench, and named as a file in a spec:
# sh scripts/check_outside_model.sh PYTHON (one that has pip).
set -eu
python=$1
case $python in */*) python=$(cd "$(dirname "$python")" && pwd)/$(basename "$python") ;; esac
cd "$(dirname "$0")/.."
root=$PWD
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
unset PYTHONPATH

"$python" -m venv --clear --without-pip "$folder/venv"
bin=$folder/venv/bin
"$python" -m pip --python "$bin/python" install --quiet "$root" pytest
cd "$folder"
"$bin/roughbench" init --template model my-theory
if "$bin/roughbench" init --template model my-theory 2> fault; then exit 1; fi
grep -F "my-theory is there already" fault
"$python" -m pip --python "$bin/python" install --quiet ./my-theory

cd my-theory
rm -rf build
"$bin/python" -m pytest -q test_my_theory.py
mkdir ../elsewhere
cp my_theory.yaml ../elsewhere
cd ../elsewhere # its file is not here: the entry point finds it
"$bin/roughbench" validate my_theory.yaml
"$bin/roughbench" run my_theory.yaml -j 2 --quiet
"$bin/roughbench" status my_theory.h5 | grep -F "main/my_theory: done"
"$bin/roughbench" show my_theory.h5 | grep -F "my_theory: MyTheory"
"$bin/roughbench" fit my_theory.h5 | grep -F "my_theory"
"$bin/roughbench" export my_theory.h5 --csv csv | grep -F "main-my_theory.csv"
"$bin/roughbench" plot my_theory.h5 --figure area -o figures
"$bin/roughbench" report my_theory.h5 --resamples 20
grep -qF "MyTheory" report.html
"$bin/roughbench" schema | grep -F '"const": "my_theory"'

"$python" -m pip --python "$bin/python" uninstall --quiet --yes my-theory
if "$bin/roughbench" validate my_theory.yaml 2> fault; then exit 1; fi
grep -F "unknown kind 'my_theory'" fault
"$bin/roughbench" show my_theory.h5 | grep -F "my_theory: MyTheory" # its results stay readable
"$bin/roughbench" plot my_theory.h5 --figure area -o figures

sed 's/kind: my_theory/kind: "my_theory.py:MyTheory"/' my_theory.yaml > file.yaml
cp ../my-theory/my_theory.py .
"$bin/roughbench" run file.yaml -j 2 -o file.h5 --quiet
"$bin/python" - << 'EOF'
import numpy as np
import roughbench as rb

package, file = (rb.load(name)["main"]["my_theory"] for name in ("my_theory.h5", "file.h5"))
assert np.array_equal(package["area"], file["area"])
assert file.attributes["source"] == "my_theory.py:MyTheory"
EOF
echo "outside model: installed and as a file, it does all that a built-in one does"
