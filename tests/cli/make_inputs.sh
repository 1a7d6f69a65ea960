#!/usr/bin/env bash
# Makes the small inputs of the CLI tests: a coarse patient, and the names that the EXAMPLEs use.
# Usage: make_inputs.sh SOURCE_FOLDER
set -euo pipefail
source=$1
export PATH="$ACUS_BIN:$PATH"

rm -rf "$INPUTS"
mkdir -p "$(dirname "$INPUTS")"
acus-phantom patient lumbar --config "$source/testdata/small_lumbar.json" --seed 1 -o "$INPUTS"
cd "$INPUTS"

# A patient with lungs, and the same breathing, as a 4D CT of four phases.
acus-phantom patient liver --config "$source/testdata/small_liver.json" --seed 1 -o liver_patient
acus-phantom warp liver_patient/ct.nrrd --labels liver_patient/labels.seg.nrrd --phases 4 \
  --noise-hu 5 -o breathing_patient

ln -s sessions/insertion session
ln -s markers_mannequin.csv mannequin.csv
ln -s markers_ct.csv ct.csv
ln -s target_ct.csv target.csv
cp "$source/testdata/small_scenario.json" scenario.json
cp "$source/testdata/small_lumbar.json" phantom.json
acus-register --from mannequin.csv --to ct.csv -o landmark_fit >/dev/null
ln -s landmark_fit/ct_from_reference.tfm ct_from_reference.tfm
cp "$source/configs/segmentation/default.json" segmentation.json

# Two runs of the same, for acus-compare.
acus-replay scenario.json session --ct ct.nrrd --labels labels.seg.nrrd \
  --transform ct_from_reference.tfm --no-film --png none -o reference_run >/dev/null
cp -r reference_run new_run

# Two sessions of an exercise, for acus-training.
acus-replay scenario.json session --ct ct.nrrd --labels labels.seg.nrrd \
  --transform ct_from_reference.tfm --set /patient/corridor=target_ct.csv \
  --set /effects/ultrasound=null --set /effects/ct_slice=null \
  --exercise exercises/lumbar_puncture.json --trainee A7 -o first_run >/dev/null
cp -r first_run second_run

# A study of two and two virtual trainees, for acus-study.
cat >study.json <<'JSON'
{"format": "acus-study/1", "name": "Small study", "groups": ["novice", "expert"], "trials": 2, "participants": [
  {"code": "N1", "group": "novice", "consent": true}, {"code": "N2", "group": "novice", "consent": true},
  {"code": "E1", "group": "expert", "consent": true}, {"code": "E2", "group": "expert", "consent": true}],
 "exercises": ["exercises/lumbar_puncture.json"], "questionnaires": ["questionnaires/face_validity.json"]}
JSON
acus-training simulate scenario.json --ct ct.nrrd --labels labels.seg.nrrd \
  --transform ct_from_reference.tfm --set /patient/corridor=corridor_ct.csv \
  --exercise exercises/lumbar_puncture.json --trainee trainees/novice.json,trainees/expert.json \
  --codes N1,N2,E1,E2 --trials 2 --rate-hz 200 --no-sessions -o trainees >/dev/null

# A data set of one patient, for acus-dataset.
cat >dataset.json <<'JSON'
{"format": "acus-dataset/1", "name": "Small data set", "scenarios": ["scenario.json"],
 "patients": [{"id": "lumbar_1", "folder": "."}], "exercise": "exercises/lumbar_puncture.json",
 "ranges": {"gain_offset_db": [-3, 3]}, "image_width_px": 64, "image_height_px": 64,
 "sequences": 2, "frames_per_sequence": 3, "step_rate_hz": 200,
 "splits": {"train": 1, "validation": 0, "test": 0}}
JSON

# A suite of one session, for acus-regression.
mkdir suite
cat >suite/suite.json <<'JSON'
{"format": "acus-regression/1", "cases": [{"name": "insertion", "scenario": "../scenario.json",
 "session": "../sessions/insertion", "set": ["/effects/ultrasound=null", "/image_rate_hz=1"],
 "patient": {"ct": "../ct.nrrd", "labels": "../labels.seg.nrrd",
             "ct_from_reference_file": "../ct_from_reference.tfm"}}]}
JSON

# A pointer 180 mm long that is turned about (10, 20, 30): 25 poses, one 4 x 4 matrix a file.
mkdir poses
awk 'BEGIN {
  for (i = 0; i < 25; ++i) {
    a = 0.25 * i; b = 0.2 + 0.02 * i
    ca = cos(a); sa = sin(a); cb = cos(b); sb = sin(b)
    split(ca " " (-sa * cb) " " (sa * sb) " " sa " " (ca * cb) " " (-ca * sb) " 0 " sb " " cb, r, " ")
    split("-5 2 180", tip, " "); split("10 20 30", pivot, " ")
    file = sprintf("poses/pose_%02d.txt", i)
    for (row = 0; row < 3; ++row) {
      t = pivot[row + 1]
      for (column = 1; column <= 3; ++column) t -= r[3 * row + column] * tip[column]
      print r[3 * row + 1], r[3 * row + 2], r[3 * row + 3], t > file
    }
    print 0, 0, 0, 1 > file
    close(file)
  }
}'

# A closed block of 40 x 30 x 20 mm as text STL.
awk 'BEGIN {
  n = split("0 0 0|40 0 0|40 30 0|0 30 0|0 0 20|40 0 20|40 30 20|0 30 20", corner, "|")
  m = split("1 3 2|1 4 3|5 6 7|5 7 8|1 2 6|1 6 5|2 3 7|2 7 6|3 4 8|3 8 7|4 1 5|4 5 8", face, "|")
  print "solid block"
  for (i = 1; i <= m; ++i) {
    split(face[i], v, " ")
    print "facet normal 0 0 0\n outer loop"
    for (j = 1; j <= 3; ++j) print "  vertex " corner[v[j]]
    print " endloop\nendfacet"
  }
  print "endsolid block"
}' >block.stl

cp "$source/testdata/coarse_mesh.json" "$source/testdata/box.vtu" .

# The same pointer, not turned, rests for 2 s at each marker of the mannequin; and one that lies still.
awk -F, 'BEGIN { print "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,status"; t = 0 }
  function pose(x, y, z) {
    printf "%.2f,%.4f,%.4f,%.4f,1,0,0,0,OK\n", t, x + 0.03 * sin(7 * t) + 5, y + 0.02 * cos(11 * t) - 2, z - 180
    t += 0.05
  }
  NR > 1 { for (i = 0; i < 10; ++i) pose(0.1 * i * $2, 0.1 * i * $3, 0.1 * i * $4 + 60)
           for (i = 0; i < 40; ++i) pose($2, $3, $4) }' markers_mannequin.csv > touches.csv
awk 'BEGIN { print "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,status"
  for (i = 0; i < 200; ++i) printf "%.2f,%.4f,%.4f,%.4f,1,0,0,0,OK\n", 0.05 * i,
    100 + 0.1 * sin(17 * i), 0.1 * sin(29 * i), 900 + 0.1 * sin(41 * i) }' > still.csv
