# shellcheck shell=bash disable=SC2154 # Names of pipelines/papers.
# Alamilla-2021 in the synthetic shoulder: one straight insertion, one that changes direction, one through all tissues.
page "Alamilla-2021: a virtual reality and haptic simulator for ultrasound-guided needle insertion"
grid=2
[[ -z $quick ]] || grid=3
say "two patients: the same shoulder, a straight and a turned session"
coarse shoulder $grid turned.json
[[ -n $quick ]] || cp "$root/configs/phantoms/shoulder.json" turned.json
awk '/"aim": "bone"/ && /"to": "(bone|depth)"/ { next } { gsub(/"aim": "bone"/, "\"aim\": \"target\""); print }' \
  turned.json >straight.json
patient shoulder straight --config straight.json
patient shoulder turned --config turned.json
for name in straight turned; do
  say "$name insertion"
  view=()
  [[ $name == turned && -z $quick ]] || view=(--set /effects/view_3d=null)
  replay "run_$name" "$name" "$name/sessions/shoulder" "${view[@]}"
  column "run_$name/forces.csv" lateral_n >"clamping_$name.csv"
  column "run_$name/forces.csv" cutting_n >"cutting_$name.csv"
  for axis in x y z; do
    column "$name/sessions/shoulder/needle.csv" ${axis}_mm | awk -F, 'NR == 1 { from = $2 } { print $1 "," $2 - from }' >"way_${name}_$axis.csv"
  done
  plot "figure_18_$name.svg" "Displacement of the tip, $name, after figure 18" "time [s]" "displacement [mm]" \
    x="way_${name}_x.csv" y="way_${name}_y.csv" z="way_${name}_z.csv"
done
plot figure_19.svg "Clamping force, after figure 19" "time [s]" "force across the path [N]" \
  straight=clamping_straight.csv turned=clamping_turned.csv
plot figure_20.svg "Cutting and withdrawal force, after figure 20" "time [s]" "force [N]" \
  straight=cutting_straight.csv turned=cutting_turned.csv

say "trajectories with the clamping force"
# trajectory NAME: figures 16 and 17: path of the tip in the body, and from it the force across the needle, in the plane of the
# needle at the skin and of the place where the tip is farthest off its line.
arrow_mm_per_n=20
trajectory() {
  replay "trace_$1" "$1" "$1/sessions/shoulder" "${no_images[@]}" --set /effects/tissue=null --trace
  awk -F, -v scale=$arrow_mm_per_n -v arrows="arrows_$1.csv" 'function dot(a, i, b, k) { return a[i, 0] * b[k, 0] + a[i, 1] * b[k, 1] + a[i, 2] * b[k, 2] }
    NR == 1 { for (i = 1; i <= NF; ++i) at[$i] = i; next }
    $at["needle force/depth_mm"] > 0 { ++n
      for (r = 0; r < 3; ++r) {
        p[n, r] = $at["needle pose/ct_from_needle_" r 3] - (n > 1 ? start[r] : 0); axis[n, r] = $at["needle pose/ct_from_needle_" r 2]
        f[n, r] = $at["needle force/force_" substr("xyz", r + 1, 1) "_n"] }
      if (n == 1) for (r = 0; r < 3; ++r) { start[r] = p[1, r]; p[1, r] = 0 } }
    END {
      for (i = 1; i <= n; ++i) { along = dot(p, i, axis, 1); off = dot(p, i, p, i) - along * along; if (off > most) { most = off; far = i } }
      for (r = 0; r < 3; ++r) side[1, r] = (p[far, r] - dot(p, far, axis, 1) * axis[1, r]) / sqrt(most)
      for (i = 1; i <= n; i += 10) {
        print dot(p, i, axis, 1) "," dot(p, i, side, 1)
        if (i % 100 != 1) continue
        for (r = 0; r < 3; ++r) q[1, r] = p[i, r] + scale * (f[i, r] - dot(f, i, axis, i) * axis[i, r])
        printf "%g,%g\n%g,%g\n\n", dot(p, i, axis, 1), dot(p, i, side, 1), dot(q, 1, axis, 1), dot(q, 1, side, 1) >arrows
      } }' "trace_$1/trace.csv" >"path_$1.csv"
  plot "figure_$2.svg" "Path of the tip and clamping force, $1, after figure $2" "along the needle at the skin [mm]" "across it [mm]" \
    "path=path_$1.csv" "clamping,_$arrow_mm_per_n""_mm_for_each_N=arrows_$1.csv"
}
trajectory straight 16
trajectory turned 17

say "through all tissues of table II"
# shellcheck source=/dev/null
source "$root/pipelines/paper_pages/alamilla_2021_tissues.sh"
through_all_tissues straight

# Figures 14 and 15: a virtual hand goes 1.5 mm behind the skin, through a nick, and stays there.
say "a hand at the wall of the skin, live, by the direct method and by the tracking wall"
nick=(--set "/patient/corridor=$PWD/straight/corridor_ct.csv" --set /effects/needle_force/skin_nick_radius_mm=5)
replay run_nick straight straight/sessions/shoulder "${nick[@]}" "${no_images[@]}" --set /effects/tissue=null
reached=$(column run_nick/forces.csv depth_mm | awk -F, '$2 > 1.5 && !seen { print $1; seen = 1 }')
mkdir -p wall_session
cp straight/sessions/shoulder/session.json wall_session
for tool in needle probe; do
  awk -F, -v OFS=, -v end="$reached" 'NR == 1 { print; next } $1 <= end { print; $1 = ""; pose = $0 } END {
    for (n = 1; n <= 3000; ++n) print end + 0.001 * n pose }' "straight/sessions/shoulder/$tool.csv" >"wall_session/$tool.csv"
done
for wall in direct tracking; do
  acus-live "scenarios/$paper.json" --devices devices/virtual.json --headless --hand wall_session --quiet \
    --duration "$(awk -v t="$reached" 'BEGIN { print t + 3 }')" --set "/patient/labels=$PWD/straight/labels.seg.nrrd" \
    --set "/patient/ct_from_reference_file=$PWD/registration_straight/ct_from_reference.tfm" "${nick[@]}" "${no_images[@]}" \
    --set /effects/tissue=null --set "/effects/needle_force/wall=$wall" -o "live_$wall" --overwrite >/dev/null
  column "live_$wall/forces.csv" cutting_n | awk -F, -v from="$reached" '$1 > from + 1 && $1 < from + 1.5' >"wall_$wall.csv"
  # As summary.json has it.
  fact "chatter_${wall}_n" "$(sed -n 's/.*"needle_chatter_n": *\([-0-9.e]*\).*/\1/p' "live_$wall/summary.json")"
done
plot figure_14.svg "A hand that rests at a wall of 1 N, after figures 14 and 15" "time [s]" "cutting force [N]" \
  direct_method=wall_direct.csv tracking_wall=wall_tracking.csv

fact skin_n "$(awk -F, '$2 == "puncture" && !n { print $6; n = 1 }' run_straight/events.csv)"
fact wall_force_n "$(sed -n 's/.*"tissue": "skin".*"cutting_n": \([0-9.]*\).*/\1/p' "$root/configs/forces/alamilla.json")"
fact clamping_straight_n "$(number run_straight "largest lateral force")"
fact clamping_turned_n "$(number run_turned "largest lateral force")"
# In the last 5 mm of the way to the target: the needle advances on its new line.
fact clamping_advancing_n "$(awk -F, 'NR > 1 { d[NR] = $2; c[NR] = $9; if ($2 > most) { most = $2; at = NR } }
  END { for (i = at; i > 2 && d[i] > most - 5; --i) { s += c[i]; ++n } print s / n }' run_turned/forces.csv)"
# From the deepest place on, in the body.
fact clamping_withdrawing_n "$(awk -F, 'NR > 1 { if ($2 > most) { most = $2; s = n = 0 } if ($2 > 0) { s += $9; ++n } } END { print s / n }' run_turned/forces.csv)"
fact b_mode_ms "$(stage_ms run_turned B-mode)"
fact images "$(runs_of run_turned B-mode)"
fact step_us "$(step_us run_turned)"
image_size_facts run_turned
load_facts
heading "Tables"
for part in tissues forces speed; do table $part; done
note load
heading "Figures"
for number in 14 16 17 18_straight 18_turned 19 20; do figure figure_$number.svg figure_$number; done
figure layers.svg layers
last=$(find run_turned -name 'event_*.png' | sort | tail -n 1)
figure "$last" ultrasound
[[ ! -s run_turned/view_3d.png ]] || figure run_turned/view_3d.png scene
note missing
heading "Effect plan"
plan run_turned
