#!/usr/bin/env bash
# The preset of one paper as a user meets it: checked, explained, replayed; its effect plan and its numbers held.
# Usage: run_paper.sh SOURCE_FOLDER FOLDER NAME
set -euo pipefail
no_images=() # Of common.sh.
root=$1 output=$2 paper=$3
export PATH="$ACUS_BIN:$PATH"
# shellcheck source=/dev/null
source "$root/pipelines/paper_pages/common.sh"
rm -rf "$output"
mkdir -p "$output"
cd "$output"

declare -A kind=([augmented_2010]=lumbar [vidal_2008]=kidney [alamilla_2021]=shoulder [fortmeier_2016]=liver_ptc)
coarse "${kind[$paper]}" 3 patient.json
patient "${kind[$paper]}" patient --config patient.json
session=(patient/sessions/*)
inputs=(--ct patient/ct.nrrd --set "/patient/corridor=$PWD/patient/corridor_ct.csv")
[[ $paper != alamilla_2021 ]] || inputs=() # It reads no CT.
if [[ $paper == fortmeier_2016 ]]; then
  acus-breathing --single patient/ct.nrrd --labels patient/labels.seg.nrrd --model surrogate --resolution 24 \
    -o motion --quiet >motion.txt
  inputs+=(--set "/effects/breathing/motion=$PWD/motion")
fi
[[ $paper == augmented_2010 || $paper == alamilla_2021 ]] || inputs+=(--set /effects/probe_force/press_mm=8)

acus-replay "scenarios/$paper.json" "${session[0]}" --labels patient/labels.seg.nrrd \
  --transform registration_patient/ct_from_reference.tfm "${inputs[@]}" --check >check.txt
grep -q ": OK" check.txt || fail "--check does not say OK"

# Forces of the whole session; images of a tenth of a second of it.
replay run patient "${session[0]}" "${inputs[@]}" "${no_images[@]}"
shortened "${session[0]}" short 0.1
replay images patient short "${inputs[@]}"
# in_plan STAGE yes|no: whether the preset's plan with images has the stage.
in_plan() {
  local is=no
  grep -Eq "^$1  *(step|image)  *(in|asleep) " images.txt && is=yes
  [[ $is == "$2" ]] || fail "$paper: stage '$1' in the plan: $is, not $2"
}
# held METRIC VALUE: within 2 %.
held() {
  local got
  got=$(number run "$1")
  awk -v got="$got" -v want="$2" 'BEGIN { d = got - want; exit !(got != "" && d * d <= (0.02 * want) ^ 2) }' ||
    fail "$paper: $1: $got, not $2" 4
}
in_plan B-mode yes
case $paper in
  augmented_2010)
    for stage in breathing "probe force" fluoroscopy "view in 3D" "tissue lookup"; do in_plan "$stage" no; done
    in_plan "tissue contact" yes
    in_plan "CT slice" yes
    ;;
  vidal_2008)
    for stage in breathing "tissue contact" deformation "needle shape"; do in_plan "$stage" no; done
    for stage in "probe force" fluoroscopy "CT slice" "view in 3D"; do in_plan "$stage" yes; done
    ;;
  alamilla_2021)
    for stage in breathing "CT slice" fluoroscopy "probe force" "tissue contact"; do in_plan "$stage" no; done
    in_plan "view in 3D" yes
    ;;
  fortmeier_2016)
    for stage in breathing "needle shape" "tissue contact" "probe force" fluoroscopy "CT slice" "view in 3D"; do
      in_plan "$stage" yes
    done
    ;;
esac
while read -r what; do held "${what% *}" "${what##* }"; done <"$root/tests/cli/papers/$paper.txt"
