#!/usr/bin/env bash
# Two programs that write one folder. Usage: folder_in_use.sh without_overwrite|recording
set -uo pipefail
fail() { echo "FAILED: $*"; exit 1; }
case $1 in
  without_overwrite)
    # Both begin before the folder is there: one puts it in place, the other is refused.
    for i in 1 2; do
      acus-replay "$INPUTS/scenario.json" "$INPUTS/session" --ct "$INPUTS/ct.nrrd" --labels \
        "$INPUTS/labels.seg.nrrd" --transform "$INPUTS/ct_from_reference.tfm" --quiet -o run \
        --trainee "$i" >/dev/null 2>"err$i" &
      ids[i]=$!
    done
    codes=
    for i in 1 2; do wait "${ids[i]}"; codes+=" $?"; done
    [[ $codes == " 0 3" || $codes == " 3 0" ]] || fail "exit codes$codes"
    cat err1 err2
    grep -q 'exists already' err1 err2 || fail "no message"
    ;;
  recording)
    session=(acus-live "$INPUTS/scenario.json" --devices devices/virtual.json --headless
      --hand "$INPUTS/session" -o s --quiet --overwrite --set "/patient/ct=$INPUTS/ct.nrrd"
      --set "/patient/labels=$INPUTS/labels.seg.nrrd"
      --set "/patient/ct_from_reference_file=$INPUTS/ct_from_reference.tfm")
    "${session[@]}" >/dev/null &
    first=$!
    until [[ -s s/needle.csv && $(wc -l <s/needle.csv) -gt 500 ]]; do sleep 0.1; done
    file=$(stat -c %i s/needle.csv)
    "${session[@]}" --duration 1 >/dev/null 2>err
    [[ $? == 3 ]] || fail "a second session recorded into the folder"
    grep -q 'another program is writing this folder' err || fail "$(cat err)"
    acus-replay "$INPUTS/scenario.json" "$INPUTS/session" -o s --overwrite >/dev/null 2>err
    [[ $? == 3 ]] || fail "another program replaced the folder"
    grep -q 'another program is writing this folder' err || fail "$(cat err)"
    kill -TERM "$first"
    wait "$first" || fail "the first session"
    [[ $(stat -c %i s/needle.csv) == "$file" ]] || fail "the recording was replaced"
    # Afterwards it may be replaced.
    "${session[@]}" --duration 1 >/dev/null || fail "the folder stays locked"
    ;;
esac
echo refused
