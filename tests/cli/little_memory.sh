#!/usr/bin/env bash
# Programs under limits of their address space end by themselves: with their result, with a message,
# or because their libraries cannot be loaded.
set -uo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
runs=()
# shellcheck source=/dev/null
source "$here/small_runs.sh"
cp -rs "$INPUTS" work && cd work || exit 1
failures=0
for kib in 250000 350000 400000 450000 550000 800000; do
  for run in "${runs[@]}"; do
    # shellcheck disable=SC2086
    (ulimit -v $kib && exec timeout -k 1 60 $run) >out 2>err </dev/null
    code=$?
    rm -rf o
    program=${run%% *}
    case $code in
      0) continue ;;
      3 | 4) grep -q "^$program: " err && continue ;;
      # Before main() has begun; a program's own handler prints its name.
      134) grep -q '^terminate called' err && continue ;;
      127) grep -q 'error while loading shared libraries' err && continue ;;
    esac
    echo "FAILED: exit code $code with $kib KiB: $run"
    head -c 500 err
    failures=$((failures + 1))
  done
done
[[ $failures == 0 ]] && echo all ended
