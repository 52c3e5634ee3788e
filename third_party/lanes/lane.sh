#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# What all lanes do: install what is missing, configure, build, compare the weights of a short training with those of
# every other lane, run the tests that are not labelled slow, and those that need packages of pip. Prints the seconds of
# each in the end, also where it fails.
# Usage: bash third_party/lanes/lane.sh NAME [-DOPTION=VALUE]...      (builds in build/lanes/NAME)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
name=$1
shift
build=build/lanes/$name
took=""
trap 'printf "\nlane %s: %s\n" "$name" "$took"' EXIT

step() {
  printf '\nlane %s: %s\n' "$name" "$*"
  SECONDS=0
}

done_in() {
  took+="${took:+, }$1 $SECONDS s"
}

step "installing what is missing"
bash third_party/install.sh build test
done_in set-up
options=("$@")
if [[ -n ${S2NNDS_VENV:-} ]]; then
  options+=("-DCMAKE_PREFIX_PATH=$(echo "$S2NNDS_VENV"/lib/python3*/site-packages/torch/share/cmake)"
    "-DS2NNDS_PYTHON=$S2NNDS_VENV/bin/python")
fi

step "building the program in $build"
cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release "${options[@]}"
cmake --build "$build" --target s2nnds_program --parallel "$(nproc)"
done_in program

step "comparing the weights of a short training"
bash tests/lanes/weight_hash.sh "$build/experiments/s2nnds"
done_in weights

step "building the tests"
cmake --build "$build" --parallel "$(nproc)"
done_in "rest of the build"

step "testing"
OMP_WAIT_POLICY=passive ctest --test-dir "$build" --output-on-failure --label-exclude slow --parallel "$(nproc)"
done_in tests

step "importing recordings, with pip's packages"
if { /usr/bin/python3 -c 'import ensurepip' || apt-get install --yes --quiet python3-venv; } >/dev/null 2>&1 \
  && /usr/bin/python3 -m venv --system-site-packages "$build/import_venv" \
  && "$build/import_venv/bin/python" -m pip install --quiet rosbags mcap 'pyarrow<20'; then  # newer ones want NumPy 2
  for topic in import walkthroughs; do
    "$build/import_venv/bin/python" "tests/program/${topic}_test.py" "$build/experiments/s2nnds"
  done
else
  echo "left out: no python3-venv, or no network"
fi
done_in import
