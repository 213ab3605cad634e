#!/bin/sh
# Run every command once, on tiny grids, in a folder of its own. `roughbench` is the one
# on PATH.
set -eu
cd "$(dirname "$0")/.."
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

roughbench --version
roughbench validate configs/*.yaml configs/paper/*.yaml
roughbench schema > "$folder/schema.json"
roughbench run configs/smoke.yaml --threads 1 -j 1 -o "$folder/smoke.h5"
roughbench run configs/smoke.yaml --threads 1 -j 2 -o "$folder/jobs.h5" --quiet
cmp "$folder/smoke.h5" "$folder/jobs.h5"
roughbench run configs/smoke.yaml --threads 1 -o "$folder/smoke.h5" -n | grep -x "nothing to compute"
roughbench status "$folder/smoke.h5" | grep "complete, 70 of 70"
roughbench verify "$folder/smoke.h5"
roughbench clean "$folder/smoke.h5"
test ! -e "$folder/smoke.h5.rbrun"
roughbench show "$folder/smoke.h5"
roughbench show "$folder/smoke.h5" --json > "$folder/smoke.json"
roughbench fit "$folder/smoke.h5" --json --resamples 20 > "$folder/fit.json"
for json in schema smoke fit; do python -m json.tool "$folder/$json.json" > "$folder/parsed"; done
roughbench report "$folder/smoke.h5" -o "$folder/report.html" --resamples 20
grep -c 'id="claim-' "$folder/report.html"
roughbench export "$folder/smoke.h5" --csv "$folder/tables" --states
roughbench plot "$folder/smoke.h5" -o "$folder/figures"
for suffix in pdf png; do
    for figure in spectrum area separation stiffness fig3; do
        test -s "$folder/figures/$figure.$suffix"
    done
done

# Observables and fields: whatever the number of jobs, and what comes of them.
for jobs in 1 2; do
    roughbench run configs/smoke.yaml --threads 1 -j "$jobs" -o "$folder/seen-$jobs.h5" --quiet \
        --set 'observables=[pressure_pdf, stress_spectrum, clusters]' \
        --set 'save_fields={pressures: [1.0e-3, 0.1]}'
done
cmp "$folder/seen-1.h5" "$folder/seen-2.h5"
roughbench verify "$folder/seen-1.h5"
roughbench plot "$folder/seen-1.h5" -o "$folder/figures" --figure pressure_pdf --figure contact --figure foundation
roughbench export "$folder/seen-1.h5" --csv "$folder/seen"
test -s "$folder/figures/pressure_pdf.pdf"
test -s "$folder/figures/contact.png"
test -s "$folder/figures/foundation.pdf"
test -s "$folder/seen/surface.qr=4.0-bem-stress_spectrum.csv"

# Units: the same in SI, and as a person would write it.
roughbench run configs/units.yaml --threads 1 -o "$folder/units.h5" --quiet
roughbench show "$folder/units.h5" | grep -F "p [MPa]"
roughbench fit "$folder/units.h5" --resamples 20 | grep -F "from p [MPa]"
roughbench export "$folder/units.h5" --csv "$folder/units"
grep -F "stiffness_mean [Pa/m]" "$folder/units/surface.rolloff=10um-bem.csv"
roughbench report "$folder/units.h5" -o "$folder/units.html" --resamples 20
roughbench plot "$folder/units.h5" -o "$folder/units"

# The tutorials say what their commands print.
python scripts/spec_tutorial.py
python scripts/scan_tutorial.py

# A fault ends with its documented exit code and one message.
code=0
roughbench run configs/smoke.yaml --set surface.H=2 -o "$folder/none.h5" 2> "$folder/fault" \
    || code=$?
test "$code" -eq 2
grep -F "surface.H: must be less than 1, got 2" "$folder/fault"
test ! -e "$folder/none.h5"
echo "smoke: all commands did what they say"
