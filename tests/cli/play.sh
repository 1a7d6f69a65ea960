# shellcheck shell=bash
# Sourced: the demonstration of a workplace, and a first session in it, are played from start to report.

# no_camera WORKPLACE FILE: its devices without a camera, which has a clock of its own; the hands need none.
no_camera() {
  python3 -c 'import json, sys
devices = json.load(open(sys.argv[1]))
devices.pop("camera", None)
json.dump(devices, open(sys.argv[2], "w"))' "$1/devices.json" "$2"
}

# report_of WORKPLACE RUN TRAINEE [EXPECTED_WARNING]: of RUN.session; its exercise must be done to the end.
report_of() {
  local work=$1 run=$2 trainee=$3 expected=${4:-}
  # The checklist looks at the image: few are enough.
  acus-replay "$work/scenario.json" "$run.session" --exercise "$work"/exercises/*.json --trainee "$trainee" --quiet \
    --set /image_rate_hz=0.5 --no-film --no-sequence --png none --labels-in-image png -o "$run" --overwrite >"$run.replay.txt"
  cmp "$run.session/forces.csv" "$run/forces.csv" || fail "the replay of $run has other forces" 4
  /usr/bin/python3 -B "$root/tests/cli/check_play.py" "$run" "$expected" || fail "$run fails its exercise" 4
}

# play_demonstration WORKPLACE RUN: in virtual time.
play_demonstration() {
  local work=$1 run=$2 exercise hand
  exercise=$(echo "$work"/exercises/*.json)
  hand="$work/patient/demonstration_$(basename "$exercise" .json)"
  [[ -d $hand ]] || hand="$work/patient/demonstration"
  no_camera "$work" "$run.devices.json"
  acus-live "$work/scenario.json" --devices "$run.devices.json" --headless --virtual-time --quiet \
    --hand "$hand" --exercise "$exercise" -o "$run.session" --overwrite >"$run.live.txt"
  report_of "$work" "$run" demonstration
}

# play_first_session WORKPLACE RUN [EXPECTED_WARNING]: somebody does what the window says, in virtual time, within five minutes.
play_first_session() {
  local work=$1 run=$2 expected=${3:-}
  no_camera "$work" "$run.devices.json"
  "$ACUS_BIN/../tests/first_session" "$work/scenario.json" "$run.devices.json" "$work"/exercises/*.json \
    "$run.session" --overwrite >"$run.txt" || { cat "$run.txt"; fail "$run: what the window says does not lead to the end" 4; }
  report_of "$work" "$run" newcomer "$expected"
}
