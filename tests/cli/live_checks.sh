#!/usr/bin/env bash
# Sessions of acus-live that take more than one command. Usage: live_checks.sh replay|signal|kill
set -euo pipefail
session=(acus-live "$INPUTS/scenario.json" --devices devices/virtual.json --headless
  --hand "$INPUTS/session" -o s --quiet --set "/patient/ct=$INPUTS/ct.nrrd"
  --set "/patient/labels=$INPUTS/labels.seg.nrrd"
  --set "/patient/ct_from_reference_file=$INPUTS/ct_from_reference.tfm")
replay() {
  acus-replay "$INPUTS/scenario.json" s --quiet --ct "$INPUTS/ct.nrrd" \
    --labels "$INPUTS/labels.seg.nrrd" --transform "$INPUTS/ct_from_reference.tfm" -o r \
    --set /effects/ultrasound=null --set /effects/ct_slice=null >/dev/null
}
# The session until it has recorded for a second; its id is in $child.
begin() {
  "${session[@]}" >out &
  child=$!
  until [[ -s s/needle.csv && $(wc -l <s/needle.csv) -gt 1000 ]]; do sleep 0.1; done
}
case $1 in
  replay)
    "${session[@]}" --duration 3 >out
    replay
    cmp s/forces.csv r/forces.csv && echo same
    ;;
  signal)
    begin
    kill -TERM "$child"
    wait "$child"
    replay
    cmp s/forces.csv r/forces.csv && echo same
    cat s/summary.json
    ;;
  kill)
    begin
    kill -KILL "$child"
    wait "$child" || true
    replay
    # What was felt is written before the pose that it belongs to: it may reach further.
    head -c "$(stat -c %s r/forces.csv)" s/forces.csv | cmp - r/forces.csv && echo same
    ;;
esac
