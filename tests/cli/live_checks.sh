#!/usr/bin/env bash
# Sessions of acus-live that take more than one command.
# Usage: live_checks.sh replay|signal|kill|images|images_cut|virtual_time
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
# The session of this process and another that makes its images, with who looks on. Its devices file
# is d.json; what was seen is in seen/, one file for each image.
begin_images() {
  local patient=(--set "/patient/ct=$INPUTS/ct.nrrd" --set "/patient/labels=$INPUTS/labels.seg.nrrd"
    --set "/patient/ct_from_reference_file=$INPUTS/ct_from_reference.tfm")
  acus-live "$INPUTS/scenario.json" --devices devices/virtual.json "${patient[@]}" \
    --make-images 0 --duration 60 --quiet >second &
  second=$!
  until grep -q listening second; do sleep 0.1; done
  local from out
  from=$(sed -n 's/listening on port //p' second)
  out=$(python3 -c 'import socket; s = socket.create_server(("127.0.0.1", 0)); print(s.getsockname()[1])')
  sed "s/\"needle\":/\"images_from\": {\"port\": $from}, \"send_out\": {\"port\": $out}, &/" \
    "$(dirname "$0")/../../configs/devices/virtual.json" >d.json
  python3 "$(dirname "$0")/received_images.py" "$out" seen &
  looker=$!
  acus-live "$INPUTS/scenario.json" --devices d.json --headless --hand "$INPUTS/session" -o s \
    --quiet "${patient[@]}" --duration "$1" >out &
  child=$!
}
case $1 in
  replay)
    "${session[@]}" --duration 3 >out
    replay
    cmp s/forces.csv r/forces.csv && echo same
    ;;
  virtual_time)
    for name in one two; do
      "${session[@]}" --virtual-time --overwrite
      mv s "$name"
    done
    cmp one/needle.csv two/needle.csv && cmp one/forces.csv two/forces.csv
    # To the end of what is followed.
    [[ $(tail -n 1 one/needle.csv | cut -d. -f1) == $(tail -n 1 "$INPUTS/session/needle.csv" | cut -d. -f1) ]] && echo same
    ;;
  signal)
    begin
    kill -TERM "$child"
    wait "$child"
    replay
    cmp s/forces.csv r/forces.csv && echo same
    cat s/summary.json
    ;;
  images)
    begin_images 4
    wait "$child"
    kill "$second"
    wait "$looker"
    acus-replay "$INPUTS/scenario.json" s --quiet --ct "$INPUTS/ct.nrrd" \
      --labels "$INPUTS/labels.seg.nrrd" --transform "$INPUTS/ct_from_reference.tfm" -o r \
      --set /image_rate_hz=30 --no-film --png none >/dev/null
    cmp s/forces.csv r/forces.csv && echo same
    python3 "$(dirname "$0")/received_images.py" --compare seen r/images.igs.mha
    cat out second
    ;;
  images_cut)
    begin_images 4
    until [[ -d seen && $(find seen -type f | wc -l) -gt 15 ]]; do sleep 0.1; done
    kill -KILL "$second"
    wait "$child"
    wait "$looker"
    replay
    cmp s/forces.csv r/forces.csv && echo same
    cat out s/summary.json
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
