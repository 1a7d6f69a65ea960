#!/usr/bin/env bash
# A sweep that is killed in the middle goes on when it is called again, and gives the errors of one
# that went through. Usage: kill_sweep.sh ARGUMENTS OF acus-tradeoff scene, without -o
set -euo pipefail
sweep=("$ACUS_BIN/acus-tradeoff" scene "$@")
"${sweep[@]}" -o whole >/dev/null 2>&1
"${sweep[@]}" -o killed >/dev/null 2>&1 &
for ((i = 0; i < 3000; ++i)); do
  [[ $(find killed/runs -name '*.json' 2>/dev/null | wc -l) -lt 2 ]] || break
  sleep 0.01
done
kill -9 $! 2>/dev/null || true
wait $! 2>/dev/null || true
"${sweep[@]}" -o killed >table 2>&1
grep -E 'Taken up: [2-8] of 8 runs were there' table || { cat table; exit 1; }
"$(dirname "${BASH_SOURCE[0]}")/same_errors.sh" whole/tradeoff.csv killed/tradeoff.csv
