#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# What all lanes do once their packages are there: configure, build, compare the weights of a short training with those
# of every other lane, run the tests that are not labelled slow. Prints the seconds of each.
# Usage: bash third_party/lanes/lane.sh NAME [-DOPTION=VALUE]...      (builds in build/lanes/NAME)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
name=$1
build=build/lanes/$name
shift

step() {
  printf '\nlane %s: %s\n' "$name" "$*"
  SECONDS=0
}

done_in() {
  printf 'lane %s: %s took %d s\n' "$name" "$1" "$SECONDS"
}

step "configuring $build"
cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release "$@"
step "building the program"
cmake --build "$build" --target s2nnds_program
done_in "the program's build"
bash tests/lanes/weight_hash.sh "$build/experiments/s2nnds"
step "building the rest"
cmake --build "$build"
done_in "the rest's build"
step "testing"
OMP_WAIT_POLICY=passive ctest --test-dir "$build" --output-on-failure --label-exclude slow -j2
done_in "testing"
