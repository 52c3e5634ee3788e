#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Runs a lane in a system of its own: SUITE is laid into build/lanes/SUITE, unless it is there already, and a copy of
# the tracked files of this project as they are now is built and tested inside. Needs debootstrap, root and 4 GB.
# S2NNDS_LANE_ROOTS names another folder than build/lanes for the systems.
# Usage: bash third_party/lanes/chroot.sh SUITE MIRROR LANE [-DOPTION=VALUE]...      (LANE: a script of this folder)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
suite=$1
mirror=$2
lane=$3
shift 3
root=${S2NNDS_LANE_ROOTS:-build/lanes}/$suite

stop() {
  echo "$lane: $*" >&2
  exit 1
}

[[ $(id -u) -eq 0 ]] || stop "found no root; expected it, to lay $suite into $root and run there"
if [[ ! -e $root/etc/apt/sources.list ]]; then
  command -v debootstrap >/dev/null || stop "found no debootstrap; install it (apt-get install debootstrap)"
  echo "$lane: laying $suite into $root"
  mkdir -p "$root"
  options=(--variant=minbase --include=ca-certificates)
  script=()
  if [[ $mirror == *ubuntu* ]]; then
    options+=("--components=main,universe")
    [[ -e /usr/share/debootstrap/scripts/$suite ]] || script=(/usr/share/debootstrap/scripts/gutsy)  # all of Ubuntu's are this
  fi
  debootstrap "${options[@]}" "$suite" "$root" "$mirror" "${script[@]}" >"$root.log" \
    || stop "debootstrap failed; see $root.log"
fi
# The network is reached as from here, also through a proxy with a certificate of its own.
cp /etc/resolv.conf "$root/etc/resolv.conf"
certificates=/etc/ssl/certs/ca-certificates.crt
[[ ! -e $certificates ]] || cp "$certificates" "$root$certificates"

# The project as it is now, without what it has built, save pip's torch in build/venv.
mkdir -p "$root/s2nnds/build"
find "$root/s2nnds" -mindepth 1 -maxdepth 1 ! -name build -exec rm -rf {} +
rm -rf "$root/s2nnds/build/lanes"
changed=$(git -c safe.directory='*' stash create)
git -c safe.directory='*' archive "${changed:-HEAD}" | tar -x -C "$root/s2nnds"

# /proc, /dev and /sys are mounted in a name space of its own, which ends with the lane.
# shellcheck disable=SC2016  # the inner shell expands these
exec unshare --mount bash -c '
  set -euo pipefail
  root=$1
  lane=$2
  shift 2
  for folder in proc dev sys; do mount --rbind "/$folder" "$root/$folder"; done
  exec chroot "$root" /usr/bin/env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 \
    PIP_CERT=/etc/ssl/certs/ca-certificates.crt http_proxy="${http_proxy:-}" https_proxy="${https_proxy:-}" \
    bash "/s2nnds/third_party/lanes/$lane" "$@"' in_chroot "$root" "$lane" "$@"
