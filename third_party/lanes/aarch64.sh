#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# aarch64, by Debian 12's cross compiler and qemu on another processor: builds the program against Debian's arm64
# packages and compares the weights of a short training with those of the other lanes. Needs no root once the
# compiler and qemu are there. On an aarch64 machine use the other lanes.
# S2NNDS_SYSROOT names another folder for the arm64 packages than build/lanes/aarch64-sysroot (1.4 GB).
# Usage: bash third_party/lanes/aarch64.sh [-DOPTION=VALUE]...      (builds in build/lanes/aarch64)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

stop() {
  echo "aarch64.sh: $*" >&2
  exit 1
}

# shellcheck source=/dev/null
. /etc/os-release
[[ ${ID:-} == debian && ${VERSION_ID:-} == 12 ]] \
  || stop "found ${PRETTY_NAME:-an unknown system}; expected Debian 12, whose packages it takes"
for command in aarch64-linux-gnu-g++ qemu-aarch64-static cmake ninja; do
  command -v "$command" >/dev/null \
    || stop "found no $command (apt-get install g++-aarch64-linux-gnu qemu-user-static cmake ninja-build)"
done

# apt with lists and a cache of its own: what is installed on this machine stays as it is.
lay_sysroot() {
  local -r root=$1
  local -r lists=$root/apt
  mkdir -p "$lists"/{lists/partial,archives/partial,etc/{apt.conf.d,preferences.d}}
  : >"$lists/status"
  echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] http://deb.debian.org/debian bookworm main" \
    >"$lists/etc/sources.list"
  cat >"$lists/apt.conf" <<END
Dir::Etc "$lists/etc";
Dir::State::lists "$lists/lists";
Dir::State::status "$lists/status";
Dir::Cache "$lists";
APT::Architecture "arm64";
APT::Architectures { "arm64"; };
APT::Install-Recommends "false";
APT::Sandbox::User "";
Debug::NoLocking "true";
END
  local packages
  packages=$(sed -n 's/^build \(lib[^ ]*-dev\|nlohmann-json3-dev\) .*/\1/p' third_party/install.sh)
  APT_CONFIG=$lists/apt.conf apt-get update -qq
  # shellcheck disable=SC2086  # one word a package
  APT_CONFIG=$lists/apt.conf apt-get install -y -qq --download-only $packages libopenblas0-pthread >"$lists/log" \
    || stop "apt-get could not fetch the arm64 packages; see $lists/log"
  local file link
  for file in "$lists"/archives/*.deb; do dpkg -x "$file" "$root"; done
  # Links that count from the root of an arm64 machine, and those that its installation would make.
  find "$root" -type l -lname '/*' | while read -r link; do ln -sfr "$root$(readlink "$link")" "$link"; done
  ln -sf openblas-pthread/lib{openblas.so.0,blas.so.3,lapack.so.3} "$root/usr/lib/aarch64-linux-gnu/"
  rm -r "$lists/archives"
  touch "$root/complete"
}

root=$(realpath -m "${S2NNDS_SYSROOT:-build/lanes/aarch64-sysroot}")
if [[ ! -e $root/complete ]]; then
  echo "aarch64.sh: laying arm64 packages into $root"
  lay_sysroot "$root"
fi
build=build/lanes/aarch64
SECONDS=0
cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release --toolchain third_party/lanes/aarch64.cmake \
  "-DS2NNDS_SYSROOT=$root" -DS2NNDS_BUILD_TESTS=OFF "$@"
# The one that has LibTorch: s2nnds would start it, which qemu alone cannot do.
cmake --build "$build" --target s2nnds_torch_program --parallel "${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}"
echo "lane aarch64: building the program took $SECONDS s"
SECONDS=0
bash tests/lanes/weight_hash.sh --only plain qemu-aarch64-static -L "$root" "$build/python/s2nnds/s2nnds-torch"
echo "lane aarch64: training took $SECONDS s"
