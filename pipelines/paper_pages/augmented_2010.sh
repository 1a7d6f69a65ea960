# shellcheck shell=bash disable=SC2154 # Names of pipelines/papers.
# Augmented-2010 in the synthetic lumbar patient.
page "Augmented-2010: towards an augmented ultrasound guided spinal needle insertion system"
say "patient and session"
patient lumbar patient
session=patient/sessions/lumbar_puncture
common=(--ct patient/ct.nrrd --set "/patient/corridor=$PWD/patient/corridor_ct.csv")
if [[ -n $quick ]]; then
  shortened $session short 12
  session=short
fi
say "the insertion, with images"
replay run patient $session "${common[@]}"
say "forces with larger meshes, and in 3D"
replay run_1000 patient $session "${common[@]}" "${no_images[@]}" --set /effects/tissue/fe_2d/spacing_mm=3.3
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
    END { printf "%.2f mm", sqrt(s / n) }' "sample/truth/$1.csv" "tracked/$1.csv"
}
heading "Tables"
table_begins
contact_us=$(awake_us run "tissue contact")
contact_1000_us=$(awake_us run_1000 "tissue contact")
rate() { awk -v us="$1" 'BEGIN { printf "%.3g kHz", 1000 / us }'; }
row "finite elements, $(nodes 5) nodes" "361 nodes: 512 Hz" "$(rate "$contact_us")" \
  "mean step of tissue contact while a tool touches tissue" "less work: only rows of the nodes in contact are updated, the paper's own second method; the whole inverse is timed in docs/papers-claims.md"
row "finite elements, $(nodes 3.3) nodes" "over 1000 nodes: 1 kHz" "$(rate "$contact_1000_us")" \
  "the same, spacing 3.3 mm" "the paper's second method, so the same work; 13 years between the machines"
row "whole force step" "1 kHz" "$(step_us run) us" "all stages of a step" ""
row "largest axial force" "-" "$(metric run "largest axial force")" "22G spinal needle, default force table" "the paper gives no forces"
row "largest lateral force" "-" "$(metric run "largest lateral force")" "beam, direction locked" "the paper gives no forces"
row "accuracy of the camera, probe" "2.1 mm RMS" "$(errors Probe)" \
  "$count rendered images, camera calibrated from rendered boards" "rendered images: no motion blur, no curved paper; a real camera adds its calibration's error"
row "accuracy of the camera, mannequin" "2.1 mm RMS" "$(errors Reference)" "the same" "distance along the line of sight dominates with one camera; the paper's has two"
row "registration of the mannequin" "by touched points, error not given" \
  "$(sed -n 's/.*"tre_rms_mm": \([0-9.]\{1,4\}\).*/\1 mm/p' registration_patient/registration.json | head -n 1)" \
  "expected error at the target, 8 markers with 0.4 mm of error" ""
row "CT slice and ultrasound" "a frame of the GUI loop" \
  "$(per_s "$(awk -v a="$(time_of run "CT slice")" -v b="$(time_of run B-mode)" 'BEGIN { print (a + b) / 1000 }')") images/s" \
  "both images, one core" "the video overlay is not in it"
table_ends
heading "Figures"
for image in $(find run -name 'event_*.png' | sort | sed -n '1p;$p'); do
  figure "$image" "CT slice and ultrasound with the needle (figure 3, right)."
done
figure run/forces.svg "Forces of the session."
note "Figure 3, left (the CT over the video, with the ultrasound plane and needle) is in the window of the live session: pipelines/live-session --new PLACE --paper augmented_2010."
heading "Future work that is there"
table_begins
row "bevel and bending" "future work" "largest lateral force $(metric run_bevel "largest lateral force")" \
  "needle bendable, tissue springs, needles/bevel_22g.json" "a variant of the preset"
row "viscoelastic tissue" "-" "largest axial force $(metric run_viscoelastic "largest axial force")" \
  "fe_2d, elasticity/viscoelastic.json, forces/viscoelastic.json" "a variant of the preset"
row "layers of tissue" "future work" "$(awk -F, '{ t[$3] } END { for (n in t) ++k; print k - 2 " tissues" }' run/events.csv)" \
  "met by the tip in this run" "each has its elasticity and its puncture"
row "3D elements" "future work" "fe_3d" "pipelines/demo --paper augmented_2010 --tissue fe_3d" "condensed beforehand by acus-mesh"
table_ends
heading "Effect plan"
plan run
