#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# A sweep on a real Slurm: controller, node daemon and munge on this machine, from Debian's packages, with a configuration
# of their own below a temporary folder. Submits an array of eight trials, kills one trial, kills one whole task, requeues
# a third, restarts the node daemon in the middle; at the end everything must be there, and the disturbed trials must
# equal undisturbed ones. Needs root (or sudo, for the packages alone). Usage: tests/slurm.sh PATH_OF_S2NNDS
set -euo pipefail
program=$(readlink -f "${1:?usage: tests/slurm.sh PATH_OF_S2NNDS}")
project=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
export PATH=$PATH:/usr/sbin:/sbin

say() { echo "$(date +%T) slurm.sh: $*"; }
stop() {
  say "FAILED: $*" >&2
  for log in "$work"/*.log "$work"/out/slurm/*.log; do
    [[ -s $log ]] && { echo "--- $log"; tail -n 15 "$log"; }
  done >&2
  exit 1
}

if [[ $(id -u) -ne 0 ]]; then
  say "skipped: slurmctld and slurmd need root here"
  exit 77
fi
if ! command -v slurmctld >/dev/null || ! command -v slurmd >/dev/null || ! command -v munged >/dev/null; then
  say "installing slurm-wlm and munge"
  if ! { apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends slurm-wlm munge; } \
    >/dev/null 2>&1; then
    say "skipped: apt-get cannot install slurm-wlm and munge"
    exit 77
  fi
fi

work=$(mktemp -d /tmp/s2nnds-slurm.XXXXXX)
chmod 755 "$work"
export SLURM_CONF=$work/slurm.conf
pids=()
start_daemon() {  # keeps the process in the foreground of a background job, so that it can be ended by its id
  "$@" >>"$work/daemons.log" 2>&1 &
  last_pid=$!
  pids+=("$last_pid")
}
clean_up() {
  code=$?
  scancel --user=root --quiet 2>/dev/null || true
  sleep 1
  for pid in "${pids[@]}"; do kill "$pid" 2>/dev/null || true; done
  for pid in "${pids[@]}"; do wait "$pid" 2>/dev/null || true; done
  if [[ -n ${S2NNDS_KEEP:-} ]]; then say "kept $work"; else rm -rf "$work"; fi
  exit "$code"
}
trap clean_up EXIT

# ---- Slurm
host=$(hostname -s)
mkdir -p "$work"/{controller,node,munge}
chmod 711 "$work/munge"
dd if=/dev/urandom of="$work/munge/key" bs=1024 count=1 status=none
chmod 600 "$work/munge/key"
cat >"$SLURM_CONF" <<EOF
ClusterName=s2nnds
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$work/munge/socket
SlurmctldPort=17817
SlurmdPort=17818
StateSaveLocation=$work/controller
SlurmdSpoolDir=$work/node
SlurmctldPidFile=$work/controller/pid
SlurmdPidFile=$work/node/pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SwitchType=switch/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmdParameters=config_overrides
SchedulerParameters=sched_min_interval=100000,batch_sched_delay=1
ReturnToService=2
InactiveLimit=0
KillWait=5
MinJobAge=600
JobRequeue=1
NodeName=$host NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=test Nodes=$host Default=YES MaxTime=INFINITE State=UP
EOF
start_daemon munged --foreground --force --key-file="$work/munge/key" --socket="$work/munge/socket" \
  --pid-file="$work/munge/pid" --log-file="$work/munge/log" --seed-file="$work/munge/seed"
for _ in {1..50}; do [[ -S $work/munge/socket ]] && break; sleep 0.1; done
start_daemon slurmctld -D
start_node() { start_daemon slurmd -D -N "$host"; node_pid=$last_pid; }
start_node
for _ in {1..100}; do
  [[ $(sinfo --noheader --format=%T 2>/dev/null || true) == idle ]] && break
  sleep 0.3
done
[[ $(sinfo --noheader --format=%T) == idle ]] || stop "the node did not come up: $(sinfo 2>&1)"
say "started $(slurmctld -V): controller, node $host with 2 processors, munge"

# ---- the sweep: eight trials of some seconds each
cat >"$work/sweep.toml" <<EOF
name = "slurm"
configs = ["$project/experiments/configs/handwriting/Sine.toml"]
seeds = [0, 1]
set = ["networks.f.hidden=[16]", "networks.V.hidden=[16]", "networks.B.hidden=[16]", "training.rounds=8",
  "training.min_rounds=8", "training.steps=${S2NNDS_STEPS:-800}", "training.rollout_points=200", "training.samples=2000",
  "training.warm_start.steps=200", "training.warm_start.attempts=1", "verification.method=sampled",
  "verification.sampled.samples=2000", "evaluation.area_cells=20", "evaluation.grid_points=11"]
objective = "mse_train"
[axes]
"training.loss.decay_rate" = [0.1, 0.2]
"training.rate_f" = [1e-3, 2e-3]
EOF
out=$work/out
submit() { (cd "$work" && "$program" sweep sweep.toml --out out --slurm partition=test,time=00:20:00,throttle=2,chunk=1); }
results() { find "$out/runs" -name '*.json' | wc -l; }
# The folder tells this sweep's processes from all others.
process_of() { pgrep -f -- "--out $out --trial $1 " | head -n 1 || true; }
task_of() { pgrep -f -- "--out $out .*--only $1-$1\$" | head -n 1 || true; }
await() {  # what, seconds, command...
  local what=$1 seconds=$2
  shift 2
  for ((k = 0; k < seconds * 2; ++k)); do
    "$@" && return
    sleep 0.5
  done
  stop "waited $seconds s for $what"
}
has_run_file() { [[ -e $out/runs/0000/000000$1.h5 ]]; }
in_queue() { [[ -n $(squeue --noheader) ]]; }
queue_is_empty() { ! in_queue; }

submit
job=$(tail -n 1 "$out/slurm/jobs.txt")
[[ $(grep -c . "$out/slurm/jobs.txt") -eq 1 ]] || stop "expected one job"
say "the same command while the job is in the queue: $(submit)"
[[ $(grep -c . "$out/slurm/jobs.txt") -eq 1 ]] || stop "it submitted the trials twice"

await "trial 0 to be on its way" 60 has_run_file 0
pid=$(process_of 0)
[[ -n $pid ]] || stop "found no process of trial 0"
kill -9 "$pid"
say "killed trial 0 (process $pid) after its first rounds"

await "trial 1 to be on its way" 60 has_run_file 1
pid=$(task_of 1)
[[ -n $pid ]] || stop "found no process of task 1"
kill -9 "$pid"
say "killed the whole task 1 (process $pid)"

kill "$node_pid"
wait "$node_pid" || true
say "stopped the node's daemon; $(results) results so far"
sleep 2
start_node
say "started the node's daemon again"

await "trial 2 to be on its way" 120 has_run_file 2
scontrol requeue "${job}_2"
say "requeued task 2"

await "the queue to be empty" 900 queue_is_empty
say "the queue is empty: $(results) of 8 results"
[[ $(results) -eq 7 ]] || stop "expected 7 results, all but that of the killed task"
grep -h "start" "$out"/slurm/"${job}"_2.log | sed 's/^/    /'
grep -q "start 1" "$out/slurm/${job}_2.log" || stop "task 2 was not started again"
grep -q "was killed by signal 9; it goes on" "$out/slurm/${job}_0.log" || stop "trial 0 was not taken up again"

submit
await "the queue to be empty" 300 queue_is_empty
[[ $(results) -eq 8 ]] || stop "expected 8 results, found $(results)"
say "the same command submitted the missing trial alone; now 8 of 8 results"
(cd "$work" && "$program" sweep sweep.toml --out out) 2>&1 | sed 's/^/    /'
[[ $(grep -c ',done,' "$out/table.csv") -eq 8 ]] || stop "expected 8 trials that are done in table.csv"

for trial in 0 1 2; do
  (cd "$work" && "$program" sweep sweep.toml --out undisturbed --trial $trial >>"$work/undisturbed.log" 2>&1) || [[ $? -eq 3 ]]
  /usr/bin/python3 - "$project" "$out/runs/0000/000000$trial.h5" "$work/undisturbed/runs/0000/000000$trial.h5" <<'EOF' ||
import sys
sys.path.insert(0, sys.argv[1] + "/tests/program")
from command_line import differences
found = differences(sys.argv[2], sys.argv[3])
print("    differences:", found or "none")
sys.exit(1 if found else 0)
EOF
    stop "trial $trial differs from an undisturbed one"
done
say "the killed, the requeued and the resubmitted trial equal undisturbed ones"

# ---- many trials that end at once: two thousand, each a script that writes a result, in tasks of twenty
out=$work/many
/usr/bin/python3 - "$project" "$work" <<'EOF'
import os, sys
sys.path.insert(0, sys.argv[1] + "/tests/program")
sys.argv[1:2] = []
from many_trials_test import STUB
from sweep_test import sweep_text
for name, text in (("stub", STUB), ("many.toml", sweep_text('"training.loss.decay_rate" = { log_range = [0.01, 1.0] }',
                                                            design='"sobol"', points="1000"))):
    with open(f"{sys.argv[1]}/{name}", "w", encoding="utf-8") as file:
        file.write(text)
os.chmod(f"{sys.argv[1]}/stub", 0o755)
EOF
began=$(date +%s.%N)
(cd "$work" && "$program" sweep many.toml --out many --program "$work/stub" --slurm partition=test,time=00:20:00,chunk=20)
say "sbatch took $(echo "$(date +%s.%N) $began" | awk '{printf "%.1f", $1 - $2}') s, its start of the program included"
await "the queue to be empty" 900 queue_is_empty
say "100 tasks took $(echo "$(date +%s.%N) $began" | awk '{printf "%.0f", $1 - $2}') s, two at once; $(results) results"
[[ $(results) -eq 2000 ]] || stop "expected 2000 results, found $(results)"
sdiag_text=$(sdiag)

# ---- successive halving: the second rung is submitted by a job that waits for the first
cat >>"$work/many.toml" <<'EOF'

[halving]
key = "training.steps"
budgets = [5, 10, 20]
keep = 0.25
EOF
sed -e 's/^points = 1000/points = 16/' -e 's/^name = .*/name = "halving"/' "$work/many.toml" >"$work/halving.toml"
out=$work/halving
(cd "$work" && "$program" sweep halving.toml --out halving --program "$work/stub" --slurm partition=test,time=00:20:00,chunk=4)
await "all rungs to be over" 300 queue_is_empty
[[ $(results) -eq 42 ]] || stop "expected 32 + 8 + 2 results of three rungs, found $(results)"
say "halving: $(results) results of three rungs, $(grep -c . "$out/slurm/jobs.txt") jobs, each rung submitted by the job before"
say "scheduler: $(grep -E 'Mean cycle|Max cycle|Mean depth' <<<"$sdiag_text"| head -n 3 | tr -s ' \t\n' ' ')"
say "passed"
