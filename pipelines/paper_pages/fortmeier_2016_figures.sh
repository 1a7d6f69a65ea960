# shellcheck shell=bash disable=SC2154 # Names of pipelines/papers and developer/figures.
# Figures 5, 6 and 8 to 12 of Fortmeier-2016 from replays of its preset, in CT space.
# Expects: $paper, common.sh, and the folder `patient` (liver_ptc).

deep_mm=30 # Travel of the diaphragm in figures 8 and 10.
# off_line FILE: how far a path is from the hand's line, z = 100 mm, at most.
off_line() { awk -F, '{ d = $2 - 100; if (d < 0) d = -d; if (d > m) m = d } END { printf "%.2f\n", m }' "$1"; }
# spring_facts: of a node of liver, along and across, from the tables that the preset names: the law of
# docs/models/tissue_functions_and_springs.md.
spring_facts() {
  /usr/bin/python3 -B - "$root/configs" >>facts.csv <<'PYTHON'
import json, math, pathlib, re, sys
configs = pathlib.Path(sys.argv[1])
def read(name):
    return json.loads(re.sub(r"^\s*//.*$", "", (configs / name).read_text(encoding="utf-8"), flags=re.M))
effects = read("scenarios/fortmeier_2016.json")
tissue, needle = effects["effects"]["tissue"], read(effects["needle"])
def row(table, *names):
    rows = {r["tissue"]: r for r in read(table)["tissues"]}
    return next(rows[n] for n in names if n in rows)
spacing, a, r = tissue["springs"]["path_spacing_mm"], needle["outer_diameter_mm"] / 2, 20.0
elastic = row(tissue["elasticity"], "liver")
shear = elastic["youngs_modulus_kpa"] / 1000 / (2 * (1 + elastic.get("poissons_ratio", 0.49)))
across = 4 * math.pi * shear / (math.log(r / a) - (r * r - a * a) / (r * r + a * a))
print(f"spacing_mm,{spacing}\nk_along_n_per_mm,{row(tissue['table'], 'liver', 'soft_tissue')['shaft_n_per_mm2'] * spacing}")
print(f"k_across_n_per_mm,{across * spacing:.4f}")
PYTHON
}
# key_frames_of MOTION: fields of a motion model.
key_frames_of() { /usr/bin/python3 -B -c 'import json, sys; print(len(json.load(open(sys.argv[1]))["frames"]))' "$1/motion.json"; }
# motions NODES: a breath as it is by default, and one of 30 mm, so that models and iterations differ as in the paper.
motions() {
  local model
  for model in surrogate full_cycle; do synthetic_motion "$model" "$1" "motion_$model"; done
  for model in half_cycle surrogate; do synthetic_motion "$model" "$1" "motion_deep_$model" --diaphragm-mm $deep_mm; done
}
synthetic_motion() {
  local model=$1 nodes=$2 folder=$3
  shift 3
  acus-breathing --single patient/ct.nrrd --labels patient/labels.seg.nrrd --model "$model" --resolution "$nodes" "$@" \
    -o "$folder" --overwrite --quiet >"$folder.txt"
}

# in_ct RUN SESSION [acus-replay argument...]: as `replay`, of a session in CT space.
in_ct() {
  local run=$1 session=$2
  shift 2
  acus-replay "scenarios/$paper.json" "$session" --ct patient/ct.nrrd --labels patient/labels.seg.nrrd --transform identity \
    --no-sequence --no-film --png all --quiet -o "$run" --overwrite \
    --set /effects/ultrasound=null --set /effects/ct_slice=null --set /effects/fluoroscopy=null \
    --set /effects/probe_force=null "$@" >"$run.txt"
}
only_images=(--set /effects/needle_force=null --set /effects/needle=null --set /effects/tissue=null --set /needle=null)
no_view=(--set /effects/view_3d=null)
sheet() { /usr/bin/python3 "$root/pipelines/paper_pages/sheet.py" "$@"; }

# Upper half of figure 5: a box of liver, CT mm: 60 x 60 x 60, its face at z = 0.
figure_5_upper() {
  mkdir -p block
  awk 'BEGIN {
    for (k = 0; k < 8; ++k) printf "v %d %d %d\n", k % 2 ? 30 : -30, int(k / 2) % 2 ? 30 : -30, (k > 3) ? 60 : 0
    n = split("1 3 4 2;5 6 8 7;1 2 6 5;3 7 8 4;1 5 7 3;2 4 8 6", face, ";")
    for (i = 1; i <= n; ++i) { split(face[i], v, " "); printf "f %d %d %d\nf %d %d %d\n", v[1], v[2], v[3], v[1], v[3], v[4] }
  }' >block/liver.obj
  echo '{"format": "acus-surface-scene/1", "spacing_mm": 1, "surfaces": [{"file": "liver.obj", "tissue": "liver"}]}' >block/block.json
  # 5 mm/s from 5 mm before the face to 40 mm behind it, a pause of 2 s, and out.
  awk 'BEGIN { for (t = 0; t <= 20000; ++t) { s = t / 1000; z = s < 9 ? -5 + 5 * s : s < 11 ? 40 : 40 - 5 * (s - 11)
      printf "%.3f,0,0,%.6f,1,0,0,0,OK\n", s, z } }' | session_of block/session needle
  cat >block/scenario.json <<JSON
{"format": "acus-scenario/1", "name": "Bovine liver, Fortmeier-2016 figure 5", "patient": {"surfaces": "block.json"},
 "needle": "needles/measured_16g.json",
 "effects": {"needle_force": {"model": "tissue"},
             "tissue": {"model": "springs", "table": "forces/fortmeier_bovine.json", "elasticity": "elasticity/fortmeier.json"}}}
JSON
  # Algorithm 1 as printed: a1 and a2 inside, too.
  sed '/"tissue": "liver"/s/"cutting_n"/"cutting_a1_n_per_mm": 0.048, "cutting_a2_n_per_mm2": 0.0052, "cutting_n"/' \
    "$root/configs/forces/fortmeier_bovine.json" >block/as_printed.json
  acus-replay block/scenario.json block/session --transform identity -o run_block --overwrite --quiet --explain >run_block.txt
  acus-replay block/scenario.json block/session --transform identity -o run_printed --overwrite --quiet \
    --set "/effects/tissue/table=$PWD/block/as_printed.json" --set /effects/tissue/springs/path_spacing_mm=2 >run_printed.txt
  local run
  for run in block printed; do awk -F, 'NR > 1 { print $2 "," $4 }' run_$run/forces.csv >$run.csv; done
  plot figure_5_upper.svg "Into bovine liver, a pause at 40 mm, and out, after figure 5, upper" "depth [mm]" "axial force [N]" \
    algorithm_1_as_printed=printed.csv springs=block.csv
}

# along_line FOLDER END_S DEPTH: a needle in the plane x = -70 mm, from the skin at y = -142, z = 100 mm; DEPTH: awk
# function depth(t), mm, and lean(t), degrees by which it is turned towards the head from straight to the back.
along_line() {
  awk -v end="$2" 'function clamp(x) { return x < 0 ? 0 : x > 1 ? 1 : x }
    '"$3"'
    BEGIN { for (n = 0; n <= 1000 * end; ++n) { t = n / 1000; d = depth(t); a = lean(t) * atan2(0, -1) / 180; h = (a - atan2(0, -1) / 2) / 2
      printf "%.3f,-70,%.6f,%.6f,%.9f,%.9f,0,0,OK\n", t, -142 + d * cos(a), 100 + d * sin(a), cos(h), sin(h) } }' | session_of "$1" needle
}

# Lower half of figure 5: to 60 mm in 10 s, a pause of 6 s, 25 mm more in 4 s, a pause of 6 s, and out in 6 s.
figure_5_lower() {
  along_line line 33 'function depth(t) { return -5 + 60 * clamp(t / 10) + 25 * clamp((t - 16) / 4) - 95 * clamp((t - 26) / 6) }
    function lean(t) { return 37 }'
  in_ct line_breathing line "${no_view[@]}" --set "/effects/breathing/motion=$PWD/motion_surrogate"
  in_ct line_still line "${no_view[@]}" --set /effects/breathing=null
  local run
  for run in breathing still; do column line_$run/forces.csv force_axial_n >line_$run.csv; done
  plot figure_5_lower.svg "In 10 s to 60 mm, a pause, 25 mm more, a pause, and out, after figure 5, lower" "time [s]" "axial force [N]" \
    with_respiratory_motion=line_breathing.csv without=line_still.csv
}

# Figure 6: a needle that is held in the liver of a patient who breathes: end expiration, mid inspiration, end inspiration,
# mid expiration. Volume of bone and surfaces, from the patient's right and above.
figure_6() {
  along_line held 5.01 'function depth(t) { return -5 + 65 * clamp(t / 1.5) } function lean(t) { return 37 }'
  in_ct run_held held --set "/effects/breathing/motion=$PWD/motion_deep_surrogate" --set /effects/breathing/pattern/exponent=1 \
    --set '/effects/view_3d={"layers":[{"preset":"bone"}],"surfaces":[{"tissue":"skin","opacity":0.15},{"tissue":"liver","opacity":0.3},{"tissue":"lesion"},{"tissue":"gallbladder"},{"tissue":"vessel"}],"probe":false,"rate_hz":1,"width_px":300,"height_px":300,"camera":{"eye_mm":[-560,-640,230],"focus_mm":[-60,-60,140],"view_angle_deg":18}}'
  local frame=run_held/frames/view_3d_0000
  sheet figure_6.png ${frame}2.png ${frame}3.png ${frame}4.png ${frame}5.png
}

# Figure 8: a thin needle in the plane of its line. Above, the hand leans after 10 mm; below, the patient breathes out
# while it is inserted straight. Then the path of the bent tip in the world, and in the patient at rest.
thin=(--set /needle=needles/spinal_22g.json --set /effects/needle/elasticity=elasticity/default.json
  --set /effects/tissue/elasticity=elasticity/default.json --set /effects/tissue/table=forces/default.json
  --set '/effects/planes={"planes":["sagittal"],"centre_mm":[-70,-108,110],"rate_hz":2,"width_px":200,"height_px":160,"mm_per_px":0.5,"window":{"centre_hu":50,"width_hu":500}}')
# tip_paths TRACE REST WORLD: y and z of the bent tip, from where it is at the skin on. `needle shape/tip_*` is in the
# patient at rest; the pose of the needle there and in the world takes it to the world.
tip_paths() {
  awk -F, -v rest="$2" -v world="$3" 'NR == 1 { for (i = 1; i <= NF; ++i) at[$i] = i; next }
    { for (r = 0; r < 3; ++r) off[r] = $at["needle shape/tip_" substr("xyz", r + 1, 1) "_mm"] - $at["breathing/ct_from_needle_" r 3]
      for (c = 0; c < 3; ++c) { own[c] = 0; for (r = 0; r < 3; ++r) own[c] += $at["breathing/ct_from_needle_" r c] * off[r] }
      for (r = 1; r < 3; ++r) { p[r] = $at["needle pose/ct_from_needle_" r 3]
        for (c = 0; c < 3; ++c) p[r] += $at["needle pose/ct_from_needle_" r c] * own[c] }
      if ($at["needle shape/tip_y_mm"] > -136) {
        print $at["needle shape/tip_y_mm"] "," $at["needle shape/tip_z_mm"] > rest; print p[1] "," p[2] > world } }' "$1"
}
straight_while_breathing() {
  along_line straight 1.01 'function depth(t) { return -20 + 75 * clamp(t) } function lean(t) { return 0 }'
  in_ct run_straight straight "${no_view[@]}" "${thin[@]}" --trace --set /effects/breathing/pattern/exponent=1 \
    --set "/effects/breathing/motion=$PWD/motion_deep_surrogate"
}
figure_8() {
  along_line lean 6.01 'function depth(t) { return -2 + 12 * clamp(t) + 45 * clamp((t - 3) / 3) }
    function lean(t) { return 15 * clamp((t - 1.5) / 1.5) }'
  in_ct run_lean lean "${no_view[@]}" "${thin[@]}" --set /effects/breathing=null
  straight_while_breathing
  local leans=run_lean/frames/planes_000 goes=run_straight/frames/planes_000
  sheet figure_8.png ${leans}02.png ${leans}06.png ${leans}12.png - ${goes}00.png ${goes}01.png ${goes}02.png
  figure_8_path
}
figure_8_path() {
  tip_paths run_straight/trace.csv path_rest.csv path_world.csv
  plot figure_8_path.svg "Path of the needle's tip while the patient breathes out, after figure 8, lower" \
    "from front to back [mm]" "towards the head [mm]" in_the_world=path_world.csv at_rest=path_rest.csv
}
# far_probe FOLDER SECONDS: a probe that is far away, for images alone.
far_probe() {
  awk -v end="$2" 'BEGIN { for (n = 0; n <= 100 * end; ++n) printf "%.2f,0,-400,200,1,0,0,0,OK\n", n / 100 }' | session_of "$1" probe
}
sagittal=(--set '/effects/planes={"planes":["sagittal"],"centre_mm":[-70,-30,150],"rate_hz":1,"width_px":208,"height_px":176,"mm_per_px":1.25,"needle":false,"window":{"centre_hu":50,"width_hu":500}}'
  --set /effects/breathing/pattern/exponent=1)

# Figure 10: end inspiration, mid expiration, end expiration, mid inspiration; 1.4 times as deep; and how mid
# inspiration differs from mid expiration. Above by half-cycle key frames, below by the surrogate model.
figure_10() {
  far_probe breath 3.1
  far_probe moment 0.03
  local model frames sheet=()
  for model in half_cycle surrogate; do
    in_ct "breath_$model" breath "${only_images[@]}" "${no_view[@]}" "${sagittal[@]}" --set "/effects/breathing/motion=$PWD/motion_deep_$model"
    in_ct "deeper_$model" moment "${only_images[@]}" "${no_view[@]}" "${sagittal[@]}" --set "/effects/breathing/motion=$PWD/motion_deep_$model" \
      --set /effects/breathing/pattern/level=1.4
    frames=breath_$model/frames/planes_0000
    [[ ${#sheet[@]} == 0 ]] || sheet+=(-)
    sheet+=("${frames}0.png" "${frames}1.png" "${frames}2.png" "${frames}3.png" "deeper_$model/frames/planes_00000.png" "${frames}3.png:${frames}1.png")
  done
  sheet figure_10.png "${sheet[@]}"
}

# Figure 11: end inspiration by the surrogate model, of a normal breath: one that folds the field of 30 mm at sliding
# organs would show the fold and not the inversion. Slices, lower half, not warped and with 1, 5 and 50 iterations at
# every pixel; rays, upper half, not warped, with 1 iteration from the sample before, 1 with twice the samples, and 50.
# Below each the difference from 50 iterations.
figure_11() {
  figure_11_slices
  figure_11_rays
}
# grey_difference KEY A B: a fact, the mean difference of two images in grey levels.
grey_difference() {
  fact "$1" "$(/usr/bin/python3 -B "$root/pipelines/paper_pages/sheet.py" --difference "$2" "$3")"
}
figure_11_slices() {
  local normal_breath=(--set "/effects/breathing/motion=$PWD/motion_surrogate" --set /effects/breathing/pattern/exponent=1)
  far_probe moment 0.03
  local n still=(--set /effects/breathing/amplitude=0)
  in_ct slice_0 moment "${only_images[@]}" "${no_view[@]}" "${sagittal[@]}" "${normal_breath[@]}" "${still[@]}"
  for n in 1 5 50; do
    in_ct slice_$n moment "${only_images[@]}" "${no_view[@]}" "${sagittal[@]}" "${normal_breath[@]}" \
      --set /effects/breathing/warp_spacing_mm=1.25 --set /effects/breathing/inverse_iterations=$n
  done
  local most=slice_50/frames/planes_00000.png one=() off=()
  for n in 0 1 5 50; do one+=("slice_$n/frames/planes_00000.png") off+=("slice_$n/frames/planes_00000.png:$most"); done
  sheet figure_11_slices.png "${one[@]}" - "${off[@]}"
  for n in 0 1 5; do grey_difference slice_${n}_grey slice_$n/frames/planes_00000.png $most; done
}
figure_11_rays() {
  local normal_breath=(--set "/effects/breathing/motion=$PWD/motion_surrogate" --set /effects/breathing/pattern/exponent=1)
  local view=(--set '/effects/view_3d={"layers":[{"preset":"bone"}],"surfaces":[],"needle":false,"probe":false,"rate_hz":1,"width_px":240,"height_px":240,"supersampling":1,"warp_tolerance_mm":0,"camera":{"eye_mm":[0,-1077,702],"focus_mm":[0,-32,140],"view_angle_deg":9.8}}')
  local steps=/effects/view_3d/step_mm iterations=/effects/view_3d/inverse_iterations still=(--set /effects/breathing/amplitude=0)
  far_probe moment 0.03
  in_ct rays_0 moment "${only_images[@]}" "${normal_breath[@]}" "${view[@]}" "${still[@]}"
  in_ct rays_1 moment "${only_images[@]}" "${normal_breath[@]}" "${view[@]}" --set $iterations=1
  in_ct rays_1_half moment "${only_images[@]}" "${normal_breath[@]}" "${view[@]}" --set $iterations=1 --set $steps=0.5
  in_ct rays_50 moment "${only_images[@]}" "${normal_breath[@]}" "${view[@]}" --set $iterations=50
  in_ct rays_50_half moment "${only_images[@]}" "${normal_breath[@]}" "${view[@]}" --set $iterations=50 --set $steps=0.5
  local image=frames/view_3d_00000.png
  sheet figure_11_rays.png rays_0/$image rays_1/$image rays_1_half/$image rays_50/$image - \
    rays_0/$image:rays_50/$image rays_1/$image:rays_50/$image rays_1_half/$image:rays_50_half/$image rays_50/$image:rays_50/$image
  grey_difference rays_0_grey rays_0/$image rays_50/$image
  grey_difference rays_1_grey rays_1/$image rays_50/$image
  grey_difference rays_1_half_grey rays_1_half/$image rays_50_half/$image
}

# Figure 9: a finger in a fixed place, 12 mm deep in the skin of the belly at end expiration, and the patient breathes:
# end inspiration, mid expiration, end expiration, mid inspiration.
figure_9() {
  awk 'BEGIN { for (n = 0; n <= 310; ++n) printf "%.2f,-70,-130,100,1,0,0,0,OK\n", n / 100 }' | session_of finger probe
  in_ct run_finger finger "${only_images[@]}" --set /effects/breathing/pattern/exponent=1 --set "/effects/breathing/motion=$PWD/motion_deep_surrogate" \
    --set '/effects/probe_force={"model":"multi_proxy","multi_proxy":{"tool":"fingertip","image":true}}' \
    --set '/effects/view_3d={"layers":[{"preset":"skin"}],"surfaces":[],"needle":false,"probe":false,"rate_hz":1,"width_px":240,"height_px":240,"camera":{"eye_mm":[-330,-400,300],"focus_mm":[-70,-135,100],"view_angle_deg":16}}'
  local frame=run_finger/frames/view_3d_0000
  sheet figure_9.png ${frame}0.png ${frame}1.png ${frame}2.png ${frame}3.png
}

# Figure 12: end inspiration of a normal breath by fields of N nodes along each axis and of twice as many; the
# difference. Left in the paper slices, right the surfaces of ribs.
figure_12() { # N
  local motion slices=() ribs=() fine=$((2 * $1))
  synthetic_motion surrogate "$fine" motion_fine
  for motion in motion_surrogate motion_fine; do
    in_ct "smear_$motion" moment "${only_images[@]}" "${no_view[@]}" "${sagittal[@]}" --set /effects/breathing/warp_spacing_mm=1.25 \
      --set "/effects/breathing/motion=$PWD/$motion"
    in_ct "ribs_$motion" moment "${only_images[@]}" --set /effects/breathing/pattern/exponent=1 --set "/effects/breathing/motion=$PWD/$motion" \
      --set '/effects/view_3d={"layers":[],"surfaces":[{"tissue":"bone"}],"needle":false,"probe":false,"rate_hz":1,"width_px":240,"height_px":240,"camera":{"eye_mm":[0,-1077,702],"focus_mm":[0,-32,140],"view_angle_deg":9.8}}'
    slices+=("smear_$motion/frames/planes_00000.png") ribs+=("ribs_$motion/frames/view_3d_00000.png")
  done
  sheet figure_12_slices.png "${slices[@]}" "${slices[0]}:${slices[1]}"
  sheet figure_12_ribs.png "${ribs[@]}" "${ribs[0]}:${ribs[1]}"
  fact field_nodes "$1"
  fact fine_field_nodes "$fine"
}
