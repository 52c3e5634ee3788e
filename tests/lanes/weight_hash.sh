#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# A short training must end with the same weights, bit for bit, on every platform: those of weight_hash.txt, by the
# kernels without vector instructions and by those of AVX2, which round once where the former round twice.
# Usage: bash tests/lanes/weight_hash.sh [--only KERNELS] PROGRAM      (what runs it, such as qemu, may stand before it)
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
only=
if [[ ${1:-} == --only ]]; then
  only=$2
  shift 2
fi
program=("$@")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

failed=0
compared=0
while read -r kernels expected; do
  [[ -z $only || $kernels == "$only" ]] || continue
  if [[ $kernels == avx2 ]] && ! grep -qw avx2 /proc/cpuinfo; then
    echo "$kernels: skipped, this processor lacks it"
    continue
  fi
  code=0
  # Keys are named whose defaults have changed before: the hashes tell that nothing else has.
  S2NNDS_ISA=$kernels OMP_WAIT_POLICY=passive \
    "${program[@]}" train "$here/../../experiments/configs/handwriting/Sine.toml" --seed 0 \
    --set training.rounds=3 --set training.min_rounds=3 --set training.steps=40 --set training.warm_start.steps=300 \
    --set training.warm_start.attempts=1 \
    --set training.warm_start.rate=0.002 --set training.warm_start.weight_decay=0.1 \
    --set training.obstacle_margin=0.05 --set networks.B.wall_slope=0 --set 'networks.B.hidden=[64, 64, 64]' \
    --set 'networks.V.hidden=[64, 64]' --set networks.V.features=32 --set training.batch.path=0 --set 'verification.method="sampled"' \
    --set verification.sampled.samples=2000 --set evaluation.area_cells=20 --set evaluation.grid_points=21 \
    --out "$work/$kernels.h5" --json </dev/null >"$work/answer" 2>"$work/log" || code=$?
  # 3: trained, but not verified, as after so few steps.
  if [[ $code -ne 0 && $code -ne 3 ]]; then
    cat "$work/log" >&2
    exit 1
  fi
  found=$(sed -n 's/.*"weight_hash": *"\([0-9a-f]*\)".*/\1/p' "$work/answer" | tail -n 1)
  echo "$kernels: weights $found"
  if [[ $found != "$expected" ]]; then
    echo "weight_hash.sh: $kernels: found weights ${found:-without a hash}; expected $expected" >&2
    failed=1
  fi
  compared=1
done <"$here/weight_hash.txt"
if [[ $compared -eq 0 ]]; then
  echo "weight_hash.sh: found no kernels ${only:-for this processor} to compare; expected one of weight_hash.txt" >&2
  failed=1
fi
exit "$failed"
