#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Installs what the project needs and this machine lacks, by apt. Safe to run again. Asks for root (sudo) only when
# something is missing.
# Usage: bash third_party/install.sh [build] [test] [notebook] [robot]      (default: the first three)
#   build      the library, the program, and the Python packages of its figures
#   test       the tests
#   notebook   Jupyter, for notebooks_export/*.ipynb; what cannot be had of it is named and stops nothing, nor does
#              the lack of cpp-httplib (s2nnds studio) or of a browser (its tests)
#   robot      MuJoCo, for experiments/robot_drawing
# Where apt has no LibTorch (Ubuntu 24.04), pip's torch goes into the virtual environment build/venv, where CMake and
# the tests find it. `build` alone then brings what the program runs with, `test` the whole torch: several gigabytes
# with CUDA. PIP_INDEX_URL=https://download.pytorch.org/whl/cpu picks one without CUDA.
# S2NNDS_TORCH=pip takes pip's torch also where apt has one; S2NNDS_VENV names another folder than build/venv.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

# Set, package, and what shows that it is there although apt did not install it.
packages="
build build-essential command:g++
build cmake command:cmake
build ninja-build command:ninja
build pkg-config command:pkg-config
build libtorch-dev torch
build libtbb-dev header:tbb/tbb.h
build libeigen3-dev header:eigen3/Eigen/Core
build libboost-dev header:boost/version.hpp
build libhdf5-dev header:hdf5/serial/hdf5.h
build libfmt-dev header:fmt/format.h
build zlib1g-dev header:zlib.h
build libspdlog-dev header:spdlog/spdlog.h
build libmatio-dev header:matio.h
build libzip-dev header:zip.h
build libtomlplusplus-dev header:toml++/toml.h
build libcli11-dev header:CLI/CLI.hpp
build nlohmann-json3-dev header:nlohmann/json.hpp
build libonnx-dev header:onnx/onnx_pb.h
build libprotobuf-dev header:google/protobuf/message.h
build libssl-dev header:openssl/evp.h
build libflint-arb-dev arb
build libcpp-httplib-dev header:httplib.h
build python3 command:python3
build python3-numpy module:numpy
build python3-h5py module:h5py
build python3-matplotlib module:matplotlib
test hdf5-tools command:h5dump
test pybind11-dev header:pybind11/pybind11.h
test python3-dev command:python3-config
test python3-pytest module:pytest
test libgtest-dev header:gtest/gtest.h
test libbenchmark-dev header:benchmark/benchmark.h
test python3-torch module:torch
test python3-scipy module:scipy
test python3-sklearn module:sklearn
test python3-onnx module:onnx
test python3-selenium module:selenium
test chromium command:chromium
test chromium-driver command:chromedriver
notebook jupyter-nbconvert command:jupyter-nbconvert
notebook python3-ipykernel module:ipykernel
robot libmujoco-dev header:mujoco/mujoco.h
"
declare -A pip_name=([python3-numpy]=numpy [python3-h5py]=h5py [python3-matplotlib]=matplotlib [python3-scipy]=scipy
  [python3-sklearn]=scikit-learn [python3-onnx]=onnx [python3-pytest]=pytest)
venv=${S2NNDS_VENV:-build/venv}
prefixes=${CMAKE_PREFIX_PATH:-}
prefixes=${prefixes//[:;]/ }

say() {
  echo "third_party/install.sh: $*"
}

stop() {
  say "$*" >&2
  exit 1
}

installed() {  # by apt
  [[ $(dpkg-query -W -f '${Status}' "$1" 2>/dev/null || true) == "install ok installed" ]]
}

apt_has() {
  [[ $(apt-cache policy "$1" 2>/dev/null) =~ Candidate:\ [^\(] ]]
}

python() {
  if [[ -x $venv/bin/python ]]; then echo "$venv/bin/python"; else echo "${S2NNDS_PYTHON:-/usr/bin/python3}"; fi
}

has_module() {
  "$(python)" -c "import importlib.util, sys; sys.exit(importlib.util.find_spec('$1') is None)" 2>/dev/null
}

has_header() {
  local folder
  for folder in /usr /usr/local ${CONDA_PREFIX:-} $prefixes; do
    [[ ! -e $folder/include/$1 ]] || return 0
  done
  return 1
}

has_openblas() {
  [[ $(/sbin/ldconfig -p 2>/dev/null || true) == *libopenblas.so* ]]
}

pip_torch() {  # the folder of pip's torch, if it is there
  local file
  for file in "$venv"/lib/python3*/site-packages/torch/share/cmake/Torch/TorchConfig.cmake; do
    [[ ! -e $file ]] || echo "${file%/share/cmake/*}"
  done
}

# Signs of packages that apt did not install.
there() {
  local folder
  case $1 in
    command:*) command -v "${1#*:}" >/dev/null ;;
    header:*) has_header "${1#*:}" ;;
    module:*) has_module "${1#*:}" ;;
    arb) has_header flint/arb.h || { has_header arb.h && has_header flint/flint.h; } ;;
    torch)
      for folder in $prefixes; do
        [[ ! -e $folder/Torch/TorchConfig.cmake && ! -e $folder/share/cmake/Torch/TorchConfig.cmake ]] || return 0
      done
      [[ -n ${Torch_DIR:-} ]]
      ;;
  esac
}

as_root() {
  if [[ $(id -u) -eq 0 ]]; then "$@"; else sudo "$@"; fi
}

apt_install() {
  say "installing $*"
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@"
}

make_venv() {
  [[ -x $venv/bin/python ]] || /usr/bin/python3 -m venv --system-site-packages "$venv" || stop "could not make $venv"
}

# pip's torch, wholly or as much of it as a C++ program runs with: it links CUDA's run time and profiler.
install_pip_torch() {
  local -r pip=("$venv/bin/python" -m pip install --quiet --disable-pip-version-check)
  make_venv
  say "installing pip's torch into $venv"
  if [[ $1 == whole ]]; then
    "${pip[@]}" --upgrade torch || stop "pip could not install torch; is there a network?"
    return
  fi
  "${pip[@]}" --upgrade --no-deps torch || stop "pip could not install torch; is there a network?"
  local cuda
  cuda=$("$venv/bin/python" -c '
import importlib.metadata, re
for line in importlib.metadata.requires("torch") or []:
    found = re.match(r"cuda-toolkit\[[^]]*\]([^;]*)", line)
    if found:
        print("cuda-toolkit[cudart,cupti]" + found[1].strip())')
  # pip names what the whole torch needs besides as conflicts.
  [[ -z $cuda ]] || "${pip[@]}" "$cuda" 2>"$venv/pip.log" || say "pip could not install $cuda; see $venv/pip.log"
  "$venv/bin/python" -c 'import ctypes, sys; ctypes.CDLL(sys.argv[1])' "$(pip_torch)/lib/libtorch_cpu.so" 2>/dev/null \
    || install_pip_torch whole
}

# One test uses it. It comes with pip's torch alone: apt has none on Debian 12 and Ubuntu 24.04.
bring_onnxruntime() {
  [[ " ${sets[*]} " == *" test "* && -n $(pip_torch) ]] && ! has_module onnxruntime || return 0
  say "installing pip's onnxruntime into $venv"
  "$venv/bin/python" -m pip install --quiet --disable-pip-version-check --retries 1 onnxruntime \
    || say "pip could not install onnxruntime; going on without it"
}

sets=("$@")
[[ ${#sets[@]} -gt 0 ]] || sets=(build test notebook)
for name in "${sets[@]}"; do
  [[ $name =~ ^(build|test|notebook|robot)$ ]] || stop "found the set $name; expected build, test, notebook or robot"
done

# Needed by the sets and not there: packages, and parts of torch (libtorch-dev, python3-torch).
missing=()
optional=()
torch=()
while read -r name package sign; do
  [[ -n $name && " ${sets[*]} " == *" $name "* ]] || continue
  if [[ $sign == torch || $sign == module:torch ]] && [[ -n $(pip_torch) || ${S2NNDS_TORCH:-} == pip ]]; then
    if [[ -z $(pip_torch) ]] || { [[ $sign != torch ]] && ! "$(python)" -c 'import torch' 2>/dev/null; }; then
      torch+=("$package")
    fi
  elif there "$sign"; then
    continue
  # apt's modules are of no use to a virtual environment that does not see the system's.
  elif installed "$package" && [[ -z ${pip_name[$package]:-} || ! -x $venv/bin/python ]]; then
    continue
  elif [[ $package == *torch* ]]; then
    torch+=("$package")
  elif [[ $name =~ ^(notebook|robot)$ || $package =~ ^(libcpp-httplib-dev|chromium|chromium-driver|python3-selenium)$ ]]; then
    optional+=("$package")
  else
    missing+=("$package")
  fi
done <<<"$packages"
# Without it apt's LibTorch multiplies matrices by the reference BLAS, many times slower. pip's brings its own.
if installed libtorch-dev && [[ -z $(pip_torch) && ${S2NNDS_TORCH:-} != pip && " ${sets[*]} " == *" build "* ]] \
  && ! has_openblas; then
  optional+=(libopenblas0-pthread)
fi
if [[ ${#missing[@]} -eq 0 && ${#optional[@]} -eq 0 && ${#torch[@]} -eq 0 ]]; then
  bring_onnxruntime
  say "${sets[*]}: all is there"
  exit 0
fi

command -v apt-get >/dev/null \
  || stop "found no apt-get; expected Debian or Ubuntu. Install by hand: ${missing[*]} ${torch[*]} ${optional[*]}"
may_be_root=yes
[[ $(id -u) -eq 0 ]] || command -v sudo >/dev/null || may_be_root=no
if [[ $may_be_root == no ]]; then
  [[ ${#missing[@]} -eq 0 ]] || stop "missing ${missing[*]} ${torch[*]}; run it as root, or install sudo"
  [[ ${#optional[@]} -eq 0 ]] || say "without root it goes on without ${optional[*]}"
  optional=()
elif [[ ${#missing[@]} -gt 0 || ${#optional[@]} -gt 0 || ${S2NNDS_TORCH:-} != pip ]]; then
  as_root apt-get update -qq || say "apt-get update failed; going on with the lists that are there"
fi

# torch: apt's, if it has both parts; else pip's.
if [[ ${#torch[@]} -gt 0 ]]; then
  whole=part
  [[ " ${torch[*]} " != *" python3-torch "* ]] || whole=whole
  if [[ ${S2NNDS_TORCH:-} != pip && -z $(pip_torch) && $may_be_root == yes ]] \
    && apt_has libtorch-dev && apt_has python3-torch; then
    missing+=("${torch[@]}")
    torch=()
    has_openblas || optional+=(libopenblas0-pthread)
  fi
fi

from_apt=()
from_pip=()
for package in "${missing[@]}"; do
  # Arb is a part of FLINT since FLINT 3 (Debian 13, Ubuntu 24.04).
  [[ $package != libflint-arb-dev ]] || apt_has libflint-arb-dev || package=libflint-dev
  if apt_has "$package" && ! installed "$package"; then
    from_apt+=("$package")
  elif [[ -n ${pip_name[$package]:-} ]]; then
    from_pip+=("${pip_name[$package]}")
  else
    stop "apt has no $package; expected Debian 12, Ubuntu 24.04 or newer (missing: ${missing[*]})"
  fi
done
if [[ ${#torch[@]} -gt 0 || ${#from_pip[@]} -gt 0 ]] && [[ ! -x $venv/bin/python ]] \
  && ! /usr/bin/python3 -c 'import ensurepip, venv' 2>/dev/null; then
  [[ $may_be_root == yes ]] || stop "found no python3-venv for pip's torch; run it as root, or install sudo"
  from_apt+=(python3-venv)
fi
if [[ ${#from_apt[@]} -gt 0 ]]; then
  apt_install "${from_apt[@]}" || stop "apt-get could not install ${from_apt[*]}"
fi
for package in "${optional[@]}"; do
  apt_install "$package" || say "apt could not install $package; going on without it"
done
[[ ${#torch[@]} -eq 0 ]] || install_pip_torch "$whole"
if [[ ${#from_pip[@]} -gt 0 ]]; then
  make_venv
  say "installing ${from_pip[*]} from pip into $venv"
  "$venv/bin/python" -m pip install --quiet --disable-pip-version-check "${from_pip[@]}" \
    || stop "pip could not install ${from_pip[*]}"
fi
bring_onnxruntime
