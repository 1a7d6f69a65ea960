# shellcheck shell=bash disable=SC2154 # Names of pipelines/papers.
# Fortmeier-2016: a bile duct of a breathing patient.
page "Fortmeier-2016: direct visuo-haptic 4D volume rendering using respiratory motion models"
say "patient, session and motion models"
patient liver_ptc patient
session=patient/sessions/liver_ptc
resolution=64
[[ -z $quick ]] || resolution=32
# shellcheck source=/dev/null
source "$root/pipelines/paper_pages/fortmeier_2016_figures.sh"
motions $resolution
common=(--ct patient/ct.nrrd --set /effects/probe_force/press_mm=8)
breathes=(--set "/effects/breathing/motion=$PWD/motion_surrogate")
say "forces with and without breathing, 15, 25 and 50 nodes"
for nodes in 15 25 50; do
  replay run_$nodes patient $session "${common[@]}" "${breathes[@]}" "${no_images[@]}" --set /effects/needle/nodes=$nodes
done
replay run_still patient $session "${common[@]}" --set /effects/breathing=null "${no_images[@]}"

say "figures 5, 8, 10 and 11"
figure_5_upper
figure_5_lower
figure_8
figure_10
figure_11

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
row "figure 5, lower: largest force" "a figure" "$(metric line_breathing "largest axial force"), at rest $(metric line_still "largest axial force")" "liver_ptc, from the belly towards the head" "the paper gives the order of the pauses and the first 10 s only"
row "the same, in the session" "" "$(metric run_25 "largest axial force"), at rest $(metric run_still "largest axial force")" "liver_ptc, the paper's constants" "another path: between ribs, not along the body. The scripted first attempt runs into a rib, which breathing moves against the tip"
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
figure figure_5_lower.svg "Towards the head into the liver, breathing and at rest (figure 5, lower)."
figure figure_8.png "Figure 8. Above: 10 mm in, the hand leans, further in. Below: in straight while the patient breathes out."
figure figure_8_path.svg "Figure 8, lower: the path of the tip in the world, and of the hand's tip at rest."
figure figure_10.png "Figure 10: end inspiration, mid expiration, end expiration, mid inspiration, 1.4 times as deep; the difference of the two in the middle. Above half-cycle key frames, below the surrogate model."
figure figure_11_slices.png "Figure 11, lower: not warped; 1, 5, 50 iterations. Below: difference from 50."
figure figure_11_rays.png "Figure 11, upper: not warped; 1 iteration from the sample before; 1 with twice the samples; 50. Below: difference from 50."
figure run_images/view_3d.png "The patient with ducts, vessels and lesion (figure 6)."
figure view_surrogate/view_3d.png "Volume rendering of the breathing patient (figure 9)."
heading "Effect plan"
plan run_images
