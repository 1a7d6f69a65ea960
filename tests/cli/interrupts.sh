#!/usr/bin/env bash
# Ctrl-C and SIGTERM at random times (of a fixed seed) end programs within 2 s, and leave
# nothing half written. Before main() has begun, the signal itself ends the program.
set -uo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
runs=()
# shellcheck source=/dev/null
source "$here/small_runs.sh"
cp -rs "$INPUTS" work && cd work || exit 1
RANDOM=1
failures=0
for run in "${runs[@]}"; do
  for signal in INT TERM INT TERM; do
    delay=$(printf '0.%03d' $((RANDOM % 1000)))
    begin=$(date +%s%N)
    # shellcheck disable=SC2086
    timeout --preserve-status -s "$signal" -k 10 "$delay" $run >out 2>err </dev/null
    code=$?
    late_ms=$((($(date +%s%N) - begin) / 1000000 - 10#${delay#0.}))
    left=$(find . -name '*.partial*')
    rm -rf o
    if [[ ! $code =~ ^(0|4|130|143)$ || $late_ms -gt 2000 || -n $left ]]; then
      echo "FAILED: $signal after $delay s: exit code $code, $late_ms ms later, left '$left': $run"
      head -c 500 err
      failures=$((failures + 1))
    fi
  done
done
[[ $failures == 0 ]] && echo all ended in time
