# shellcheck shell=bash disable=SC2154 # Names of pipelines/papers.
# Vidal-2008: the kidney, ten punctures of kidney and liver, and what each image costs.
page "Vidal-2008: simulation of ultrasound guided needle puncture"
say "the kidney: patient and session"
patient kidney patient
session=patient/sessions/kidney_puncture
length=60
if [[ -n $quick ]]; then length=9; fi
shortened $session short $length
replay run patient short --ct patient/ct.nrrd --set /effects/probe_force/press_mm=8 --set /effects/view_3d/rate_hz=1
say "the whole session, forces only"
replay run_forces patient $session --ct patient/ct.nrrd "${no_images[@]}" --set /effects/probe_force/press_mm=8

repetitions=10
[[ -z $quick ]] || repetitions=2
# punctures ORGAN KIND: many patients, one puncture of each at 500 mm/min; force by depth in the organ.
punctures() {
  local organ=$1 kind=$2 seed
  coarse "$kind" 3 "$organ.json"
  sed -i '/"to": "bone"/d; s/"aim": "bone"/"aim": "target"/; s/\("to": "target".*"speed_mm_per_s": \)[0-9.]*/\18.3333/' "$organ.json"
  for seed in $(seq "$repetitions"); do
    say "$organ, puncture $seed of $repetitions"
    patient "$kind" patient_n --config "$organ.json" --seed "$seed"
    replay run_n patient_n patient_n/sessions/* --ct patient_n/ct.nrrd "${no_images[@]}" --set /effects/probe_force=null
    # In steps of 1 mm from where the tip enters the organ, while it advances.
    awk -F, -v organ="$organ" 'NR == 1 { next }
      $3 == organ && !entered { from = $2; entered = 1 }
      { depth[NR] = $2; force[NR] = $4; if ($2 > most) { most = $2; last = NR } }
      END { for (i = 3; i < last; ++i) if (depth[i] > depth[i - 1]) {
              bin = int(depth[i] - from + 100) - 100
              if (bin >= -10 && bin < 20) { s[bin] += force[i]; ++n[bin] } }
            for (b = -10; b < 20; ++b) if (n[b]) print b "," s[b] / n[b] }' run_n/forces.csv >"${organ}_$seed.csv"
  done
  cat "$organ"_[0-9]*.csv | awk -F, -v organ="$organ" '
    { s[$1] += $2; ++n[$1]; if (!($1 in low) || $2 < low[$1]) low[$1] = $2; if (!($1 in high) || $2 > high[$1]) high[$1] = $2 }
    END { for (b = -10; b < 20; ++b) if (n[b]) { print b "," s[b] / n[b] > organ ".mean.csv"
          print b "," low[b] > organ ".low.csv"; print b "," high[b] > organ ".high.csv" } }'
  plot "figure_5_$organ.svg" "$repetitions punctures of the $organ at 500 mm/min" "depth behind the organ's surface [mm]" \
    "resistance [N]" "mean=$organ.mean.csv" "lowest=$organ.low.csv" "highest=$organ.high.csv"
}
rm -f kidney_[0-9]*.csv liver_[0-9]*.csv
punctures kidney kidney
punctures liver liver
# plateau ORGAN: mean and range from 3 mm behind the surface on.
plateau() {
  awk -F, 'FNR == 1 { ++file } $1 >= 3 && file == 1 { s += $2; ++n }
    $1 >= 3 && file == 2 && (!l || $2 < low) { low = $2; l = 1 } $1 >= 3 && file == 3 && $2 > high { high = $2 }
    END { printf "%.2f N (%.2f to %.2f)", s / n, low, high }' "$1.mean.csv" "$1.low.csv" "$1.high.csv"
}
# The analytic models of section 3.3.2, on recordings of the patient's synthetic tensile tests.
acus-fit patient/force_curves/kidney_*.csv --models gaussians -o fit_kidney --overwrite --quiet >fit_kidney.txt
acus-fit patient/force_curves/liver_*.csv --models gaussians -o fit_liver --overwrite --quiet >fit_liver.txt
# spread FILE COLUMN: mean and range of a fitted number over the recordings.
spread() {
  awk -v c="$2" '$1 ~ /_[0-9]+$/ && /\+-/ { v = $c; s += v; ++n; if (n == 1 || v < l) l = v; if (v > h) h = v }
    END { printf "%.2f (%.2f to %.2f)", s / n, l, h }' "$1"
}
heading "Tables"
table_begins
for organ in kidney liver; do
  row "tensile test, $organ: force at the puncture" "a figure" "$(spread fit_$organ.txt 2) N" "10 synthetic recordings at 500 mm/min, fitted" "their parameters are chosen after figure 5, spread 12 %"
  row "tensile test, $organ: depth of the puncture" "about 10 mm" "$(spread fit_$organ.txt 5) mm" "the same" ""
done
row "plateau in the kidney (figure 5a)" "a figure, above the liver's" "$(plateau kidney)" "$repetitions synthetic patients, preset vidal_2008" \
  "the resistance by HU is chosen: contrast agent raises the kidney's HU, and with it the resistance"
row "plateau in the liver (figure 5b)" "a figure, below the kidney's" "$(plateau liver)" "$repetitions synthetic patients, preset vidal_2008" "as above"
row "initial displacement" "about 10 mm" "0 mm" "needle model vidal" "the model does not deform tissue: a peak where tissues meet (K_edge) in place of a rise over 10 mm"
largest=$(number run_forces "largest axial force")
rms=$(number run_forces "RMS axial force while inserted")
for limit in "PHANTOM Omni:3.3:0.88" "PHANTOM Desktop:7.9:1.75"; do
  IFS=: read -r device peak continuous <<<"$limit"
  row "$device, largest force" "$peak N" "$largest N" "kidney session" "$(awk -v f="$largest" -v l="$peak" 'BEGIN { print f <= l ? "within its limit" : "beyond it: the guard limits it" }')"
  row "$device, continuous force" "$continuous N" "$rms N" "RMS while inserted" "$(awk -v f="$rms" -v l="$continuous" 'BEGIN { print f <= l ? "within: no rest is needed" : "beyond it: only for a while" }')"
done
ms() { awk -v us="$(time_of run "$1")" 'BEGIN { print us / 1000 }'; }
row "frame rate, ultrasound, CT and fluoroscopy" "24 images/s on a PC, 60 on a workstation" \
  "$(per_s "$(ms B-mode)" "$(ms "CT slice")" "$(ms fluoroscopy)") images/s" "one core, no graphics card" \
  "less in the row than in the paper's: no 3D scene"
row "frame rate, with the 3D scene" "24 and 60" \
  "$(per_s "$(ms B-mode)" "$(ms "CT slice")" "$(ms fluoroscopy)" "$(ms "view in 3D")") images/s" \
  "the same and view_3d, 640 x 480, shadows, 4 rays a pixel" "slower: rays through voxels on a core, not triangles on a graphics card"
row "force step" "1 kHz" "$(step_us run_forces) us" "needle and probe" ""
row "probe" "stiffer over bone" "$(metric run_forces "largest probe force")" "pressed in by 8 mm" "the paper gives no forces"
table_ends
heading "Figures"
figure figure_5_kidney.svg "Figure 5a in the simulation: mean and range."
figure figure_5_liver.svg "Figure 5b in the simulation: mean and range."
figure fit_kidney/kidney_1_models.svg "A synthetic tensile test of the kidney, its plateau and the sum of eight Gaussians (figure 5a as drawn)."
figure fit_liver/liver_1_models.svg "The same of the liver (figure 5b as drawn)."
image=$(find run -name 'event_*.png' | sort | tail -n 1)
[[ -z $image ]] || figure "$image" "CT and ultrasound with the needle (figure 7)."
figure run/view_3d.png "The 3D scene with shadows (figure 3)."
heading "Effect plan"
plan run
