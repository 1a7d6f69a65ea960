# shellcheck shell=bash disable=SC2154
# Sourced by pipelines/live-session: a workplace from a prepared patient or a CT. Needs its functions
# choose, ask, stop and tell, its $root and its $workplace.

# numbers_of TEXT: three finite numbers "L,P,S" in mm, with blanks between them; fails otherwise.
numbers_of() {
  awk -v text="$1" 'BEGIN {
    n = split(text, x, /[ ,]+/)
    if (n != 3) exit 1
    for (i = 1; i <= 3; ++i) if (x[i] !~ /^[-+]?[0-9]+(\.[0-9]*)?$/ || x[i] < -2000 || x[i] > 2000) exit 1
    print x[1], x[2], x[3]
  }'
}

# point_of FILE NAME: a point of a landmarks CSV (name,x_mm,y_mm,z_mm).
point_of() {
  awk -F, -v name="$2" '$1 == name { print $2, $3, $4; found = 1; exit } END { exit !found }' "$1"
}

# direction_of WORD: the unit vector, LPS, from that side of the patient into the body.
direction_of() {
  case $1 in
    anterior) echo "0 1 0" ;;
    posterior) echo "0 -1 0" ;;
    left) echo "-1 0 0" ;;
    right) echo "1 0 0" ;;
    superior) echo "0 0 -1" ;;
    inferior) echo "0 0 1" ;;
    *) return 1 ;;
  esac
}

# hands_at POINT DIRECTION: two virtual hands as JSON. The needle is 30 mm before the point and looks
# along the direction; the probe is 25 mm beside it, its image plane holds the needle.
hands_at() {
  awk -v point="$1" -v direction="$2" '
    function pose(name, x, y, z,   q0, q1, q2, q3, s, i) {
      # Columns x, y, z of the rotation as a quaternion: the largest component first.
      s = 1 + x[1] + y[2] + z[3]
      if (s > 0.5) { q0 = sqrt(s) / 2; q1 = (y[3] - z[2]) / (4 * q0); q2 = (z[1] - x[3]) / (4 * q0); q3 = (x[2] - y[1]) / (4 * q0) }
      else if (x[1] >= y[2] && x[1] >= z[3]) { q1 = sqrt(1 + x[1] - y[2] - z[3]) / 2; q0 = (y[3] - z[2]) / (4 * q1); q2 = (x[2] + y[1]) / (4 * q1); q3 = (z[1] + x[3]) / (4 * q1) }
      else if (y[2] >= z[3]) { q2 = sqrt(1 - x[1] + y[2] - z[3]) / 2; q0 = (z[1] - x[3]) / (4 * q2); q1 = (x[2] + y[1]) / (4 * q2); q3 = (y[3] + z[2]) / (4 * q2) }
      else { q3 = sqrt(1 - x[1] - y[2] + z[3]) / 2; q0 = (x[2] - y[1]) / (4 * q3); q1 = (z[1] + x[3]) / (4 * q3); q2 = (y[3] + z[2]) / (4 * q3) }
      printf "  {\"name\": \"%s\", \"driver\": \"virtual_hand\",\n", name
      printf "   \"reference_from_device\": {\"translation_mm\": [%.6f, %.6f, %.6f],\n", at[1], at[2], at[3]
      printf "     \"quaternion_wxyz\": [%.12f, %.12f, %.12f, %.12f]}}", q0, q1, q2, q3
    }
    BEGIN {
      split(point, p, " "); split(direction, d, " ")
      # Across the direction, towards the head; or to the left where the needle comes from there.
      split("0 0 1", a, " ")
      if (d[3] * d[3] > 0.9) split("1 0 0", a, " ")
      along = a[1] * d[1] + a[2] * d[2] + a[3] * d[3]
      for (i = 1; i <= 3; ++i) { x[i] = a[i] - along * d[i]; n += x[i] * x[i] }
      for (i = 1; i <= 3; ++i) x[i] /= sqrt(n)
      # Of the needle z is the direction, of the probe y.
      y[1] = d[2] * x[3] - d[3] * x[2]; y[2] = d[3] * x[1] - d[1] * x[3]; y[3] = d[1] * x[2] - d[2] * x[1]
      for (i = 1; i <= 3; ++i) at[i] = p[i] - 30 * d[i]
      pose("right", x, y, d)
      printf ",\n"
      w[1] = x[2] * d[3] - x[3] * d[2]; w[2] = x[3] * d[1] - x[1] * d[3]; w[3] = x[1] * d[2] - x[2] * d[1]
      for (i = 1; i <= 3; ++i) at[i] = p[i] - 30 * d[i] + 25 * x[i]
      pose("left", x, d, w)
      printf "\n"
    }'
}

# find_patient: sets ct, labels, corridor and, of a mannequin, markers from --patient or --ct.
find_patient() {
  corridor='' markers='' recorded=''
  if [[ -z $patient && -z $ct ]]; then
    patient=$(ask "Folder of the prepared patient, or a CT (DICOM folder, .nrrd, .nii, .mha)") ||
      stop "No patient was given." 2
  fi
  if [[ -n $patient && ! -f $patient/ct.nrrd ]]; then
    [[ -e $patient ]] || stop "There is no patient $patient." 2
    ct=$patient patient=''
  fi
  if [[ -n $patient ]]; then
    ct=$patient/ct.nrrd
    [[ -n $labels || ! -f $patient/labels.seg.nrrd ]] || labels=$patient/labels.seg.nrrd
    [[ ! -f $patient/corridor_ct.csv ]] || corridor=$patient/corridor_ct.csv
    recorded=$(compgen -G "$patient/sessions/*/needle.csv" | head -n 1) || true
    [[ ! -f $patient/markers_ct.csv || ! -f $patient/markers_mannequin.csv ]] || markers=$patient
  fi
  [[ -e $ct ]] || stop "There is no CT $ct." 2
  ct=$(realpath "$ct")
  [[ -z $labels ]] || labels=$(realpath "$labels") || stop "There is no label map $labels." 2
}

# take_corridor: target, and point and direction of the hands, from the file $corridor.
take_corridor() {
  target=$(point_of "$corridor" target) || stop "$corridor has no point named target." 3
  point=$(point_of "$corridor" entry) || stop "$corridor has no point named entry." 3
  direction=$(awk -v a="$point" -v b="$target" 'BEGIN {
    split(a, p, " "); split(b, q, " ")
    for (i = 1; i <= 3; ++i) { d[i] = q[i] - p[i]; n += d[i] * d[i] }
    if (n < 1) exit 1
    print d[1] / sqrt(n), d[2] / sqrt(n), d[3] / sqrt(n) }') ||
    stop "$corridor: entry and target are less than 1 mm apart." 3
}

# plan_target: a free path to the named target or through the window, once there is a label map.
plan_target() {
  local map=$labels options=()
  [[ $map == /* ]] || map=$workplace/$map
  [[ -z $target ]] || options+=("--target=$target")
  [[ -z $window ]] || options+=("--window=$window")
  acus-phantom scene "$map" "${options[@]}" --quiet -o "$workplace/plan" >&2 ||
    stop "No path of the needle was found; the message above says why."
  corridor=$workplace/plan/corridor_ct.csv
  take_corridor
}

# find_target: sets target, and point and direction of the hands; or is_planned, for plan_target.
find_target() {
  local given=$target
  is_planned=''
  if [[ -n $window || $given =~ ^[a-z_]+$ || $given =~ ^[A-Za-z][A-Za-z0-9_]*-[A-Za-z] ]]; then
    is_planned=1
    return
  fi
  if [[ -z $given && -n $corridor ]]; then
    take_corridor
    return
  fi
  corridor=''
  [[ -n $given ]] || given=$(ask "Target in the CT: L,P,S in mm, as 3D Slicer shows them with R and A negated") ||
    stop "No target was given." 2
  target=$(numbers_of "$given") ||
    stop "--target must be three numbers L,P,S in mm, within 2 m, such as 12.5,-40,830, a tissue, such as liver, or two vertebrae, such as L3-L4; got '$given'." 2
  [[ -n $from ]] || from=$(choose "The needle comes from" anterior posterior left right superior inferior) ||
    stop "No side was chosen." 2
  direction=$(direction_of "$from") ||
    stop "--from must be anterior, posterior, left, right, superior or inferior, got '$from'." 2
  # 150 mm before the target, which is outside of most patients.
  point=$(awk -v t="$target" -v d="$direction" 'BEGIN {
    split(t, x, " "); split(d, y, " "); print x[1] - 150 * y[1], x[2] - 150 * y[2], x[3] - 150 * y[3] }')
}

# choose_preset TITLE KIND VALUE: the value if it is a preset of the kind, or one that is chosen.
choose_preset() {
  local title=$1 kind=$2 value=$3 file names=()
  for file in "$root/configs/$kind"/*.json; do names+=("$(basename "$file" .json)"); done
  if [[ -z $value ]]; then
    choose "$title" "${names[@]}"
  else
    [[ -f $root/configs/$kind/$value.json ]] || {
      echo "${names[*]}"
      return 1
    }
    echo "$value"
  fi
}

# The preset with its patient in place.
scenario_of_patient() {
  local parts="\"ct\": \"$ct\", \"labels\": \"$labels\", \"corridor\": \"target_ct.csv\""
  [[ ! -d $workplace/registration ]] ||
    parts+=", \"ct_from_reference_file\": \"registration/ct_from_reference.tfm\""
  awk -v patient="$parts" '
    /^\/\/ The patient comes from the command line/ { next }
    /"patient": \{\},/ { print "  \"patient\": {" patient "},"; found = 1; next }
    { print }
    END { exit !found }' "$root/configs/scenarios/$scenario.json"
}

# How fast this machine is with the new workplace: three seconds with virtual hands.
check_speed() {
  local folder steps late rate
  folder=$(mktemp -d)
  echo "Trying the workplace for three seconds ..." >&2
  if ! acus-live "$workplace/scenario.json" --devices "$1" --headless --duration 3 --quiet \
    -o "$folder/session" >/dev/null; then
    rm -rf "$folder"
    stop "The workplace does not start; the message above says why."
  fi
  number() { grep -o "\"$1\": *[0-9.e+-]*" "$folder/session/summary.json" | head -n 1 | sed 's/.*: *//'; }
  late=$(number missed_by_computation)
  steps=$(awk 'END { print NR - 1 }' "$folder/session/needle.csv")
  rate=$(number per_s)
  rm -rf "$folder"
  printf 'This machine: %.1f images a second of 30, %d of %d steps late.\n' "$rate" "$late" "$steps" >&2
  if awk -v rate="$rate" -v late="$late" -v steps="$steps" 'BEGIN { exit !(rate < 25 || late > steps / 100) }'; then
    tell "Acus" "The model $scenario is too slow for this machine. Make the workplace with another --model, such as lumbar_puncture or liver_biopsy; acus-tradeoff finds settings for a machine."
  fi
}

# The workplace of a patient of yours; what no option says is asked.
make_workplace_of_patient() {
  [[ ! -e $workplace || -z $(ls -A "$workplace") ]] ||
    stop "$workplace is there and not empty; give --new another folder, or move it away." 2
  find_patient
  find_target
  local given
  given=$devices devices=$(choose_preset "Devices" devices "$devices") ||
    stop "--devices must be one of: $devices; got '$given'." 2
  given=$exercise exercise=$(choose_preset "Exercise" exercises "$exercise") ||
    stop "--exercise must be one of: $exercise; got '$given'." 2
  given=$scenario scenario=$(choose_preset "Model of tissue and ultrasound" scenarios "$scenario") ||
    stop "--model must be one of: $scenario; got '$given'." 2
  # Whole or not at all.
  trap 'rm -rf "$workplace"' EXIT
  mkdir -p "$workplace/exercises" "$workplace/sessions"
  if [[ -z $labels ]]; then
    echo "Finding tissues in the CT ..." >&2
    acus-segment "$ct" --quiet -o "$workplace/segmentation" >/dev/null || stop "The CT cannot be segmented; see above."
    labels=segmentation/labels.seg.nrrd
  fi
  [[ -z $is_planned ]] || plan_target
  # Tools of a real tracker are where the mannequin is; virtual hands may be in the CT's frame.
  if [[ -n $markers && ($devices != virtual || -n $recorded) ]]; then
    acus-register --quiet --from "$markers/markers_mannequin.csv" --to "$markers/markers_ct.csv" \
      -o "$workplace/registration" >/dev/null || stop "The mannequin cannot be registered; see above."
  fi
  {
    echo "name,x_mm,y_mm,z_mm"
    [[ -z $corridor ]] || echo "entry,${point// /,}"
    echo "target,${target// /,}"
  } >"$workplace/target_ct.csv"
  scenario_of_patient >"$workplace/scenario.json" ||
    stop "The preset scenarios/$scenario.json has a patient of its own; choose another --model." 2
  sed 's#"scenario": *"[^"]*"#"scenario": "../scenario.json"#' \
    "$root/configs/exercises/$exercise.json" >"$workplace/exercises/$exercise.json"
  {
    echo '// Two virtual hands, steered by mouse and keyboard.'
    echo '{"format": "acus-devices/1", "name": "virtual hands", "devices": ['
    if [[ -d $workplace/registration && -n $recorded ]]; then
      hand right needle "$(dirname "$recorded")" && echo ',' && hand left probe "$(dirname "$recorded")"
    else
      hands_at "$point" "$direction"
    fi
    echo '], "needle": {"device": "right"}, "probe": {"device": "left"}}'
  } >"$workplace/virtual_hands.json"
  if [[ $devices == virtual ]]; then
    mv "$workplace/virtual_hands.json" "$workplace/devices.json"
    check_speed "$workplace/devices.json"
  else
    cp "$root/configs/devices/$devices.json" "$workplace/devices.json"
    check_speed "$workplace/virtual_hands.json"
  fi
  trap - EXIT
  echo "Start it with: pipelines/live-session $workplace" >&2
}
