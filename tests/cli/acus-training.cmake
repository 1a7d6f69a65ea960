# acus-training: sessions of an exercise side by side.
acus_add_cli_case(acus-training.two_sessions EXIT 0 NEEDS inputs
  STDOUT "^A7 +insertion +[0-9] of 7" "goal not met"
  CREATES progress/progress.html progress/progress.csv progress/provenance.json
  COMMAND acus-training $INPUTS/first_run $INPUTS/second_run -o progress)
acus_add_cli_case(acus-training.goal_lines EXIT 0 NEEDS inputs
  BEFORE "acus-training $INPUTS/first_run $INPUTS/second_run -o progress >/dev/null
          echo '{\"format\": \"acus-exercise/1\", \"name\": \"x\", \"goals\": [{\"metric\": \"largest axial force\", \"at_most\": 2.5}, {\"metric\": \"greatest depth\", \"at_least\": 60, \"at_most\": 80}]}' > e.json
          acus-replay $INPUTS/scenario.json $INPUTS/session --ct $INPUTS/ct.nrrd --labels $INPUTS/labels.seg.nrrd --transform $INPUTS/ct_from_reference.tfm --no-film --png none --exercise e.json -o run >/dev/null"
  STDOUT "^goal: at most 3$" "^goal: at most 2.5 N" "^goal: at least 60 mm$" "^goal: at most 80 mm$"
  COMMAND grep -oh "goal: at [a-z]* [0-9.]*[ a-zN]*" progress/progress.html run/report.html)
acus_add_cli_case(acus-training.run_without_exercise EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "reference_run: has no training.json; make the run with acus-replay --exercise"
  COMMAND acus-training $INPUTS/reference_run -o progress)
acus_add_cli_case(acus-training.no_such_folder EXIT 2 LEAVES_NOTHING
  STDERR "nowhere" COMMAND acus-training nowhere -o progress)
acus_add_cli_case(acus-training.broken_file EXIT 3 NEEDS inputs
  BEFORE "cp -rL $INPUTS/first_run a && sed -i s/metrics/metrix/ a/training.json"
  STDERR "a/training.json: is not a training.json"
  COMMAND acus-training a -o progress)

# what-if: other insertions of a trial.
set(lumbar scenario.json --ct ct.nrrd --labels labels.seg.nrrd --transform ct_from_reference.tfm
           --set /patient/corridor=corridor_ct.csv --exercise exercises/lumbar_puncture.json)
list(TRANSFORM lumbar REPLACE "^([a-z_]+[.](json|nrrd|seg[.]nrrd|tfm))$" "$INPUTS/\\1")
list(TRANSFORM lumbar REPLACE "=corridor" "=$INPUTS/corridor")
acus_add_cli_case(acus-training.what_if EXIT 0 NEEDS inputs
  STDOUT "^Trial: [0-9] of 7 goals met" "^80 alternatives; the best:" "With one change: "
  CREATES w/what_if.html w/what_if.csv w/what_if.json w/map.svg w/sessions/best_1/needle.csv
          w/provenance.json
  COMMAND acus-training what-if ${lumbar} $INPUTS/session --count 80 -o w)
string(JOIN " " lumbar_text ${lumbar})
# The best one by acus-replay, with images, has the metrics that what-if ranked it by.
acus_add_cli_case(acus-training.what_if_is_a_replay EXIT 0 NEEDS inputs
  BEFORE "acus-training what-if ${lumbar_text} $INPUTS/session --count 80 -o w >/dev/null
          acus-replay ${lumbar_text} w/sessions/best_1 --no-film --png none -o r >/dev/null"
  STDOUT "^same$"
  COMMAND python3 -c "import json\nbest = json.load(open('w/what_if.json'))['best'][0]['assessment']\nrun = json.load(open('r/training.json'))\nprint('same' if all(best[k] == run[k] for k in ('metrics', 'goals', 'structures')) else 'different')")
acus_add_cli_case(acus-training.what_if_without_exercise EXIT 2 NEEDS inputs LEAVES_NOTHING
  STDERR "--exercise is required" COMMAND acus-training what-if $INPUTS/scenario.json $INPUTS/session -o w)
acus_add_cli_case(acus-training.what_if_broken_ranges EXIT 3 NEEDS inputs
  BEFORE "echo '{\"format\": \"acus-what-if/1\", \"ranges\": {\"tilt_dg\": 3}}' > r.json"
  STDERR "r.json" "tilt_dg" "tilt_deg"
  COMMAND acus-training what-if ${lumbar} $INPUTS/session --ranges r.json -o w)

# simulate: virtual trainees.
acus_add_cli_case(acus-training.simulate EXIT 0 NEEDS inputs
  STDOUT "^expert trial 1: [0-9] of 7 goals met"
  CREATES t/expert/trial_1/session/needle.csv t/expert/trial_1/training.json
          t/expert/trial_1/metrics.json t/expert/trial_1/events.csv t/provenance.json
  COMMAND acus-training simulate ${lumbar} --trainee trainees/expert.json --trials 1 -o t)
acus_add_cli_case(acus-training.simulate_wrong_codes EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "--codes: 1 codes for 2 trainees"
  COMMAND acus-training simulate ${lumbar} --trainee trainees/expert.json,trainees/novice.json
          --codes A -o t)
acus_add_cli_case(acus-training.simulate_odd_code EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "must be a plain word"
  COMMAND acus-training simulate ${lumbar} --trainee trainees/expert.json --codes ../a -o t)

# A session beside a reference group.
acus_add_cli_case(acus-training.reference EXIT 0 NEEDS inputs
  STDOUT "^Reference group: [0-9]+ persons, [0-9]+ trials" "^score .%. +[0-9.]+ +- +[0-9.]+"
  CREATES p/progress.html p/reference.csv
  COMMAND acus-training $INPUTS/first_run --reference $INPUTS/trainees -o p)
acus_add_cli_case(acus-training.reference_without_trials EXIT 3 NEEDS inputs BEFORE "mkdir empty"
  STDERR "empty: no trial was found"
  COMMAND acus-training $INPUTS/first_run --reference empty)

# curriculum: what is mastered, and what is next.
acus_add_cli_case(acus-training.curriculum EXIT 0 NEEDS inputs
  STDOUT "^N1: next: Liver biopsy" "^Lumbar puncture under ultrasound +locked +2 "
  COMMAND acus-training curriculum curricula/four_punctures.json --trials $INPUTS/trainees)
acus_add_cli_case(acus-training.curriculum_entry EXIT 3 NEEDS inputs
  BEFORE "echo '{\"format\": \"acus-curriculum/1\", \"name\": \"x\", \"steps\": [{\"exercise\": \"exercises/liver_biopsy.json\", \"after\": [\"exercises/kidney_puncture.json\"]}]}' > c.json"
  STDERR "c.json: /steps/0: /after: .exercises/kidney_puncture.json. is not the exercise of an earlier"
  COMMAND acus-training curriculum c.json --trials $INPUTS/trainees)
acus_add_cli_case(acus-training.curriculum_of_a_new_trainee EXIT 0 BEFORE "mkdir empty"
  STDOUT "^  \"format\": \"acus-curriculum-state/1\"" "\"state\": \"locked\""
  COMMAND acus-training curriculum curricula/four_punctures.json --trials empty --trainee A7 --json)
acus_add_cli_case(acus-training.discarded_session EXIT 0 NEEDS inputs
  STDOUT "^A7 +insertion +[0-9] of 7" STDERR "warning: b: the session was discarded .discarded.json.: it is not"
  BEFORE "cp -rL $INPUTS/second_run b && echo '{\"reason\": \"cable loose\"}' > b/discarded.json"
  COMMAND acus-training $INPUTS/first_run b)
# Cases of a step, from the easiest on.
set(cases "bash ${CMAKE_CURRENT_LIST_DIR}/case_inputs.sh ${CMAKE_SOURCE_DIR}/configs")
acus_add_cli_case(acus-training.difficulty EXIT 0 NEEDS inputs BEFORE "${cases}"
  STDOUT "^Case 1 +0[.][0-9]+ " "^Case 2 +0[.][0-9]+ " "^cases +open +0 " "^A: next: cases: Case 1 .difficulty 0[.]"
  CREATES d/cases.csv d/provenance.json
  COMMAND bash -c "acus-training difficulty e2.json e1.json --persons 6 --rate-hz 200 -o d && \
acus-training curriculum c.json --trials . --trainee A")
acus_add_cli_case(acus-training.difficulty_without_a_patient EXIT 3 LEAVES_NOTHING
  BEFORE "echo '{\"format\": \"acus-exercise/1\", \"name\": \"x\"}' > e.json"
  STDERR "e.json: /scenario: is missing"
  COMMAND acus-training difficulty e.json -o d)
acus_add_cli_case(acus-training.curriculum_no_trials EXIT 3 BEFORE "mkdir empty"
  STDERR "empty: no trial was found"
  COMMAND acus-training curriculum curricula/four_punctures.json --trials empty)
