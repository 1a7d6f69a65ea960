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
grep -q '"state": "done"' "$session/report/training.json" || fail "no step was ticked off"
grep -q 'trial 1' <(sed -n 's/.*--trial \([0-9]*\).*/trial \1/p' "$session/provenance.json") ||
  fail "the first session is not trial 1"

# The demonstration does its exercise, and so does somebody who does what the window says.
root=$source
# shellcheck source=/dev/null
source "$root/tests/cli/play.sh"
play_demonstration work play
play_first_session work first

# The workplaces of the papers start. One patient serves all: making each its own takes a minute.
expect 2 "must be one of augmented_2010, .*; got 'x'" "$launcher" --text --new no --paper x
PYTHONPATH=$source/pipelines/launcher python3 -B - <<'PYTHON' || fail "a paper's workplace does not start"
import pathlib
import new_workplace
from files import UserError, read_json_object, write_whole
new_workplace.SYSTEMS["fortmeier_2016"]["without"].append("breathing")  # No lungs: nothing moves.
for paper in new_workplace.SYSTEMS:
    folder = pathlib.Path(f"paper_{paper}").resolve()
    (folder / "exercises").mkdir(parents=True)
    for name in ("patient", "registration"):
        (folder / name).symlink_to(pathlib.Path("work", name).resolve())
    new_workplace.write_system(folder, paper)
    name = new_workplace.SYSTEMS[paper].get("scenario", paper)
    preset = read_json_object(new_workplace.CONFIGS / f"scenarios/{name}.json")
    made = read_json_object(folder / "scenario.json")
    assert made["effects"]["ultrasound"] == preset["effects"]["ultrasound"], paper
# What would not start is said. The last one is overwritten.
write_whole(folder / "scenario.json", "{}")
try:
    new_workplace.check(folder, folder / "devices.json")
except UserError as error:
    assert "/format: must be" in str(error), error
else:
    raise AssertionError("an empty scenario starts")
PYTHON

# An epidural puncture by loss of resistance, and a spinal one.
play_demonstration paper_epidural play_epidural
play_demonstration paper_spinal play_spinal
expect 2 "must be one of epidural, .*; got 'x'" "$launcher" --text --new no --procedure x
expect 2 "goes with --new, without --paper" "$launcher" --text --procedure spinal work
[[ ! -e no ]] || fail "half a workplace was left behind"

# Two starts in one second: each has its folder.
mkdir bin
printf '#!/bin/sh\necho 2026-01-01_00-00-00\n' >bin/date
chmod +x bin/date
for n in 1 2; do
  PATH="$PWD/bin:$PATH" "$launcher" --text --headless --demo --trainee B8 \
    --exercise lumbar_puncture --duration 1 work >"start_$n.txt" 2>&1 </dev/null &
done
wait
both=(work/sessions/B8/2026*_lumbar_puncture/report/training.json)
[[ ${#both[@]} == 2 && -s ${both[0]} && -s ${both[1]} ]] || {
  cat start_1.txt start_2.txt
  fail "two starts in one second did not give two sessions"
}

# Workplaces of a patient of one's own: prepared, and of a CT with a target.
expect 0 "images a second of 30, [0-9]+ of [0-9]+ steps late" "$launcher" --text --new own \
  --patient work/patient --devices virtual --exercise lumbar_puncture --model liver_biopsy
[[ $(grep -c '"corridor": "target_ct.csv"\|"ct_from_reference_file": "registration/' own/scenario.json) == 2 ]] ||
  fail "the workplace has not the patient's corridor and registration"
target=$(awk -F, '$1 == "target" { print $2 "," $3 "," $4 }' work/patient/corridor_ct.csv)
expect 0 "images a second" "$launcher" --text --new of_ct --ct work/patient/ct.nrrd \
  --labels work/patient/labels.seg.nrrd --target "$target" --from posterior --devices virtual \
  --exercise lumbar_puncture --model liver_biopsy
grep -q "^target,$target$" of_ct/target_ct.csv || fail "the target is another one"
expect 0 "Goals met: [0-9] of 7" "$launcher" --text --headless --trainee A7 \
  --exercise lumbar_puncture --duration 4 of_ct
# State stands before text.
[[ $(grep -B 1 '"Place the probe on\|"See the target in\|"Bring the needle into' \
  of_ct/sessions/A7/*/report/training.json | grep -c '"state": "done"') == 3 ]] ||
  fail "the hands do not begin at the target"
expect 2 "must be three numbers L,P,S" "$launcher" --text --new no --patient work/patient --target 1,2
expect 2 "must be one of: .*virtual" "$launcher" --text --new no --patient work/patient --devices x
expect 2 "go with --new" "$launcher" --text --patient work/patient work
expect 3 "/effects/breathing/motion" "$launcher" --text --new no --patient work/patient \
  --devices virtual --exercise lumbar_puncture --model fortmeier_2016
[[ ! -e no ]] || fail "half a workplace was left behind"

# Another patient in a workplace, whose hands, and so the needle, are where they were.
expect 0 "Added exercises/second.json" "$launcher" --text --add-case second --patient work/patient \
  --exercise lumbar_puncture own
expect 0 "Goals met: [0-9] of 7" "$launcher" --text --headless --trainee A7 --exercise second --duration 4 own
grep -q "case_second.json" own/sessions/A7/*_second/report/provenance.json ||
  fail "the report is of the workplace's patient"
expect 0 "Goals met: [0-9] of 7" "$launcher" --text --headless --trainee A7 --exercise lumbar_puncture --duration 4 own
states() { grep -A 1 '"state"' own/sessions/A7/*_"$1"/report/training.json; }
[[ $(states second) == "$(states lumbar_puncture)" && $(states second) == *done* ]] ||
  fail "the hands begin elsewhere in the other patient"
expect 3 "is there already; choose another name" "$launcher" --add-case second --patient work/patient \
  --exercise lumbar_puncture own
expect 3 "corridor_ct.csv: no such file" "$launcher" --add-case third --patient own \
  --exercise lumbar_puncture own
expect 2 "needs --patient and --exercise" "$launcher" --add-case third own
[[ ! -e own/exercises/third.json ]] || fail "half a case was left behind"

mv work/devices.json gone
expect 3 "devices.json is missing" "$launcher" --text --headless work
mv gone work/devices.json
sed -i 's/virtual_hand/force_dimension/' work/devices.json
expect 3 "libdhd" "$launcher" --text --headless work
