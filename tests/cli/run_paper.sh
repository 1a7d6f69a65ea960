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
factor=3
[[ $paper != augmented_2010 ]] || factor=2 # On the coarser grid there is no bone on the first way.
coarse "${kind[$paper]}" $factor patient.json
[[ $paper != augmented_2010 ]] || withdrawn_before_turning patient.json
patient "${kind[$paper]}" patient --config patient.json
session=(patient/sessions/*)
inputs=(--ct patient/ct.nrrd --set "/patient/corridor=$PWD/patient/corridor_ct.csv")
[[ $paper != alamilla_2021 ]] || inputs=() # It reads no CT.
if [[ $paper == fortmeier_2016 ]]; then
  acus-breathing --single patient/ct.nrrd --labels patient/labels.seg.nrrd --model surrogate --resolution 24 \
    -o motion --quiet >motion.txt
  inputs+=(--set "/effects/breathing/motion=$PWD/motion")
fi
[[ $paper == alamilla_2021 ]] || inputs+=(--set /effects/probe_force/press_mm=8)

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
# The paper's workplace: its demonstration does its exercise, and so does somebody who does what the window says.
# shellcheck source=/dev/null
source "$root/tests/cli/play.sh"
mkdir -p work/exercises work/sessions
ln -s ../patient work/patient
ln -s ../registration_patient work/registration
[[ ! -d motion ]] || ln -s ../motion work/motion
PYTHONPATH=$root/pipelines/launcher python3 -B -c \
  'import pathlib, sys, new_workplace; new_workplace.write_system(pathlib.Path("work").resolve(), sys.argv[1])' "$paper"
play_demonstration work play
expected=''
# That mannequin does not yield: a probe that is moved by keys lies within 3 mm of it, and feels nothing.
[[ $paper != augmented_2010 ]] || expected='the probe never touched the skin'
play_first_session work first "$expected"

in_plan B-mode yes
case $paper in
  augmented_2010)
    for stage in breathing fluoroscopy "view in 3D" "tissue lookup"; do in_plan "$stage" no; done
    for stage in "tissue contact" "probe force" "CT slice"; do in_plan "$stage" yes; done
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

# Figures 5, upper, and 10 of Fortmeier-2016 as the page makes them.
if [[ $paper == fortmeier_2016 ]]; then
  # shellcheck source=/dev/null
  source "$root/pipelines/paper_pages/fortmeier_2016_figures.sh"
  figure_5_upper
  # at_40_mm RUN N: on the way in, within 0.01 N.
  at_40_mm() {
    awk -F, -v want="$2" '$1 > deep { deep = $1; n = $2 } END { d = n - want; exit !(deep > 39 && d * d < 1e-4) }' "$1.csv" ||
      fail "$paper: figure 5, upper: $1 is not $2 N at 40 mm" 4
  }
  at_40_mm printed 1.37
  at_40_mm block 1.49
  for model in half_cycle surrogate; do synthetic_motion $model 24 motion_deep_$model --diaphragm-mm 30; done
  # Figure 8, lower: in the world the tip is on the straight line of the hand, but for the bend of the needle.
  straight_while_breathing
  figure_8_path
  bend=$(awk -F, 'NR == 1 { for (i = 1; i <= NF; ++i) if ($i == "deflection_mm") c = i; next } $c > m { m = $c } END { print m }' run_straight/forces.csv)
  awk -v world="$(off_line path_world.csv)" -v rest="$(off_line path_rest.csv)" -v bend="$bend" 'BEGIN { exit !(world <= bend + 0.1 && rest > world + 3) }' ||
    fail "$paper: figure 8: in the world the path is $(off_line path_world.csv) mm off the line, at rest $(off_line path_rest.csv) mm, with a bend of $bend mm" 4
  figure_10
  # hysteresis MODEL: mean difference of the slices in the middle of in- and expiration, without their text, grey levels.
  hysteresis() {
    /usr/bin/python3 - "breath_$1/frames/planes_0000" <<'PYTHON'
import sys
from PIL import Image, ImageChops, ImageStat
out, back = (Image.open(f"{sys.argv[1]}{n}.png").convert("L") for n in (1, 3))
below_text = (0, 24, out.width, out.height)
print(ImageStat.Stat(ImageChops.difference(out, back).crop(below_text)).mean[0])
PYTHON
  }
  [[ $(hysteresis half_cycle) == 0.0 ]] || fail "$paper: figure 10: half-cycle key frames show hysteresis" 4
  awk -v grey="$(hysteresis surrogate)" 'BEGIN { exit !(grey > 1) }' || fail "$paper: figure 10: the surrogate model shows no hysteresis" 4
fi
