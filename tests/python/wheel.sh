#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# `pip install .` into a fresh virtual environment with pip's torch, then the tests of the package from there: what
# a wheel holds works by itself. Prints the wheel's size, and the seconds up to a trained motion and its figures.
# Usage: bash tests/python/wheel.sh VENV      (exit code 77: no network)
#   S2NNDS_PYTHON names the Python that makes the environment; one that is there is used, with the torch that it has.
set -euo pipefail
venv=$1
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
project=$(cd "$here/../.." && pwd)
export PIP_DISABLE_PIP_VERSION_CHECK=1 CMAKE_BUILD_PARALLEL_LEVEL=${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}

[[ -x $venv/bin/python ]] || "${S2NNDS_PYTHON:-/usr/bin/python3}" -m venv "$venv"
unset S2NNDS_PYTHON  # from here on the environment's: the program draws figures with the one that is named
if ! "$venv/bin/python" -m pip install -q torch pytest; then
  echo "wheel.sh: pip could not install torch; is there a network?" >&2
  exit 77
fi
SECONDS=0
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$venv/bin/python" -m pip wheel -q --no-deps -w "$work" "$project"
echo "wheel.sh: $(du -h "$work"/s2nnds-*.whl | tr '\t' ' ') after $SECONDS s"
"$venv/bin/python" -m pip install -q --force-reinstall --no-deps "$work"/s2nnds-*.whl
"$venv/bin/python" -m pip install -q "$work"/s2nnds-*.whl  # what it requires
cd "$work"
"$venv/bin/s2nnds" train "$project/experiments/configs/handwriting/Sine.toml" --out Sine.h5 >/dev/null 2>train.log \
  || { cat train.log >&2; exit 1; }
"$venv/bin/s2nnds" plot Sine.h5 --out figures
echo "wheel.sh: a proved motion and its figures after $SECONDS s"
env -u PYTHONPATH "$venv/bin/python" -m pytest -q -p no:cacheprovider "$here"
