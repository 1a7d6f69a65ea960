#!/usr/bin/env bash
# The launcher's window by mouse and keyboard: it starts a real session, whose report and progress are then there.
# Usage: play_launcher.sh SOURCE_FOLDER FOLDER PROGRAM
set -euo pipefail
source=$1 folder=$2 program=$3
export PATH="$ACUS_BIN:$PATH" LANG=C.UTF-8
fail() { echo "FAILED: $1" >&2; exit 1; }

rm -rf "$folder"
mkdir -p "$folder/places/small/exercises" "$folder/places/small/patient"
cd "$folder"
place=places/small
cp -rL "$INPUTS/landmark_fit" $place/registration
cp -L "$INPUTS"/{ct.nrrd,labels.seg.nrrd,corridor_ct.csv} $place/patient
grep -v '"patient"' "$INPUTS/scenario.json" | sed '0,/{/s##{ "patient": {"ct": "patient/ct.nrrd", \
"labels": "patient/labels.seg.nrrd", "corridor": "patient/corridor_ct.csv", \
"ct_from_reference_file": "registration/ct_from_reference.tfm"},#' >$place/scenario.json
cp "$source/configs/devices/virtual.json" $place/devices.json
cp "$source/configs/exercises/lumbar_puncture.json" $place/exercises/first.json

"$source/pipelines/common/on_display.sh" "$program" places "$source/pipelines/live-session" launcher.png
session=$(echo $place/sessions/T1/2*_first)
for file in session.json forces.csv report/report.html; do
  [[ -s $session/$file ]] || fail "there is no $session/$file"
done
cmp "$session/forces.csv" "$session/report/forces.csv" || fail "the replay has other forces"
[[ -s $place/sessions/T1/progress_first/progress.html ]] || fail "there is no progress"
[[ -s $place/image.png && -s launcher.png ]] || fail "there is no image"
