# shellcheck shell=bash disable=SC2154 # Names of developer/figures.
# How each group of docs/figures/figures.toml is made. Sourced by developer/figures.
# Expects: $root, $figures (docs/figures), the programs in PATH, and a work folder as the current one.

# build TARGET...: brings the programs up to date, unless ACUS_BIN says which to take.
build() { [[ -n ${ACUS_BIN:-} ]] || "$root/pipelines/build" "$@" >&2; }
quietly() { "$@" >/dev/null; }
# patient KIND: once in a run of developer/figures; also its registration.
patient_of() {
  [[ -f $1/made_by_$$ ]] && return
  acus-phantom patient "$1" -o "$1" --overwrite --quiet >/dev/null
  acus-register --quiet --from "$1/markers_mannequin.csv" --to "$1/markers_ct.csv" --target "$1/target_ct.csv" \
    -o "registration_$1" --overwrite >/dev/null 2>&1
  touch "$1/made_by_$$"
}
# replayed RUN SCENARIO KIND [acus-replay argument...]: the session of a patient.
replayed() {
  local run=$1 scenario=$2 kind=$3 sessions
  shift 3
  sessions=("$kind"/sessions/*)
  acus-replay "scenarios/$scenario.json" "${sessions[0]}" --ct "$kind/ct.nrrd" --labels "$kind/labels.seg.nrrd" \
    --transform "registration_$kind/ct_from_reference.tfm" --no-sequence --quiet -o "$run" --overwrite "$@" >/dev/null
}
# still RUN WHICH: the still of an event; WHICH as head or tail select it.
still() { printf '%s\n' "$1"/event_*.png | "${@:2}"; }
# point KIND NAME: "x,y,z" of one end of the needle's way.
point() { awk -F, -v name="$2" '$1 == name { print $2 "," $3 "," $4 }' "$1/corridor_ct.csv"; }
# small FILE.png TO: 256 colours.
small() {
  /usr/bin/python3 -B -c 'import sys
from PIL import Image
Image.open(sys.argv[1]).convert("RGB").quantize(256, dither=Image.Dither.NONE).save(sys.argv[2], optimize=True)' "$1" "$2"
}
mesh_of_liver() {
  patient_of liver
  [[ -f mesh/made_by_$$ ]] && return
  acus-mesh liver/labels.seg.nrrd --config "$root/configs/meshes/tissue.json" --corridor-from="$(point liver entry)" \
    --corridor-to="$(point liver target)" --condense -o mesh --overwrite --quiet >/dev/null
  touch "mesh/made_by_$$"
}

make_alamilla_forces() {
  build alamilla_figures
  alamilla_figures "$figures"
}

make_displacement_functions() {
  build docs_figures
  quietly env ACUS_WRITE_DOCS=1 docs_figures --gtest_brief=1
}

make_tissue_meshes() {
  build tissue_meshes_figure
  tissue_meshes_figure "$figures/tissue_meshes.svg"
}

make_force_depth() {
  build programs force_depth_figure straight_session
  mesh_of_liver
  rm -rf straight
  straight_session liver/corridor_ct.csv straight
  # model NAME [change...]: replays forces only.
  model() {
    local name=$1
    shift
    acus-replay scenarios/liver_biopsy.json straight --labels liver/labels.seg.nrrd --transform identity \
      --set /effects/ultrasound=null --set /effects/ct_slice=null --set /patient/mesh=mesh \
      --set /patient/corridor=liver/corridor_ct.csv "$@" -o "run_$name" --overwrite --quiet >/dev/null
  }
  local tissue=(--set /effects/needle_force/model=tissue)
  model layered
  model springs "${tissue[@]}" --set /effects/tissue/model=springs
  model fe_2d "${tissue[@]}" --set /effects/tissue/model=fe_2d
  model fe_3d "${tissue[@]}" --set /effects/tissue/model=fe_3d
  force_depth_figure "$figures/force_depth_models.svg" "layered law, rigid tissue"=run_layered \
    "springs (Fortmeier)"=run_springs "plane finite elements (2010)"=run_fe_2d "finite elements in 3D"=run_fe_3d
}

# Replays of the preset, as on the page of pipelines/papers.
make_fortmeier() {
  build programs
  mkdir -p fortmeier
  cd fortmeier || return
  paper=fortmeier_2016
  # shellcheck source=/dev/null
  source "$root/pipelines/paper_pages/common.sh"
  # shellcheck source=/dev/null
  source "$root/pipelines/paper_pages/${paper}_figures.sh"
  rm -f facts.csv
  acus-phantom patient liver_ptc -o patient --overwrite --quiet
  motions 64
  figure_5_upper
  figure_5_lower
  figure_6
  figure_8
  figure_9
  figure_10
  figure_11
  figure_12 64
  local figure
  for figure in 5_upper.svg 5_lower.svg 6.png 8.png 8_path.svg 9.png 10.png 11_slices.png 11_rays.png 12_slices.png 12_ribs.png; do
    cp "figure_$figure" "$figures/fortmeier_$figure"
  done
}

make_ultrasound_models() {
  build programs ultrasound_figures
  patient_of liver
  patient_of lumbar
  local probe=$root/configs/probes/curvilinear_c5.json figure
  for figure in models beams vidal; do
    ultrasound_figures liver "$probe" "$figure" "$figures/ultrasound_liver_$figure.png"
  done
  ultrasound_figures lumbar "$probe" alamilla "$figures/ultrasound_lumbar_alamilla.png"
  ultrasound_figures liver "$probe" vidal_7 "$figures/vidal_7.png"
  patient_of shoulder
  for figure in alamilla_6 alamilla_9_10; do
    ultrasound_figures shoulder "$root/configs/probes/linear_l7_4.json" $figure "$figures/$figure.png"
  done
}

make_ultrasound_2010() {
  build programs
  local kind scenario
  for kind in lumbar liver; do
    patient_of $kind
    scenario=$([[ $kind == lumbar ]] && echo lumbar_puncture || echo liver_biopsy)
    replayed "2010_$kind" "$scenario" $kind --no-film --set '/effects/ultrasound={"model": "columns_2010"}' \
      --set /probe=probes/curvilinear_c5.json
    cp "$(still "2010_$kind" tail -n 1)" "$figures/ultrasound_$kind.png"
  done
}

# The needle in the liver, which its finite elements draw in.
make_tissue_in_image() {
  build programs
  mesh_of_liver
  replayed tissue_liver liver_biopsy liver --no-film --set /effects/needle_force/model=tissue \
    --set '/effects/tissue={"model": "fe_3d"}' --set "/patient/mesh=$PWD/mesh" --png events
  cp "$(still tissue_liver tail -n 1)" "$figures/tissue_liver.png"
}

make_view_3d() {
  build programs
  patient_of liver
  local surfaces='[{"tissue": "skin", "opacity": 0.35}, {"tissue": "liver", "opacity": 0.5}, {"tissue": "bone"},
    {"tissue": "kidney", "opacity": 0.8}, {"tissue": "vessel"}, {"tissue": "lesion"}]'
  replayed view_liver liver_biopsy liver --no-film \
    --set "/effects/view_3d={\"rate_hz\": 0.2, \"width_px\": 800, \"height_px\": 600, \"surfaces\": $surfaces}"
  cp view_liver/view_3d.png "$figures/view_3d_liver.png"
}

# The plan that the report of a replay draws.
make_effect_plan() {
  build programs
  patient_of lumbar
  replayed plan lumbar_puncture lumbar --no-film --set '/effects/needle={"model": "bendable"}'
  /usr/bin/python3 -B -c 'import re, sys
plans = [svg for svg in re.findall(r"<svg.*?</svg>", open(sys.argv[1], encoding="utf-8").read(), re.S) if "needle pose" in svg]
open(sys.argv[2], "w", encoding="utf-8").write(plans[0] + "\n")' plan/report.html "$figures/effect_plan.svg"
}

# The first image of README: the last puncture of the demonstration.
make_demo() {
  build programs
  quietly "$root/pipelines/demo" -o demo
  cp "$(still demo/run tail -n 1)" "$figures/demo_lumbar.png"
}

# After Vidal-2008, figure 5: eight Gaussians over a recording of the synthetic patient.
make_force_fit() {
  build programs
  patient_of liver
  quietly acus-fit liver/force_curves/liver_capsule_4.csv --models gaussians -o fit --overwrite
  cp fit/liver_capsule_4_models.svg "$figures/vidal_figure_5.svg"
}

# Every view of the window of a live session, in a virtual X server.
make_windows() {
  build programs window_figures
  patient_of liver
  rm -rf windows
  mkdir windows
  "$root/pipelines/common/on_display.sh" window_figures liver windows
  local image
  for image in windows/window_*.png; do small "$image" "$figures/${image#windows/}"; done
}

# The workplaces of the papers while their exercise is shown.
make_papers() {
  build programs
  local paper exercises
  for paper in augmented_2010 alamilla_2021 fortmeier_2016; do
    rm -rf "workplace_$paper"
    quietly "$root/pipelines/live-session" --new "workplace_$paper" --paper $paper
    # Rendered on a processor, the volume view may have no image yet when the window is photographed.
    [[ $paper != fortmeier_2016 ]] || echo ultrasound,3d,ct >"workplace_$paper/views"
    exercises=("workplace_$paper"/exercises/*.json)
    quietly "$root/pipelines/common/on_display.sh" "$root/pipelines/live-session" --demo --text --no-report --duration 22 \
      --trainee demonstration --exercise "$(basename "${exercises[0]}" .json)" --screenshot "$PWD/paper_$paper.png" \
      "workplace_$paper" </dev/null
    small "paper_$paper.png" "$figures/paper_$paper.png"
  done
}

# The default workplace while its demonstration is played.
make_sessions() {
  build programs
  rm -rf places/default
  mkdir -p places
  quietly "$root/pipelines/live-session" --text --new places/default
  quietly "$root/pipelines/common/on_display.sh" "$root/pipelines/live-session" --text --demo --trainee T07 --duration 30 \
    --exercise lumbar_puncture --screenshot "$PWD/session_lumbar.png" places/default </dev/null
  small session_lumbar.png "$figures/session_lumbar.png"
}

# colours FILE.png: how many it has.
colours() {
  /usr/bin/python3 -B -c 'import sys
from PIL import Image
print(len(Image.open(sys.argv[1]).convert("RGB").getcolors(1 << 24)))' "$1"
}
# The launcher with two workplaces: photographed when it shows them and no longer changes.
make_launcher() {
  build programs
  mkdir -p places display
  [[ -e places/default ]] || quietly "$root/pipelines/live-session" --text --new places/default
  [[ -e places/vidal_2008 ]] || quietly "$root/pipelines/live-session" --text --new places/vidal_2008 --paper vidal_2008
  local server program tries
  Xvfb -displayfd 7 -screen 0 1100x700x24 -fbdir "$PWD/display" -nolisten tcp 7>display/number >/dev/null 2>&1 &
  server=$!
  sleep 3
  DISPLAY=:$(head -n 1 display/number) acus-launcher places >/dev/null 2>launcher.txt &
  program=$!
  rm -f launcher.png
  for tries in {1..40}; do
    sleep 3
    kill -0 "$program" 2>/dev/null || { cat launcher.txt >&2; kill "$server"; return 4; }
    [[ ! -f launcher.png ]] || mv launcher.png before.png
    /usr/bin/python3 -B "$root/tests/launcher/screenshot.py" display launcher.png
    [[ $(colours launcher.png) -lt 200 ]] || ! cmp -s before.png launcher.png || break
  done
  kill "$program" "$server"
  [[ $tries -lt 40 ]] || { echo "developer/figures: the launcher shows no images in two minutes" >&2; return 4; }
  wait "$program" "$server" 2>/dev/null || true
  small launcher.png "$figures/launcher.png"
}

# The window of pipelines/training-day, at the end of the day that its test plays. Its reports run only when nothing else does:
# on a busy machine they take minutes.
make_training_day() {
  build programs
  local bin=${ACUS_BIN:-$root/build/bin}
  quietly env ACUS_BIN="$bin" INPUTS="$PWD/inputs" bash "$root/tests/cli/make_inputs.sh" "$root"
  quietly env ACUS_BIN="$bin" INPUTS="$PWD/inputs" WAIT_S=1200 bash "$root/tests/launcher/day.sh" "$root" "$PWD/day"
  cp day/next_morning.png "$figures/training_day.png"
}

make_accuracy() { quietly "$root/developer/accuracy-and-time" --from-stored; }

make_wings() {
  build programs
  "$root/developer/module-graph"
}

make_drawings() { :; }
