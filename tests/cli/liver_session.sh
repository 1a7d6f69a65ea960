#!/usr/bin/env bash
# A needle that is inserted into a liver meets the same with the labels of acus-segment as with those of a reference:
# the same punctures in the same order, the force of each and the largest force within 10 %.
# Usage: liver_session.sh FOLDER phantom SEED   (a synthetic patient; that of the next seed is the atlas)
#        liver_session.sh FOLDER ircadb01       (real CTs; skipped without them)
set -euo pipefail
folder=$1 kind=$2
export PATH="$ACUS_BIN:$PATH"
data=${ACUS_TEST_DATA:-$ACUS_SOURCE/../shared/data}/ct
if [[ $kind == ircadb01 && ! -d $data/ircadb01_dicom ]]; then
  echo "skipped: test data ct/ircadb01 is not here"
  exit 0
fi
rm -rf "$folder"
mkdir -p "$folder/atlas"
cd "$folder"
atlas() { # CT LABELS MAPPING
  printf '{"format": "acus-atlas/1", "patients": [{"name": "other", "ct": "%s", "labels": "%s", "mapping": "%s"}]}\n' \
    "$1" "$2" "$3" >atlas/atlas.json
}
if [[ $kind == phantom ]]; then
  acus-phantom patient liver --seed "$3" -o patient >/dev/null 2>&1
  acus-phantom patient liver --seed $(($3 + 1)) -o other >/dev/null 2>&1
  ct=patient/ct.nrrd
  atlas "$PWD/other/ct.nrrd" "$PWD/other/labels.seg.nrrd" label_maps/acus.json
  mkdir reference
  cp patient/labels.seg.nrrd reference
else
  ct=$data/ircadb01_dicom
  atlas "$data/totalseg/example_ct.nii.gz" "$data/totalseg/example_seg_fast_force_split.nii.gz" \
    label_maps/totalsegmentator.json
  acus-segment "$ct" --import "$data/ircadb01_labels.vti" --mapping "$ACUS_CONFIGS/label_maps/ircadb.json" \
    -o reference >/dev/null 2>&1
fi
acus-segment "$ct" --atlas atlas -o found >/dev/null 2>&1
cat >forces_only.json <<JSON
{"format": "acus-scenario/1", "patient": {}, "needle": "needles/spinal_22g.json",
 "effects": {"needle_force": {"model": "layered", "table": "forces/bovine_2021.json"}}}
JSON
# On ircadb01 the path that is planned between the ribs leaves the atlas's liver once, through 2.4 mm of soft tissue.
window=intercostal
[[ $kind == phantom ]] || window=subcostal
acus-phantom scene reference/labels.seg.nrrd --target liver --window "$window" -o scene >scene.txt 2>/dev/null
grep -h "^Passes through" scene.txt
acus-register --from scene/markers_mannequin.csv --to scene/markers_ct.csv \
  --target scene/target_ct.csv -o registration >/dev/null 2>&1
for labels in reference found; do
  acus-replay forces_only.json scene/sessions/* --ct "$ct" --labels "$labels/labels.seg.nrrd" \
    --transform registration/ct_from_reference.tfm -o "run_$labels" >/dev/null
  awk -F, '$2 == "puncture" { print $3 }' "run_$labels/events.csv" >"events_$labels.txt"
  awk -F, '$2 == "puncture" { print $6 }' "run_$labels/events.csv" >"puncture_$labels.txt"
  awk -F, 'NR > 1 && $4 > most { most = $4 } END { print most }' "run_$labels/forces.csv" \
    >"force_$labels.txt"
done
echo "punctures: $(tr '\n' ' ' <events_found.txt)"
for tissue in muscle liver; do
  grep -q "^$tissue" events_reference.txt || { echo "FAILED: no puncture of $tissue"; exit 1; }
done
diff events_reference.txt events_found.txt || { echo "FAILED: other punctures"; exit 1; }
paste events_reference.txt puncture_reference.txt puncture_found.txt | awk '{
  print "puncture, then " $1 ": " $2 " N with the reference, " $3 " N with those found"
  if (!($3 > 0.9 * $2 && $3 < 1.1 * $2)) failed = 1 } END { exit failed }' ||
  { echo "FAILED: another force of a puncture"; exit 1; }
paste force_reference.txt force_found.txt | awk '{
  print "largest axial force: " $1 " N with the reference, " $2 " N with those found"
  exit !($1 > 1 && $2 > 0.9 * $1 && $2 < 1.1 * $1) }' || { echo "FAILED: another force"; exit 1; }
