#!/usr/bin/env bash
# The launcher of sessions as a clinician uses it, without windows: make a workplace, check, train,
# look at the report; and what it says when something is missing.
# Usage: run_launcher.sh SOURCE_FOLDER FOLDER
set -euo pipefail
source=$1 folder=$2
export PATH="$ACUS_BIN:$PATH"
launcher=$source/pipelines/live-session
fail() { echo "FAILED: $1"; exit 1; }

# expect CODE REGEX command...: runs it; its code and what it says.
expect() {
  local code=$1 regex=$2 got=0 said
  shift 2
  said=$("$@" 2>&1 </dev/null) || got=$?
  echo "$said"
  [[ $got == "$code" ]] || fail "$* ended with $got, not $code"
  grep -Eq -- "$regex" <<<"$said" || fail "$* did not say: $regex"
}

rm -rf "$folder"
mkdir -p "$folder"
cd "$folder"
expect 2 "Make one to try with" "$launcher" --text --headless work
expect 0 "Start it with" "$launcher" --new work
expect 2 "is there and not empty" "$launcher" --text --new work
expect 0 "All is ready" "$launcher" --text --headless --check work
expect 2 "unknown option --hedless" "$launcher" --hedless work
expect 2 "may only hold letters" "$launcher" --text --headless --trainee "A 7" \
  --exercise lumbar_puncture work
expect 2 "There is no exercise 'lumbar'" "$launcher" --text --headless --trainee A7 \
  --exercise lumbar work
expect 0 "Goals met: [0-9] of 7" "$launcher" --text --headless --demo --trainee A7 \
  --exercise lumbar_puncture --duration 3 work
session=$(echo work/sessions/A7/2*_lumbar_puncture)
for file in session.json needle.csv forces.csv summary.json report/report.html \
  report/training.json; do
  [[ -s $session/$file ]] || fail "there is no $session/$file"
done
cmp "$session/forces.csv" "$session/report/forces.csv" || fail "the replay felt something else"
[[ -s work/sessions/A7/progress_lumbar_puncture/progress.html ]] || fail "there is no progress"

mv work/devices.json gone
expect 3 "devices.json is missing" "$launcher" --text --headless work
mv gone work/devices.json
sed -i 's/virtual_hand/force_dimension/' work/devices.json
expect 3 "libdhd" "$launcher" --text --headless work
