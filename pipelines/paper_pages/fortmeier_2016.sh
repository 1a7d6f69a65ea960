# shellcheck shell=bash disable=SC2154 # Names of pipelines/papers.
# Fortmeier-2016: a bile duct of a breathing patient.
page "Fortmeier-2016: direct visuo-haptic 4D volume rendering using respiratory motion models"
say "patient, session and motion models"
patient liver_ptc patient
session=patient/sessions/liver_ptc
resolution=64
[[ -z $quick ]] || resolution=32
for model in surrogate full_cycle; do
  acus-breathing --single patient/ct.nrrd --labels patient/labels.seg.nrrd --model $model \
    --resolution $resolution -o motion_$model --overwrite --quiet >motion_$model.txt
done
common=(--ct patient/ct.nrrd --set /effects/probe_force/press_mm=8)
breathes=(--set "/effects/breathing/motion=$PWD/motion_surrogate")
say "forces with and without breathing, 15, 25 and 50 nodes"
for nodes in 15 25 50; do
  replay run_$nodes patient $session "${common[@]}" "${breathes[@]}" "${no_images[@]}" --set /effects/needle/nodes=$nodes
done
replay run_still patient $session "${common[@]}" --set /effects/breathing=null "${no_images[@]}"
for name in 25 still; do column run_$name/forces.csv force_axial_n >axial_$name.csv; done
plot figure_5_lower.svg "Force on the needle in the liver, after figure 5, lower" "time [s]" "axial force [N]" \
  breathing=axial_25.csv at_rest=axial_still.csv

say "bovine liver ex vivo"
mkdir -p block/session
# A box of liver, CT mm: 60 x 60 x 60, its face at z = 0.
awk 'BEGIN {
  for (k = 0; k < 8; ++k) printf "v %d %d %d\n", k % 2 ? 30 : -30, int(k / 2) % 2 ? 30 : -30, (k > 3) ? 60 : 0
  n = split("1 3 4 2;5 6 8 7;1 2 6 5;3 7 8 4;1 5 7 3;2 4 8 6", face, ";")
  for (i = 1; i <= n; ++i) { split(face[i], v, " "); printf "f %d %d %d\nf %d %d %d\n", v[1], v[2], v[3], v[1], v[3], v[4] }
}' >block/liver.obj
echo '{"format": "acus-surface-scene/1", "spacing_mm": 1, "surfaces": [{"file": "liver.obj", "tissue": "liver"}]}' >block/block.json
echo '{"format": "acus-session/1", "name": "block", "reference_frame": "Reference", "streams": [{"file": "needle.csv", "tool": "needle"}]}' >block/session/session.json
# 5 mm/s from 5 mm before the face to 40 mm behind it, a pause of 2 s, and out.
awk 'BEGIN { print "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,status"
  for (t = 0; t <= 20000; ++t) { s = t / 1000; z = s < 9 ? -5 + 5 * s : s < 11 ? 40 : 40 - 5 * (s - 11)
    printf "%.3f,0,0,%.6f,1,0,0,0,OK\n", s, z } }' >block/session/needle.csv
cat >block/scenario.json <<JSON
{"format": "acus-scenario/1", "name": "Bovine liver, Fortmeier-2016 figure 5", "patient": {"surfaces": "block.json"},
 "needle": "needles/measured_16g.json",
 "effects": {"needle_force": {"model": "tissue"},
             "tissue": {"model": "springs", "table": "forces/fortmeier_bovine.json", "elasticity": "elasticity/fortmeier.json"}}}
JSON
acus-replay block/scenario.json block/session -o run_block --overwrite --quiet --explain >run_block.txt
awk -F, 'NR > 1 { print $2 "," $4 }' run_block/forces.csv >block.csv
plot figure_5_upper.svg "Into bovine liver, a pause at 40 mm, and out, after figure 5, upper" "depth [mm]" "axial force [N]" Acus=block.csv

say "volume rendering"
seconds=2
[[ -z $quick ]] || seconds=1
shortened $session short $seconds
view=(--set /effects/view_3d/width_px=1224 --set /effects/view_3d/height_px=1014 --set /effects/view_3d/supersampling=1
  --set '/effects/view_3d/layers=[{"preset":"skin"}]' --set '/effects/view_3d/surfaces=[]' --set /effects/view_3d/rate_hz=1
  --set /effects/ultrasound=null --set /effects/ct_slice=null --set /effects/fluoroscopy=null)
replay view_none patient short "${common[@]}" --set /effects/breathing=null "${view[@]}"
for model in surrogate full_cycle; do
  replay view_$model patient short "${common[@]}" "${view[@]}" --set "/effects/breathing/motion=$PWD/motion_$model"
done
say "all images, breathing"
images_s=8
[[ -z $quick ]] || images_s=1
shortened $session images $images_s
replay run_images patient images "${common[@]}" "${breathes[@]}"

heading "Tables"
table_begins
row "figure 5, upper: force at the puncture" "2.5 N" \
  "$(awk -F, '$2 == "puncture" && !n { printf "%.2f N at %.1f mm", $6, $4; n = 1 }' run_block/events.csv)" "a block of liver, the paper's constants" "17.8 mm follow from a1, a2 and 2.5 N"
row "figure 5, upper: at 40 mm" "1 N and friction" "$(awk -F, '$1 > deep { deep = $1; force = $2 } END { printf "%.2f N", force }' block.csv)" "the same" "friction of 40 mm at 0.0125 N/mm adds 0.5 N"
row "figure 5, lower: largest force" "a figure" "$(metric run_25 "largest axial force"), at rest $(metric run_still "largest axial force")" "liver_ptc, the paper's constants" "another path: between ribs, not along the body. The scripted first attempt runs into a rib, which breathing moves against the tip"
for nodes in 15 25 50; do
  row "figure 13: $nodes nodes, a haptic step" "box plots; about 2000 Hz on average" "$(step_us run_$nodes) us" \
    "all stages of a step, breathing, CPU time, mean of the session" "at rest after one step, where the paper's bodies take 15.1"
done
ms() { awk -v us="$(time_of "$1" "view in 3D")" 'BEGIN { printf "%.0f ms", us / 1000 }'; }
row "table 2: no motion" "16 ms" "$(ms view_none)" "1224 x 1014, skin, CT of 361 x 261 x 111" "a graphics card with CUDA against cores of a CPU: slower. CPU time of all threads together"
row "table 2: key frames" "36 ms" "$(ms view_full_cycle)" "the same, full cycle, fields of $resolution^3, three components" "as above"
row "table 2: surrogate" "27 ms" "$(ms view_surrogate)" "the same, surrogate, fields of $resolution^3, three components" "as above"
table_ends
heading "Motion models"
note "Errors in a synthetic breath that is known exactly, mm."
{ echo "<pre>"; cat motion_surrogate.txt; echo "</pre>"; } >>page.html
heading "Figures"
figure figure_5_upper.svg "Bovine liver ex vivo (figure 5, upper)."
figure figure_5_lower.svg "In the patient, breathing and at rest (figure 5, lower)."
figure run_images/view_3d.png "The patient with ducts, vessels and lesion (figure 6)."
figure view_surrogate/view_3d.png "Volume rendering of the breathing patient (figures 9, 11)."
heading "Effect plan"
plan run_images
