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

# The workplace of a patient of yours; what no option says is asked.
make_workplace_of_patient() {
  require_new_folder
  find_patient
  find_target
  local given recorded_hands=()
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
  [[ ! -d $workplace/registration || -z $recorded ]] || recorded_hands=("--session=$(dirname "$recorded")")
  write_workplace "--model=$scenario" "--exercise=$exercise" "--devices=$devices" "--ct=$ct" "--labels=$labels" \
    "--point=$point" "--direction=$direction" "${recorded_hands[@]}"
  trap - EXIT
}
