#!/usr/bin/env bash
# The insertion of the lumbar demo with the labels of acus-segment and with the exact ones: the same
# punctures in the same order, as many bone contacts, the largest force within 10 %.
# Usage: spine_session.sh FOLDER SEED
set -euo pipefail
folder=$1 seed=$2
export PATH="$ACUS_BIN:$PATH"
rm -rf "$folder"
mkdir -p "$folder"
cd "$folder"
acus-phantom patient lumbar --seed "$seed" -o patient >/dev/null 2>&1
acus-segment patient/ct.nrrd -o found >segment.txt 2>/dev/null
grep -q "^Spine found" segment.txt || { echo "FAILED: acus-segment reports no spine"; exit 1; }
acus-register --from patient/markers_mannequin.csv --to patient/markers_ct.csv \
  --target patient/target_ct.csv -o registration >/dev/null 2>&1
cat >forces_only.json <<JSON
{"format": "acus-scenario/1", "patient": {}, "needle": "needles/spinal_22g.json",
 "effects": {"needle_force": {"model": "layered", "table": "forces/default.json"}}}
JSON
for labels in patient found; do
  acus-replay forces_only.json patient/sessions/* --ct patient/ct.nrrd \
    --labels "$labels/labels.seg.nrrd" --transform registration/ct_from_reference.tfm \
    -o "run_$labels" >/dev/null
  awk -F, '$2 == "puncture" { print $3 } $2 == "bone_contact" { print "bone" }' \
    "run_$labels/events.csv" >"events_$labels.txt"
  awk -F, 'NR > 1 && $4 > most { most = $4 } END { print most }' "run_$labels/forces.csv" \
    >"force_$labels.txt"
done
grep -q '^spinal_canal' events_patient.txt || { echo "FAILED: no loss of resistance at all"; exit 1; }
diff events_patient.txt events_found.txt || { echo "FAILED: other punctures or contacts"; exit 1; }
paste force_patient.txt force_found.txt | awk '{
  print "largest axial force: " $1 " N with exact labels, " $2 " N with those found"
  exit !($1 > 1 && $2 > 0.9 * $1 && $2 < 1.1 * $1) }' || { echo "FAILED: another force"; exit 1; }
