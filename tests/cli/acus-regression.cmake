# acus-regression: what moved, and the one command that makes it the expected outcome.
acus_add_cli_case(acus-regression.new EXIT 4 NEEDS inputs
  STDOUT "^NEW +insertion" "0 of 1 cases are as expected"
  STDERR "acus-regression accept makes it the expected one"
  CREATES result/regression.html result/regression.json result/insertion/run/forces.csv
  COMMAND acus-regression run $INPUTS/suite -o result)
acus_add_cli_case(acus-regression.moved EXIT 4 NEEDS inputs TIMEOUT 120
  BEFORE "cp -rL $INPUTS p && cd p && rm -rf suite/expected
$ACUS_BIN/acus-regression run suite -o ../a >/dev/null 2>&1 || true
$ACUS_BIN/acus-regression accept suite ../a >/dev/null && sed -i 's/spinal_22g/trocar_18g/' scenario.json"
  STDOUT "^MOVED +insertion +[0-9]+ of [0-9]+ .*force_axial_n"
  CREATES b/regression.html b/insertion/comparison/comparison.html b/insertion/comparison/worst_frame.png
  COMMAND acus-regression run p/suite -o b)
acus_add_cli_case(acus-regression.accept_without_result EXIT 3 NEEDS inputs LEAVES_NOTHING
  BEFORE "mkdir a" STDERR "a: is not a result of acus-regression run"
  COMMAND acus-regression accept $INPUTS/suite a)
acus_add_cli_case(acus-regression.no_such_case EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "there is no case .lumbar.; the suite has: insertion"
  COMMAND acus-regression run $INPUTS/suite --case lumbar -o result)
