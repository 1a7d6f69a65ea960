#!/usr/bin/env bash
# A day in the launcher's window, by mouse and keyboard: three trainees, consent and questionnaires, a
# session repeated, one discarded, one that fails, and one at which the plug is pulled; then what the
# curriculum and the study make of it. Screenshots are left in the folder.
# Usage: day.sh SOURCE_FOLDER FOLDER
set -euo pipefail
source=$1 folder=$2
export PATH="$ACUS_BIN:$PATH" LANG=C.UTF-8
fail() { echo "FAILED: $1"; [[ ! -f work/launcher.log ]] || tail -n 20 work/launcher.log; exit 1; }

rm -rf "$folder"
mkdir -p "$folder/fb"
cd "$folder"

# A workplace of the small patient.
mkdir -p work/exercises work/sessions work/patient/sessions
cp -rL "$INPUTS/session" work/patient/sessions/insertion
cp -rL "$INPUTS/landmark_fit" work/registration
grep -v '"patient"' "$INPUTS/scenario.json" | sed "0,/{/s##{ \"patient\": {\"ct\": \"$INPUTS/ct.nrrd\", \
\"labels\": \"$INPUTS/labels.seg.nrrd\", \"corridor\": \"$INPUTS/corridor_ct.csv\", \
\"ct_from_reference_file\": \"registration/ct_from_reference.tfm\"},#" >work/scenario.json
cp "$source/configs/devices/virtual.json" work/devices.json
# The day is tried, not the hand: its scripted puncture may miss the target.
for name in first second; do
  sed -e "s#\"name\": *\"[^\"]*\"#\"name\": \"The $name puncture\"#" \
    -e 's#"at_most": 3, "why"#"at_most": 3, "must": false, "why"#' \
    "$source/configs/exercises/lumbar_puncture.json" >work/exercises/$name.json
done
cat >work/curriculum.json <<'JSON'
{"format": "acus-curriculum/1", "name": "Two punctures", "steps": [
  {"exercise": "exercises/first.json", "mastery": {"score_percent": 0, "goals_met_percent": 0, "in_a_row": 1}},
  {"exercise": "exercises/second.json", "after": ["exercises/first.json"]}]}
JSON
cat >work/study.json <<'JSON'
{"format": "acus-study/1", "name": "A day", "groups": ["novice", "expert"], "trials": 1, "participants": [
  {"code": "N1", "group": "novice"}, {"code": "N2", "group": "novice"},
  {"code": "E1", "group": "expert", "consent": true}, {"code": "E2", "group": "expert", "consent": true}],
 "exercises": ["exercises/first.json", "exercises/second.json"],
 "questionnaires": ["questionnaires/face_validity.json"]}
JSON

# A screen of its own; the X server says which number is free.
exec 7<>display_number
Xvfb -displayfd 7 -screen 0 1280x720x24 -fbdir fb >xvfb.log 2>&1 &
xvfb=$!
launcher=''
trap 'kill $xvfb $launcher 2>/dev/null || true' EXIT

# wait_for WHAT COMMAND...: until the command succeeds, 20 s at most, or WAIT_S where the machine is busy.
wait_for() {
  local what=$1
  shift
  local end=$((SECONDS + ${WAIT_S:-20}))
  while [[ $SECONDS -lt $end ]]; do
    if "$@" >/dev/null 2>&1; then return; fi
    sleep 0.05
  done
  shot failed
  fail "not within ${WAIT_S:-20} s: $what"
}
shot() { python3 "$source/tests/launcher/screenshot.py" fb "$1.png"; }
has_line() { [[ -s display_number ]]; }
wait_for "the X server" has_line
DISPLAY=:$(head -n 1 display_number)
export DISPLAY

key() { xdotool key --delay 30 "$@"; }
# Rows of the list of trainees are 28 pixels high; its header ends at 62.
row() { xdotool mousemove --sync 60 $((76 + 28 * ($1 - 1))) click 1; }
start_button() { xdotool mousemove --sync 530 620 click 1; }
states() { "$source/pipelines/training-day" --list work >list.txt && grep -cE "^  [0-9-]+ .*  $1  " list.txt; }
# sessions_are N STATE: so many sessions of all trainees are in the state.
sessions_are() { [[ $(states "$2" || true) == "$1" ]]; }
window_is_there() { xdotool search --name '^Acus: work$'; }
open_launcher() {
  "$source/pipelines/training-day" --headless --demo --duration "$1" work >launcher.out 2>&1 &
  launcher=$!
  wait_for "the window" window_is_there
  # The devices are checked first.
  wait_for "the check of the devices" grep -q "All is ready" work/launcher.log
  sleep 0.5
}

open_launcher 1
"$source/pipelines/training-day" work 2>second.txt && fail "a second launcher opened"
grep -q "is open in another window" second.txt || fail "a second launcher did not say why not"
shot begin

# N1: two clicks; consent is asked once.
row 1 && start_button
sleep 0.3 && shot consent
key F2
wait_for "the first session" sessions_are 1 done
# Next trainee in two clicks. E1 needs no consent.
clicked=$(date +%s%N)
row 3 && start_button
records() { compgen -G "work/sessions/E1/*/session.json"; }
wait_for "the recording of E1" records
echo "from the first click to the recording of the next trainee: $((($(date +%s%N) - clicked) / 1000000)) ms"
wait_for "the second session" sessions_are 2 done
# N1 answers; the second exercise is now open, and its session is discarded.
row 1 && key F8
sleep 0.3 && key 4 4 3 && shot questionnaire && key 2 5 1 Return
wait_for "the answers" grep -q "N1,face_validity,whole,1" work/answers.csv
key F5
wait_for "the third session" sessions_are 3 done
key F7
sleep 0.3 && xdotool type --delay 20 "cable loose" && shot discard && key Return
wait_for "the discarded session" sessions_are 1 discarded
# One launcher is closed, the next one opened: with long sessions.
close_launcher() { kill $launcher && wait $launcher 2>/dev/null || true; }
close_launcher
open_launcher 30

# recorded CODE: half a second of a session is on the disk.
recorded() { [[ $(cat work/sessions/"$1"/*/needle.csv | wc -l) -gt 500 ]]; }
kill_live() { pkill -9 -f "^acus-live $folder/work/.* --requests"; }
# N2 does not agree, and trains all the same; the program fails half way.
row 2 && key F5
sleep 0.3 && key F3
wait_for "the session of N2" recorded N2
kill_live || fail "no acus-live runs"
wait_for "the report of the session that failed" sessions_are 1 recovered
sleep 0.3 && shot failed_session
# The plug is pulled during a session of E2: nothing is left running.
row 4 && key F5
wait_for "the session of E2" recorded E2
kill -9 $launcher
pkill -9 -f "live-session .*--requests .*$folder/work$" || fail "no session runs"
kill_live || fail "no acus-live runs"
wait $launcher 2>/dev/null || true
sessions_are 1 no_end || fail "the session without an end is not seen"

# The next morning it is reported; the session of N2 is repeated.
open_launcher 1
wait_for "the session that was left is reported" sessions_are 2 recovered
row 2 && key F6
sleep 0.3 && xdotool type --delay 20 "program failed" && key Return
wait_for "the repeated session" sessions_are 3 done
sessions_are 2 discarded || fail "the repeated session is not marked"
sleep 0.3 && shot next_morning
close_launcher

# What was recorded is all there (a second on a busy machine is a few rows), and what counts is what was kept.
[[ $(find work/sessions -name needle.csv -size +300c | wc -l) == 6 ]] || fail "a recording is missing"
acus-training curriculum work/curriculum.json --trials work/sessions --trainee N1,N2,E1,E2 >curriculum.txt
cat curriculum.txt
for line in "E1" "E2" "N1" "N2"; do
  line="$line: next: The second puncture"
  grep -q "^$line" curriculum.txt || fail "the curriculum does not say: $line"
done
awk '/^N1/ { n1 = 1 } /^$/ { n1 = 0 } n1 && /^The second puncture +open +0 / { found = 1 } END { exit !found }' \
  <(awk 'BEGIN { RS = "" } /^N1/' curriculum.txt) || fail "the discarded session counts"
acus-study report work/study.json --trials work/sessions --consent work/consent.csv \
  --answers work/answers.csv -o study 2>study_warnings.txt >study.txt || fail "$(cat study_warnings.txt)"
grep -q "participant N2 has not given consent" study_warnings.txt || fail "the study uses N2 without consent"
[[ $(awk -F, 'NR > 1 && !seen[$1 $3 $4]++' study/trials.csv | wc -l) == 3 ]] ||
  fail "the study does not count the three sessions of N1, E1 and E2"
grep -q "^N1,.*face_validity,whole,1$" study/answers.csv || fail "the answers did not reach the study"
echo "the day is over"
