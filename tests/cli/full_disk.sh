#!/usr/bin/env bash
# Every program on a disk that fills at different points: it ends with its message, or has written
# all its files. Needs a mount namespace of its own for small disks in memory.
set -uo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
if [[ -z ${ACUS_FULL_DISK:-} ]]; then
  if ! unshare -rm true 2>/dev/null; then
    echo "skipped: this system gives no mount namespace to users"
    exit 0
  fi
  ACUS_FULL_DISK=1 exec unshare -rm bash "${BASH_SOURCE[0]}"
fi
runs=()
# shellcheck source=/dev/null
source "$here/small_runs.sh"
mkdir disk
root=$PWD
# A disk of $1 bytes with the inputs as links; the working directory is on it then.
begin() {
  cd "$root" || exit 1
  umount disk 2>/dev/null
  mount -t tmpfs -o size="$1" tmpfs disk && cp -rs "$INPUTS/." disk && cd disk || exit 1
}
used() { df --output=used -B1 . | tail -1; }
failures=0
fail() { echo "FAILED: $1"; head -c 500 ../err; failures=$((failures + 1)); }
for run in "${runs[@]}"; do
  begin 1g
  before=$(used)
  # shellcheck disable=SC2086
  $run >../out 2>../err </dev/null || fail "$run"
  whole=$(used)
  find o | sort >../files
  for permille in 30 200 400 600 800 930 990 1000; do
    size=$((before + (whole - before) * permille / 1000 - (permille == 1000 ? 4096 : 0)))
    begin $size
    # shellcheck disable=SC2086
    timeout -k 1 120 $run >../out 2>../err </dev/null
    code=$?
    [[ -z $(find . -name '*.partial*') ]] || fail "left a .partial on $size of $whole bytes: $run"
    if [[ $code == 0 ]]; then
      find o | sort | diff ../files - >../diff || fail "$(cat ../diff) on $size of $whole bytes: $run"
    elif [[ ! $code =~ ^(3|4)$ ]] || ! grep -q "^${run%% *}: " ../err; then
      fail "exit code $code on $size of $whole bytes: $run"
    fi
  done
done
cd "$root" && umount disk
[[ $failures == 0 ]] && echo every program noticed
