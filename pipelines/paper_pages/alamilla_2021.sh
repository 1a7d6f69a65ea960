# shellcheck shell=bash disable=SC2154 # Names of pipelines/papers.
# Alamilla-2021 in the synthetic shoulder: one straight insertion and one that changes direction.
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
  awk -F, 'NR > 1 { print $1 "," $2 }' "run_$name/forces.csv" >"depth_$name.csv"
done
plot figure_18.svg "Depth of the tip, after figures 16 to 18" "time [s]" "depth [mm]" \
  straight=depth_straight.csv turned=depth_turned.csv
plot figure_19.svg "Clamping force, after figure 19" "time [s]" "force across the path [N]" \
  straight=clamping_straight.csv turned=clamping_turned.csv
plot figure_20.svg "Cutting and withdrawal force, after figure 20" "time [s]" "force [N]" \
  straight=cutting_straight.csv turned=cutting_turned.csv

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
done
# chatter_of RUN: as summary.json has it.
chatter_of() { sed -n 's/.*"needle_chatter_n": *\([-0-9.e]*\).*/\1/p' "$1/summary.json" | awk '{ printf "%.3f N", $1 }'; }
plot figure_14.svg "A hand that rests at a wall of 1 N, after figures 14 and 15" "time [s]" "cutting force [N]" \
  direct_method=wall_direct.csv tracking_wall=wall_tracking.csv

heading "Tables"
table_begins
# largest_in TISSUE: largest cutting force while the tip is in it, either session.
largest_in() {
  awk -F, -v tissue="$1" 'FNR == 1 { for (i = 1; i <= NF; ++i) if ($i == "cutting_n") c = i; next }
    $3 == tissue && $c > most { most = $c } END { printf "%.2f N", most }' run_straight/forces.csv run_turned/forces.csv
}
row "Table II: skin" "1 N" "$(awk -F, '$2 == "puncture" && !n { printf "%.2f N", $6; n = 1 }' run_straight/events.csv)" \
  "force at the puncture" "the polynomial of eq. 2 until table II's force"
# Tissues that the two paths cross; fat is not in table II.
row "Table II: muscle" "2 N" "$(largest_in muscle)" "largest cutting force in the deltoid" "the same: table II is the table of this preset"
row "Table II: bursa" "1.5 N" "$(largest_in bursa)" "largest cutting force in the bursa" "1.5 mm of bursa: the wall of 0.25 N/mm keeps what it has of the muscle"
row "Table II: tendon" "2.5 N" "$(largest_in tendon)" "largest cutting force in the tendon" "2 mm of tendon before bone: not enough travel at 0.25 N/mm to reach 2.5 N"
row "Table II: bone" "4 N" "$(column run_turned/forces.csv bone_n | awk -F, '$2 > m { m = $2 } END { printf "%.2f N", m }')" \
  "largest force of bone" "bounded by table II"
row "clamping, straight" "a figure" "$(metric run_straight "largest lateral force")" "figure 19" "tremor of the scripted hand"
row "clamping, turned" "larger" "$(metric run_turned "largest lateral force")" "figure 19" "falls when the turned needle advances, as in the paper"
row "chatter of the direct method" "a figure" "$(chatter_of live_direct)" "figure 14; force above 30 Hz, live with a virtual hand" "a wall of 1 N at the skin, through a nick"
row "chatter of the tracking wall" "attenuated" "$(chatter_of live_tracking)" "figure 15, the same hand" "0.25 N/mm, as the paper's 250 N/m"
row "ultrasound image" "2 ms" "$(awk -v us="$(time_of run_turned B-mode)" 'BEGIN { printf "%.2g ms", us / 1000 }')" \
  "labels of the shoulder, deformed, one core; the paper: a GeForce 1070 and up to 7,864,320 triangles" "voxels in place of triangles; bench_surfaces measures the scene of 7,864,320 triangles"
row "force step" "-" "$(step_us run_turned) us" "all stages of a step" "the paper gives no time"
table_ends
heading "Figures"
figure figure_14.svg "Direct method and tracking wall (figures 14, 15), half a second of a live session with a virtual hand."
figure figure_18.svg "Depth of the tip. The paper's trajectories are of an expert, ours of a scripted hand with tremor."
figure figure_19.svg "Clamping: the force across the path. Arrows in the 3D view (figures 16, 17): force_arrow_mm_per_n of view_3d."
figure figure_20.svg "Cutting (above 0) and withdrawal (below 0)."
last=$(find run_turned -name 'event_*.png' | sort | tail -n 1)
figure "$last" "Ultrasound at the last event, deformed (figures 6, 7, 9, 10)."
[[ ! -s run_turned/view_3d.png ]] || figure run_turned/view_3d.png "The pedagogical view (figures 4a, 7)."
heading "Effect plan"
plan run_turned
