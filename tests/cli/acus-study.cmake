# acus-study: from the plan to the report.
acus_add_cli_case(acus-study.plan EXIT 0 NEEDS inputs
  STDOUT "^4 participants, 1 exercise of 2 trials each"
  CREATES p/order.csv p/answers.csv p/provenance.json
  COMMAND acus-study plan $INPUTS/study.json -o p)
acus_add_cli_case(acus-study.report EXIT 0 NEEDS inputs
  STDOUT "^Small study: 8 trials" "Too few participants" "distinguish novice from expert: none" "do not: .*needle elapsed time .p 1.000"
  CREATES r/study.html r/trials.csv r/descriptive.csv r/comparison.csv r/learning.csv
          r/reliability.csv r/items.csv r/answers.csv r/provenance.json
  BEFORE "acus-study plan $INPUTS/study.json -o p >/dev/null && sed '2,$s/$/4/' p/answers.csv > a.csv"
  COMMAND acus-study report $INPUTS/study.json --trials $INPUTS/trainees --answers a.csv -o r)
# Every number again from the table of raw values.
acus_add_cli_case(acus-study.report_of_the_table EXIT 0 NEEDS inputs
  BEFORE "acus-study report $INPUTS/study.json --trials $INPUTS/trainees -o a >/dev/null
          acus-study report $INPUTS/study.json --trials a/trials.csv -o b >/dev/null"
  COMMAND bash -c "cmp a/trials.csv b/trials.csv && cmp a/descriptive.csv b/descriptive.csv && cmp a/comparison.csv b/comparison.csv && cmp a/learning.csv b/learning.csv && cmp a/reliability.csv b/reliability.csv")
acus_add_cli_case(acus-study.export EXIT 0 NEEDS inputs
  CREATES b/participants.tsv b/dataset_description.json
          b/sub-N1/beh/sub-N1_task-LumbarPunctureUnderUltrasound_run-01_beh.tsv
          b/sub-N1/beh/sub-N1_task-LumbarPunctureUnderUltrasound_run-01_events.tsv
  COMMAND acus-study export $INPUTS/study.json --trials $INPUTS/trainees -o b)
acus_add_cli_case(acus-study.unknown_code EXIT 3 NEEDS inputs
  BEFORE "sed s/N2/N7/ $INPUTS/study.json > s.json"
  STDERR "the code .N2. is not among the participants of .*s.json"
  COMMAND acus-study report s.json --trials $INPUTS/trainees -o r)
acus_add_cli_case(acus-study.answer_off_the_scale EXIT 3 NEEDS inputs
  BEFORE "printf 'code,questionnaire,item,answer\nN1,face_validity,image,9\n' > a.csv"
  STDERR "a.csv:2: the answer 9 is off the scale of 1 to 5"
  COMMAND acus-study report $INPUTS/study.json --trials $INPUTS/trainees --answers a.csv -o r)
acus_add_cli_case(acus-study.consent EXIT 0 NEEDS inputs
  STDERR "warning: participant N1 has not given consent" STDOUT "^Small study: 6 trials"
  BEFORE "printf 'code,consent,time\nN1,no,2026-01-01T10:00:00\n' > c.csv"
  COMMAND acus-study report $INPUTS/study.json --trials $INPUTS/trainees --consent c.csv -o r)
acus_add_cli_case(acus-study.consent_maybe EXIT 3 NEEDS inputs
  BEFORE "printf 'code,consent\nN1,maybe\n' > c.csv"
  STDERR "c.csv:2: the consent must be yes or no, got .maybe."
  COMMAND acus-study report $INPUTS/study.json --trials $INPUTS/trainees --consent c.csv -o r)
acus_add_cli_case(acus-study.misspelt_key EXIT 3 NEEDS inputs
  BEFORE "sed s/trials/trails/ $INPUTS/study.json > s.json"
  STDERR "s.json" "trails" "trials" COMMAND acus-study plan s.json -o p)
acus_add_cli_case(acus-study.not_simulated EXIT 2 LEAVES_NOTHING
  STDERR "give --simulated" COMMAND ${CMAKE_SOURCE_DIR}/pipelines/study --no-build out)
acus_add_cli_case(acus-study.simulated EXIT 0 NEEDS inputs TIMEOUT 300
  STDOUT "^lumbar_puncture, expert" "^Small study: 8 trials"
  CREATES out/report/study.html out/plan/order.csv out/bids/participants.tsv
  COMMAND ${CMAKE_SOURCE_DIR}/pipelines/study --simulated --no-build --study $INPUTS/study.json
          --rate-hz 100 out)
