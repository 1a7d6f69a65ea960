# acus-training: sessions of an exercise side by side.
acus_add_cli_case(acus-training.two_sessions EXIT 0 NEEDS inputs
  STDOUT "^A7 +insertion +[0-9] of 7" "goal not met"
  CREATES progress/progress.html progress/progress.csv progress/provenance.json
  COMMAND acus-training $INPUTS/first_run $INPUTS/second_run -o progress)
acus_add_cli_case(acus-training.run_without_exercise EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "reference_run: has no training.json; make the run with acus-replay --exercise"
  COMMAND acus-training $INPUTS/reference_run -o progress)
acus_add_cli_case(acus-training.no_such_folder EXIT 2 LEAVES_NOTHING
  STDERR "nowhere" COMMAND acus-training nowhere -o progress)
acus_add_cli_case(acus-training.broken_file EXIT 3 NEEDS inputs
  BEFORE "cp -rL $INPUTS/first_run a && sed -i s/metrics/metrix/ a/training.json"
  STDERR "a/training.json: is not a training.json"
  COMMAND acus-training a -o progress)
