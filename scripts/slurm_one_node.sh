#!/bin/bash
# Set up a real Slurm on this machine alone, and run a spec on it in two ways: through
# `--engine slurm` with one of its jobs cancelled in mid-run, and as 40 shares of `submit` of
# which three are killed. Compare the bytes with a local run, and tear it all down.
#
# `slurm_one_node.sh shares` does the second alone, which needs no Dask.
#
# Needs root, and Debian's slurmctld, slurmd, slurm-client and munge; `roughbench` with its
# extra `dask` is the one on PATH. Nothing outside a folder of its own is changed.
set -euo pipefail
cd "$(dirname "$0")/.."

folder=$(mktemp -d)
chmod 755 "$folder"
daemons=()
end() {
    scancel --user root 2> /dev/null || true
    for _ in $(seq 60); do  # a job that nobody hears any more would stay for ever
        [ -z "$(squeue --noheader 2> /dev/null)" ] && break
        sleep 0.5
    done
    for number in TERM KILL; do
        for daemon in "${daemons[@]}"; do kill -$number "$daemon" 2> /dev/null || true; done
        sleep 2
    done
    rm -rf "$folder"
}
trap end EXIT

export SLURM_CONF=$folder/slurm.conf
node=$(hostname -s)
mkdir "$folder/state" "$folder/spool" "$folder/munge"
dd if=/dev/urandom of="$folder/munge/key" bs=1024 count=1 status=none
chmod 400 "$folder/munge/key"
memory=$(awk '/MemAvailable/ { print int($2 / 1024 * 0.8) }' /proc/meminfo)
cat > "$SLURM_CONF" << CONF
ClusterName=one
SlurmctldHost=$node(127.0.0.1)
AuthType=auth/munge
AuthInfo=socket=$folder/munge/socket
CryptoType=crypto/munge
SlurmUser=root
SlurmctldPort=16817
SlurmdPort=16818
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
ReturnToService=2
NodeName=$node NodeAddr=127.0.0.1 CPUs=$(nproc) RealMemory=$memory State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF

munged --foreground --force --key-file="$folder/munge/key" --socket="$folder/munge/socket" \
    --pid-file="$folder/munge/pid" --log-file="$folder/munge/log" \
    --seed-file="$folder/munge/seed" --num-threads=2 &
daemons+=($!)
sleep 1
slurmctld -D 2> "$folder/slurmctld.out" &
daemons+=($!)
sleep 1
slurmd -D -N "$node" 2> "$folder/slurmd.out" &
daemons+=($!)
for _ in $(seq 60); do
    sinfo --noheader --format=%T 2> /dev/null | grep -q idle && break
    sleep 0.5
done
sinfo || { cat "$folder"/*.out "$folder"/*.log; exit 1; }

cat > "$folder/spec.yaml" << SPEC
surface: {H: 0.7, q0: 1.0, q1: 32.0, slope: 0.1}
pressures: {min: 1.0e-3, max: 0.1, points: 12}
realizations: 12
models:
  - {kind: bem, grid: 512}
  - {kind: foundation, realizations: 200}
  - {kind: persson}
SPEC
roughbench run "$folder/spec.yaml" -o "$folder/here.h5" --threads 1 -q
[ "${1:-}" = shares ] || (
    cd "$folder"
    begin=$SECONDS
    roughbench run spec.yaml -o there.h5 --engine slurm --workers 2 --walltime 00:10:00 \
        --partition main -v &
    run=$!
    job=
    while [ -z "$job" ]; do
        sleep 1
        job=$(squeue --noheader --states=R --format=%i | head -n 1)
    done
    until grep -q ": done in" there.h5.rbrun/run.log; do sleep 0.5; done
    scancel "$job"
    echo "cancelled job $job"
    wait $run
    echo "done in $((SECONDS - begin)) s; jobs left: $(squeue --noheader | wc -l)"
)
[ "${1:-}" = shares ] || cmp "$folder/here.h5" "$folder/there.h5"

(
    cd "$folder"
    begin=$SECONDS
    roughbench submit spec.yaml -o shared.h5 --array 40 --walltime 00:10:00 --partition main
    array=$(squeue --noheader --format=%F | sort -n | head -n 1)
    killed=0
    for number in 3 4 11; do  # as they begin: a signal to one that waits ends all that wait
        until squeue --noheader --states=R --format=%K | grep -qx $number; do sleep 0.1; done
        scancel --signal=KILL --full "${array}_$number" && killed=$((killed + 1))
    done
    echo "killed $killed shares of job $array"
    until [ -z "$(squeue --noheader)" ]; do sleep 1; done
    roughbench status shared.h5
    cat shared.h5.rbrun/jobs/*-assemble.out
    said=$(grep -l "share .* computed" shared.h5.rbrun/jobs/"$array"-*.out | wc -l)
    echo "done in $((SECONDS - begin)) s; $said of 40 shares ended by themselves"
    [ "$said" -eq $((40 - killed)) ]
)
cmp "$folder/here.h5" "$folder/shared.h5"
echo "Slurm: the bytes are those of the local run"
