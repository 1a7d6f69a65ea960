#!/usr/bin/env bash
# Workplaces of procedures with a syringe or a stylet, each with a patient of its own: made, and their demonstrations
# played from start to report. Usage: play_procedures.sh SOURCE_FOLDER FOLDER PROCEDURE...
set -euo pipefail
root=$1 folder=$2
shift 2
export PATH="$ACUS_BIN:$PATH"
fail() { echo "FAILED: $1"; exit 1; }
# shellcheck source=/dev/null
source "$root/tests/cli/play.sh"

rm -rf "$folder"
mkdir -p "$folder"
cd "$folder"
for procedure in "$@"; do
  "$root/pipelines/live-session" --text --new "$procedure" --procedure "$procedure" >"$procedure.txt" 2>&1 </dev/null ||
    { cat "$procedure.txt"; fail "no workplace for $procedure"; }
  play_demonstration "$procedure" "play_$procedure"
  echo "$procedure: done"
done
