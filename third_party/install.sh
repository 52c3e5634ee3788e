#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Installs the Debian packages that the project needs, those that are missing and no others. Safe to run again.
# Needs root or sudo only when something is missing. Usage: bash third_party/install.sh
set -euo pipefail

packages=(
  build-essential cmake ninja-build pkg-config
  libtorch-dev                 # networks, autograd, TorchScript
  libtbb-dev                   # loops shared among threads
  libeigen3-dev libboost-dev   # matrices; Math, Odeint, Multiprecision, autodiff (headers only)
  libhdf5-dev hdf5-tools       # run files
  libfmt-dev libspdlog-dev     # all messages; the program's log (users of the library need no spdlog)
  libmatio-dev                 # MATLAB files
  libtomlplusplus-dev libcli11-dev nlohmann-json3-dev
  libonnx-dev libprotobuf-dev  # ONNX export
  libssl-dev                   # SHA-256 of the certified weights
  libgtest-dev libbenchmark-dev libmpfr-dev
  python3 python3-torch python3-numpy python3-scipy python3-sklearn python3-h5py python3-matplotlib python3-onnx
  jupyter-nbconvert python3-ipykernel   # runs the notebooks
)

stop() {
  echo "third_party/install.sh: $*" >&2
  exit 1
}

if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
  stop "found no apt-get; expected Debian 12 or a relative of it. Install by hand: ${packages[*]}"
fi

missing=()
for package in "${packages[@]}"; do
  state=$(dpkg-query -W -f '${Status}' "$package" 2>/dev/null || true)
  [[ $state == "install ok installed" ]] || missing+=("$package")
done
if [[ ${#missing[@]} -eq 0 ]]; then
  echo "third_party/install.sh: all ${#packages[@]} packages are installed"
  exit 0
fi

as_root=()
if [[ $(id -u) -ne 0 ]]; then
  command -v sudo >/dev/null || stop "missing ${missing[*]}; run it as root, or install sudo"
  as_root=(sudo)
fi

echo "third_party/install.sh: installing ${missing[*]}"
"${as_root[@]}" apt-get update -qq || stop "apt-get update failed; is there a network?"
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" \
  || stop "apt-get could not install ${missing[*]}; expected a release that has them (Debian 12)"
