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

say "figures 5, 6 and 8 to 12"
figure_5_upper
figure_5_lower
figure_6
figure_8
figure_9
figure_10
figure_11
figure_12 $resolution

say "volume rendering"
seconds=2 sizes=(64 128 256) voxels=256
[[ -z $quick ]] || seconds=1 sizes=(32) voxels=96
resized liver_ptc "$voxels $voxels $voxels" small.json
patient liver_ptc small --config small.json
shortened small/sessions/liver_ptc short $seconds
layer=skin width_px=1224 height_px=1014 view_step_mm=1
view=(--set "/effects/view_3d/width_px=$width_px" --set "/effects/view_3d/height_px=$height_px" --set "/effects/view_3d/step_mm=$view_step_mm"
  --set /effects/view_3d/supersampling=1 --set "/effects/view_3d/layers=[{\"preset\":\"$layer\"}]" --set '/effects/view_3d/surfaces=[]'
  --set /effects/view_3d/rate_hz=1 --set /effects/ultrasound=null --set /effects/ct_slice=null --set /effects/fluoroscopy=null)
as_printed=(--set /effects/view_3d/warp_tolerance_mm=0 --set /effects/view_3d/inverse_iterations=1)
at_most="6000 1200" # MB and seconds of a row.
# volume KEY PATIENT [acus-replay argument...]: time and memory of the view, or what it took too much of.
volume() {
  local key=$1 name=$2 code=0
  shift 2
  AT_MOST=$at_most replay "view_$key" "$name" short --ct "$name/ct.nrrd" "${view[@]}" "$@" || code=$?
  [[ $code != 75 ]] || fact "${key}_over" "$(cat "view_$key.mb")"
  [[ $code != 75 ]] || return 0
  [[ $code == 0 ]] || fail "$paper: no image of $key; see the message above" $code
  fact "${key}_ms" "$(stage_ms "view_$key" "view in 3D")"
  fact "${key}_mb" "$(cat "view_$key.mb")"
  fact "${key}_images" "$(runs_of "view_$key" "view in 3D")"
}
# table_2 PATIENT [SUFFIX]: all its motions.
table_2() {
  local size
  volume "none${2:-}" "$1" --set /effects/breathing=null
  for size in "${sizes[@]}"; do
    volume "surrogate_$size${2:-}" "$1" "${as_printed[@]}" --set "/effects/breathing/motion=$PWD/motion_surrogate_$size"
    volume "key_frame_$size${2:-}" "$1" "${as_printed[@]}" --set "/effects/breathing/motion=$PWD/motion_full_cycle_$size"
  done
}
for size in "${sizes[@]}"; do
  for model in surrogate full_cycle; do synthetic_motion $model "$size" "motion_${model}_$size"; done
done
table_2 small
if [[ -z $quick ]]; then
  volume surrogate_128_lattice small --set "/effects/breathing/motion=$PWD/motion_surrogate_128"
  volume key_frame_128_lattice small --set "/effects/breathing/motion=$PWD/motion_full_cycle_128"
fi
large_voxels=(512 512 456) # Of the paper 460: acus-phantom makes at most 120 million.
if [[ -z $quick ]]; then
  resized liver_ptc "${large_voxels[*]}" large.json
  patient liver_ptc large --config large.json
  table_2 large _large
fi
fact table_2_rows "$(grep '_mb,' facts.csv | grep -vc lattice)"
say "all images, breathing"
images_s=8
[[ -z $quick ]] || images_s=1
shortened $session images $images_s
replay run_images patient images "${common[@]}" "${breathes[@]}"

fact puncture_n "$(awk -F, '$2 == "puncture" && !n { print $6; n = 1 }' run_block/events.csv)"
fact puncture_mm "$(awk -F, '$2 == "puncture" && !n { print $4; n = 1 }' run_block/events.csv)"
fact depth_mm "$(awk -F, '$1 > m { m = $1 } END { printf "%.0f", m }' block.csv)"
for run in printed block; do fact ${run}_n "$(awk -F, '$1 > deep { deep = $1; force = $2 } END { print force }' $run.csv)"; done
spring_facts
fact line_breathing_n "$(number line_breathing "largest axial force")"
fact line_still_n "$(number line_still "largest axial force")"
fact session_breathing_n "$(number run_25 "largest axial force")"
fact session_still_n "$(number run_still "largest axial force")"
fact bone_contacts "$(number run_25 "bone contacts")"
fact world_off_mm "$(off_line path_world.csv)"
fact rest_off_mm "$(off_line path_rest.csv)"
fact deep_mm $deep_mm
for nodes in 15 25 50; do fact step_${nodes}_us "$(step_us run_$nodes)"; done
fact algorithm "algorithm 1"
fact voxels $((voxels ** 3))
fact large_voxels $((large_voxels[0] * large_voxels[1] * large_voxels[2]))
fact width_px $width_px
fact height_px $height_px
fact layer $layer
fact view_step_mm $view_step_mm
fact inversion "once at each sample, from the sample before"
fact key_frames "$(key_frames_of "motion_full_cycle_${sizes[0]}")"
load_facts
heading "Tables"
for part in needle inversion volume; do table $part; done
note load
heading "Motion models"
note errors
{ echo "<pre>"; cat motion_surrogate.txt; echo "</pre>"; } >>page.html
heading "Figures"
for name in figure_5_upper.svg figure_5_lower.svg figure_6.png figure_8.png figure_8_path.svg figure_9.png figure_10.png figure_11_slices.png figure_11_rays.png \
  figure_12_slices.png figure_12_ribs.png; do
  figure $name "${name%.*}"
done
figure "view_surrogate_${sizes[0]}/view_3d.png" volume
note missing
heading "Effect plan"
plan run_images
