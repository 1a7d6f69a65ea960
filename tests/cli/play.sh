# shellcheck shell=bash
# Sourced: the demonstration of a workplace is played from start to report.

# play_demonstration WORKPLACE RUN: in virtual time; its exercise must be done to the end.
play_demonstration() {
  local work=$1 run=$2 exercise hand
  exercise=$(echo "$work"/exercises/*.json)
  hand="$work/patient/demonstration_$(basename "$exercise" .json)"
  [[ -d $hand ]] || hand="$work/patient/demonstration"
  # A camera has a clock of its own; the hands need none.
  python3 -c 'import json, sys
devices = json.load(open(sys.argv[1]))
devices.pop("camera", None)
json.dump(devices, open(sys.argv[2], "w"))' "$work/devices.json" "$run.devices.json"
  acus-live "$work/scenario.json" --devices "$run.devices.json" --headless --virtual-time --quiet \
    --hand "$hand" --exercise "$exercise" -o "$run.session" --overwrite >"$run.live.txt"
  # The checklist looks at the image: few are enough.
  acus-replay "$work/scenario.json" "$run.session" --exercise "$exercise" --trainee demonstration --quiet \
    --set /image_rate_hz=0.5 --no-film --no-sequence --png none -o "$run" --overwrite >"$run.replay.txt"
  cmp "$run.session/forces.csv" "$run/forces.csv" || fail "the replay of $run has other forces" 4
  python3 "$root/tests/cli/check_play.py" "$run" || fail "the demonstration of $run fails its exercise" 4
}
