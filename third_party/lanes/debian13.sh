#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Debian 13: GCC 14, LibTorch 2.6, HDF5 1.14. On another machine a Debian 13 is laid into the folder build/lanes/trixie
# (4 GB; needs debootstrap and root) and a copy of this project's tracked files runs there.
# S2NNDS_TRIXIE names another folder, which may hold a Debian 13 already.
# Usage: bash third_party/lanes/debian13.sh [-DOPTION=VALUE]...
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
# shellcheck source=/dev/null
. /etc/os-release
if [[ ${ID:-} == debian && ${VERSION_ID:-} == 13 ]]; then
  exec bash third_party/lanes/lane.sh debian13 "$@"
fi

stop() {
  echo "debian13.sh: $*" >&2
  exit 1
}

root=${S2NNDS_TRIXIE:-build/lanes/trixie}
[[ $(id -u) -eq 0 ]] || stop "found no root; expected it, to lay a Debian 13 into $root and run there"
if [[ ! -e $root/etc/apt/sources.list ]]; then
  command -v debootstrap >/dev/null || stop "found no debootstrap; install it (apt-get install debootstrap)"
  echo "debian13.sh: laying a Debian 13 into $root"
  mkdir -p "$root"
  debootstrap --variant=minbase --include=ca-certificates trixie "$root" >"$root.log" \
    || stop "debootstrap failed; see $root.log"
fi
cp /etc/resolv.conf "$root/etc/resolv.conf"

# The project as it is now, without what it has built.
rm -rf "$root/s2nnds"
mkdir "$root/s2nnds"
changed=$(git -c safe.directory='*' stash create)
git -c safe.directory='*' archive "${changed:-HEAD}" | tar -x -C "$root/s2nnds"

# /proc, /dev and /sys are mounted in a name space of its own, which ends with the lane.
# shellcheck disable=SC2016  # the inner shell expands these
exec unshare --mount bash -c '
  set -euo pipefail
  root=$1
  shift
  for folder in proc dev sys; do mount --rbind "/$folder" "$root/$folder"; done
  exec chroot "$root" /usr/bin/env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 \
    bash /s2nnds/third_party/lanes/debian13.sh "$@"' in_debian13 "$root" "$@"
