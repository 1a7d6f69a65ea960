# shellcheck shell=bash disable=SC2154 # Names of pipelines/papers.
# Augmented-2010 in the synthetic lumbar patient.
page "Augmented-2010: towards an augmented ultrasound guided spinal needle insertion system"
say "patient and session"
cp "$root/configs/phantoms/lumbar.json" patient.json
withdrawn_before_turning patient.json
patient lumbar patient --config patient.json
session=patient/sessions/lumbar_puncture
press_mm=8
common=(--ct patient/ct.nrrd --set "/patient/corridor=$PWD/patient/corridor_ct.csv" --set /effects/probe_force/press_mm=$press_mm)
images=$session
if [[ -n $quick ]]; then
  shortened $session short 12
  images=short
fi
say "the insertion, with images"
replay run patient $images "${common[@]}"
say "forces of the whole session, with larger meshes, and variants"
replay run_forces patient $session "${common[@]}" "${no_images[@]}"
fine_spacing_mm=3.3
replay run_1000 patient $session "${common[@]}" "${no_images[@]}" --set /effects/tissue/fe_2d/spacing_mm=$fine_spacing_mm
replay run_bevel patient $session "${common[@]}" "${no_images[@]}" --set /effects/tissue/model=springs \
  --set /effects/needle/model=bendable --set /effects/needle/axis_lock=false \
  --set /needle=needles/bevel_22g.json
replay run_viscoelastic patient $session "${common[@]}" "${no_images[@]}" \
  --set /effects/tissue/elasticity=elasticity/viscoelastic.json --set /effects/tissue/table=forces/viscoelastic.json
# nodes SPACING: of the plane 90 mm wide that begins 12 mm above the skin and ends 30 mm beyond the target.
nodes() {
  awk -F, -v h="$1" '$1 == "entry" || $1 == "target" { n++; for (i = 2; i <= 4; ++i) p[n, i] = $i }
    END { for (i = 2; i <= 4; ++i) d += (p[1, i] - p[2, i]) ^ 2
          print (2 * int(45 / h + 0.5) + 1) * (int(12 / h + 0.5) + int((sqrt(d) + 30) / h + 0.5) + 1) }' \
    patient/corridor_ct.csv
}
say "camera: calibration and tracked facets"
count=40
[[ -z $quick ]] || count=8
acus-camera sample --count "$count" -o sample --overwrite --quiet
acus-camera calibrate sample/board -o calibrated --overwrite --quiet >calibrated.txt
acus-camera track sample/facets --camera calibrated/camera.json -o tracked --overwrite --quiet >tracked.txt
# errors OBJECT: RMS distance between where it was tracked and where it was drawn, mm.
errors() {
  awk -F, 'FNR == 1 { next } NR == FNR { x[$1] = $2; y[$1] = $3; z[$1] = $4; next }
    $NF == "OK" { s += ($2 - x[$1]) ^ 2 + ($3 - y[$1]) ^ 2 + ($4 - z[$1]) ^ 2; ++n }
    END { printf "%.3f", sqrt(s / n) }' "sample/truth/$1.csv" "tracked/$1.csv"
}
fact nodes "$(nodes 5)"
fact nodes_fine "$(nodes $fine_spacing_mm)"
fact fine_spacing_mm $fine_spacing_mm
fact contact_us "$(awake_us run_forces "tissue contact")"
fact contact_fine_us "$(awake_us run_1000 "tissue contact")"
fact step_us "$(step_us run_forces)"
fact ct_ms "$(stage_ms run "CT slice")"
fact b_mode_ms "$(stage_ms run B-mode)"
image_size_facts run
fact bone_contacts "$(number run_forces "bone contacts")"
fact bone_s "$(number run_forces "time on bone")"
fact bone_press_mm "$(sed -n 's/.*"bone_press_mm": \([0-9.]*\).*/\1/p' patient.json)"
fact axial_n "$(number run_forces "largest axial force")"
fact soft_n "$(awk -F, 'NR > 1 && $8 == 0 && $4 > m { m = $4 } END { print m }' run_forces/forces.csv)"
# The model's depth of the needle is that of the drawn tip; on bone it stays where the contact was.
fact drawn_in_bone_mm "$(awk -F, 'NR == 1 { next } $13 ~ /bone_contact/ { at = $2 } $13 ~ /bone_release/ { at = "" }
  at != "" && $2 - at > m { m = $2 - at } END { printf "%.3f", m }' run_forces/forces.csv)"
fact lateral_n "$(number run_forces "largest lateral force")"
fact probe_n "$(number run_forces "largest probe force")"
fact press_mm $press_mm
fact probe_mm "$(errors Probe)"
fact mannequin_mm "$(errors Reference)"
fact camera_images "$count"
fact registration_mm "$(sed -n 's/.*"tre_rms_mm": \([0-9.]*\).*/\1/p' registration_patient/registration.json | head -n 1)"
fact markers "$(awk 'END { print NR - 1 }' patient/markers_ct.csv)"
fact bevel_n "$(number run_bevel "largest lateral force")"
fact viscoelastic_n "$(number run_viscoelastic "largest axial force")"
fact tissues "$(awk -F, 'NR > 1 && $3 != "outside" { t[$3] } END { for (n in t) ++k; print k }' run_forces/events.csv)"
load_facts
heading "Tables"
for part in speed feel tracking; do table $part; done
note load
heading "Figures"
for image in $(find run -name 'event_*.png' | sort | sed -n '1p;$p'); do figure "$image" slices; done
figure run_forces/forces.svg forces
note missing
heading "Future work that is there"
table future
heading "Effect plan"
plan run
