# shellcheck shell=bash disable=SC2154 # Names of pipelines/papers.
# What a departure from a paper does to the result: each session is replayed as the preset has it and as printed.
# Sourced by pipelines/papers --departures; each function runs in its folder and writes departures.csv.

# shellcheck disable=SC2034 # fact writes there.
facts_file=departures.csv
# values RUN COLUMN [TABLE]: of forces.csv, a line for each sample.
values() {
  local table=$1/${3:-forces.csv}
  awk -F, -v name="$2" 'NR == 1 { for (i = 1; i <= NF; ++i) if ($i == name) c = i; if (!c) exit 1; next } { print $c }' "$table" ||
    fail "$table has no column $2" 4
}
largest() { values "$1" "$2" | awk '{ v = $1 < 0 ? -$1 : $1; if (v > m) m = v } END { printf "%.4g", m }'; }
# apart RUN OTHER COLUMN [TABLE]: the largest difference of a column at the same sample.
apart() { paste <(values "$1" "$3" "${4:-forces.csv}") <(values "$2" "$3" "${4:-forces.csv}") | awk '{ d = $1 - $2; if (d < 0) d = -d; if (d > m) m = d } END { printf "%.3g", m }'; }
# greys_apart RUN OTHER: mean difference of their stills in grey levels, of all and of the one that differs most.
greys_apart() {
  local image
  for image in "$1"/event_*.png; do
    [[ ! -s $2/${image##*/} ]] || /usr/bin/python3 "$root/pipelines/paper_pages/sheet.py" --difference "$image" "$2/${image##*/}"
  done | awk '{ s += $1; ++n; if ($1 > m) m = $1 } END { if (!n) exit 1; printf "%.3g %.3g %d", s / n, m, n }'
}
grey_facts() { # KEY RUN OTHER
  local numbers
  read -ra numbers <<<"$(greys_apart "$2" "$3")"
  fact "$1_grey" "${numbers[0]}"
  fact "$1_most_grey" "${numbers[1]}"
  fact "$1_stills" "${numbers[2]}"
}
stills_only=(--set /effects/view_3d=null --no-film)

departures_augmented_2010() {
  cp "$root/configs/phantoms/lumbar.json" patient.json
  withdrawn_before_turning patient.json
  patient lumbar patient --config patient.json
  local session=patient/sessions/lumbar_puncture update
  local common=(--ct patient/ct.nrrd --set "/patient/corridor=$PWD/patient/corridor_ct.csv")
  for update in restricted full; do
    replay update_$update patient $session "${common[@]}" "${no_images[@]}" --set /effects/tissue/fe_2d/update=$update \
      --set /effects/tissue/fe_2d/turned_planes=0
    fact update_${update}_us "$(awake_us update_$update "tissue contact")"
  done
  fact update_apart_n "$(apart update_restricted update_full force_axial_n)"
  local threshold=0.9
  sed "s/^{/{\"boosted_reflection\": $threshold,/" "$root/configs/acoustics/hu_2010.json" >boosted.json
  replay images patient $session "${common[@]}" "${stills_only[@]}"
  replay images_boosted patient $session "${common[@]}" "${stills_only[@]}" --set "/effects/ultrasound/acoustics=$PWD/boosted.json"
  fact boosted $threshold
  grey_facts boosted images images_boosted
  probe_by_finite_elements
}
# The same probe by finite elements in three dimensions: on a mesh of the patient that is condensed below it; five
# minutes of CPU and 5 GB. The beam of the needle is not in it.
probe_by_finite_elements() {
  local press_mm=8
  sed 's/"finest_mm": [0-9.]*, "nodes": [0-9]*/"finest_mm": 4, "nodes": 20000/' "$root/configs/meshes/tissue.json" >mesh.json
  acus-mesh patient/labels.seg.nrrd --config mesh.json --corridor patient/corridor_ct.csv --probe-at="$(probe_at 7.6)" --condense -o mesh \
    --overwrite --quiet >mesh.txt
  shortened patient/sessions/lumbar_puncture scan 8
  local probe=(--ct patient/ct.nrrd --set "/patient/corridor=$PWD/patient/corridor_ct.csv" --set "/effects/probe_force/press_mm=$press_mm")
  replay probe_vidal patient scan "${probe[@]}" "${no_images[@]}"
  replay probe_elements patient scan "${probe[@]}" "${no_images[@]}" --set "/patient/mesh=$PWD/mesh" --set /effects/needle=null \
    --set '/effects/tissue={"model": "fe_3d", "fe_3d": {"probe_contact": true}}' --set /effects/probe_force/model=tissue
  fact probe_mesh_nodes "$(sed -n 's/^Mesh: \([0-9]*\) nodes.*/\1/p' mesh.txt)"
  fact probe_press_mm $press_mm
  fact probe_vidal_n "$(number probe_vidal "largest probe force")"
  fact probe_elements_n "$(number probe_elements "largest probe force")"
}
# probe_at SECONDS: where its face is then, x,y,z in CT space.
probe_at() {
  /usr/bin/python3 -B - "$1" <<'PYTHON'
import csv, json, sys
reference_from_ct = json.load(open("patient/truth.json"))["reference_from_ct"]
row = next(r for r in csv.DictReader(open("patient/sessions/lumbar_puncture/probe.csv")) if float(r["time_s"]) >= float(sys.argv[1]))
offset = [float(row[f"{axis}_mm"]) - reference_from_ct[k][3] for k, axis in enumerate("xyz")]
print(",".join(f"{sum(reference_from_ct[k][c] * offset[k] for k in range(3)):.1f}" for c in range(3)))
PYTHON
}

# aside SESSION FOLDER MM: the session with its probe moved along its face.
aside() {
  rm -rf "$2"
  cp -r "$1" "$2"
  awk -F, -v OFS=, -v mm="$3" 'NR == 1 { print; next } {
    w = $5; x = $6; y = $7; z = $8
    $2 += mm * (1 - 2 * (y * y + z * z)); $3 += mm * 2 * (x * y + w * z); $4 += mm * 2 * (x * z - w * y); print
  }' "$1/probe.csv" >"$2/probe.csv"
}

departures_vidal_2008() {
  probe_on_bone
  means
  needle_on_bone
}
# The probe of a liver biopsy, moved aside until it is above a rib.
probe_on_bone() {
  patient liver patient
  local form press_mm=23 aside_mm=14
  aside patient/sessions/liver_biopsy over_a_rib $aside_mm
  fact probe_press_mm $press_mm
  for form in two_springs printed; do
    sed "s/\"vidal\": {/\"vidal\": {\"probe\": {\"form\": \"$form\"}, /" "$root/configs/forces/vidal.json" >probe_$form.json
    replay probe_$form patient over_a_rib --ct patient/ct.nrrd "${no_images[@]}" --set /effects/needle_force=null --set /needle=null \
      --set /effects/probe_force/press_mm=$press_mm --set "/effects/probe_force/table=$PWD/probe_$form.json"
    fact probe_${form}_n "$(number probe_$form "largest probe force")"
    fact probe_${form}_bone_s "$(number probe_$form "probe time on bone")"
  done
  fact probe_apart_n "$(apart probe_two_springs probe_printed force_n probe_forces.csv)"
}
# Eq. 3: the mean, in the kidney.
means() {
  patient kidney kidney
  local run
  sed 's/"vidal": {/"vidal": {"passive_average": false,/' "$root/configs/forces/vidal.json" >mean_printed.json
  for run in passive printed; do
    replay mean_$run kidney kidney/sessions/kidney_puncture --ct kidney/ct.nrrd "${no_images[@]}" --set /effects/probe_force=null \
      --set "/effects/needle_force/table=$([[ $run == passive ]] && echo forces/vidal.json || echo "$PWD/mean_printed.json")"
    fact mean_${run}_n "$(number mean_$run "largest axial force")"
    fact mean_${run}_rms_n "$(number mean_$run "RMS axial force while inserted")"
  done
}
# Eq. 7 and 8: a needle that is turned aside, and meets a vertebra.
needle_on_bone() {
  patient lumbar lumbar
  local run
  sed 's/"vidal": {/"vidal": {"passive_average": false,/; s/"damping_n_s_per_mm": 0.004/"damping_n_s_per_mm": 0/' \
    "$root/configs/forces/vidal.json" >bone_printed.json
  spine() { # RUN TABLE
    replay "$1" lumbar lumbar/sessions/lumbar_puncture --ct lumbar/ct.nrrd "${no_images[@]}" --set /effects/probe_force=null \
      --set "/effects/needle_force/table=$2"
  }
  spine damped forces/vidal.json
  spine printed "$PWD/bone_printed.json"
  fact bone_damped_s "$(number damped "time on bone")"
  for run in damped printed; do
    fact bone_${run}_n "$(largest $run bone_n)"
    fact guidance_${run}_n "$(number $run "largest lateral force")"
  done
  fact bone_apart_n "$(apart damped printed bone_n)"
  fact guidance_apart_n "$(apart damped printed lateral_n)"
}

departures_alamilla_2021() {
  coarse shoulder 2 patient.json
  patient shoulder patient --config patient.json
  local session=patient/sessions/shoulder run
  sed 's/"format": "acus-forces\/1",/&\n  "alamilla": {"form": "printed"},/' "$root/configs/forces/alamilla.json" >bone_printed.json
  replay as_it_is patient $session "${stills_only[@]}"
  replay functions_printed patient $session "${stills_only[@]}" --set /effects/tissue/displacement_functions/form=printed
  replay pixels patient $session "${stills_only[@]}" --set /effects/ultrasound/alamilla_2021/deformation=pixels
  replay still patient $session "${stills_only[@]}" --set /effects/tissue=null
  replay bone_printed patient $session "${no_images[@]}" --set /effects/tissue=null \
    --set "/effects/needle_force/table=$PWD/bone_printed.json"
  grey_facts functions as_it_is functions_printed
  grey_facts pixels as_it_is pixels
  grey_facts deformed as_it_is still
  for run in as_it_is bone_printed; do fact ${run}_n "$(number $run "largest axial force")"; done
  fact on_bone_n "$(largest as_it_is bone_n)"
  fact on_bone_printed_n "$(largest bone_printed bone_n)"
  sed 's/"format": "acus-forces\/1",/&\n  "alamilla": {"lugre": {"sigma1_s_per_mm": 0.879}},/' "$root/configs/forces/alamilla.json" >sigma_printed.json
  replay sigma_printed patient $session "${no_images[@]}" --set /effects/tissue=null \
    --set "/effects/needle_force/table=$PWD/sigma_printed.json"
  fact sigma_apart_n "$(apart as_it_is sigma_printed force_axial_n)"
}

departures_fortmeier_2016() {
  coarse liver_ptc 2 patient.json
  patient liver_ptc patient --config patient.json
  local session=patient/sessions/liver_ptc run
  acus-breathing --single patient/ct.nrrd --labels patient/labels.seg.nrrd --model surrogate --resolution 32 -o motion --overwrite --quiet \
    >motion.txt
  local common=(--ct patient/ct.nrrd --set "/effects/breathing/motion=$PWD/motion" "${no_images[@]}")
  replay as_it_is patient $session "${common[@]}"
  replay line_7 patient $session "${common[@]}" --set /effects/breathing/tools=printed
  replay base patient $session "${common[@]}" --set /effects/needle/hand/form=printed
  for run in as_it_is line_7 base; do
    fact ${run}_axial_n "$(number $run "largest axial force")"
    fact ${run}_lateral_n "$(number $run "largest lateral force")"
    fact ${run}_bone_contacts "$(number $run "bone contacts")"
    fact ${run}_depth_mm "$(largest $run depth_mm)"
  done
  fact base_apart_n "$(apart as_it_is base lateral_n)"
}
