# shellcheck shell=bash disable=SC2154 # Names of pipelines/papers.
# Vidal-2008: the kidney, strokes at constant speed into kidney and liver, and what each image costs.
page "Vidal-2008: simulation of ultrasound guided needle puncture"
say "the kidney: patient and session"
patient kidney patient
session=patient/sessions/kidney_puncture
length=60
if [[ -n $quick ]]; then length=9; fi
shortened $session short $length
press_mm=8
replay run patient short --ct patient/ct.nrrd --set /effects/probe_force/press_mm=$press_mm --set /effects/view_3d/rate_hz=1
say "the whole session, forces only"
replay run_forces patient $session --ct patient/ct.nrrd "${no_images[@]}" --set /effects/probe_force/press_mm=$press_mm

# shellcheck source=/dev/null
source "$root/pipelines/paper_pages/vidal_2008_strokes.sh"
repetitions=10
[[ -z $quick ]] || repetitions=2
strokes kidney kidney
strokes liver liver
figure_5_facts
# The analytic models of section 3.3.2, on recordings of the patient's synthetic tensile tests.
acus-fit patient/force_curves/kidney_*.csv --models gaussians -o fit_kidney --overwrite --quiet >fit_kidney.txt
acus-fit patient/force_curves/liver_*.csv --models gaussians -o fit_liver --overwrite --quiet >fit_liver.txt
# spread ORGAN COLUMN UNIT: mean and range of a fitted number over the recordings.
spread() {
  awk -v c="$2" -v name="${1}_fit" -v unit="$3" '$1 ~ /_[0-9]+$/ && /\+-/ { v = $c; s += v; ++n; if (n == 1 || v < l) l = v; if (v > h) h = v }
    END { printf "%s_%s,%.2f\n%s_low_%s,%.2f\n%s_high_%s,%.2f\n", name, unit, s / n, name, unit, l, name, unit, h }' "fit_$1.txt" >>facts.csv
}
for organ in kidney liver; do
  spread $organ 2 n
  spread $organ 5 mm
  recordings=(patient/force_curves/${organ}_*.csv)
  fact ${organ}_recordings ${#recordings[@]}
done
fact recordings_spread_percent "$(sed -n 's/.*"spread_percent": \([0-9.]*\).*/\1/p' "$root/configs/phantoms/kidney.json" | head -n 1)"
fact largest_n "$(number run_forces "largest axial force")"
fact rms_n "$(number run_forces "RMS axial force while inserted")"
fact probe_n "$(number run_forces "largest probe force")"
fact press_mm $press_mm
fact needle "$(sed -n 's/.*"name": "\([^,"]*, [^,"]*\).*/\1/p' "$root/configs/$(sed -n 's/.*"needle": "\([^"]*\)".*/\1/p' "$root/configs/scenarios/$paper.json")")"
fact step_us "$(step_us run_forces)"
fact b_mode_ms "$(stage_ms run B-mode)"
fact ct_ms "$(stage_ms run "CT slice")"
fact fluoroscopy_ms "$(stage_ms run fluoroscopy)"
fact view_3d_ms "$(stage_ms run "view in 3D")"
fact images "$(runs_of run B-mode)"
image_size_facts run
load_facts
heading "Tables"
for part in figure_5 recordings devices speed; do table $part; done
note load
heading "Figures"
for organ in kidney liver; do figure figure_5_$organ.svg figure_5_$organ; done
for organ in kidney liver; do figure fit_$organ/${organ}_1_models.svg recording_$organ; done
image=$(find run -name 'event_*.png' | sort | tail -n 1)
[[ -z $image ]] || figure "$image" ultrasound
figure run/view_3d.png scene
note missing
heading "Effect plan"
plan run
