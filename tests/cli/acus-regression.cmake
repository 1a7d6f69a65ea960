# acus-regression: what moved, and the one command that makes it the expected outcome.
acus_add_cli_case(acus-regression.new EXIT 4 NEEDS inputs
  STDOUT "^NEW +insertion" "0 of 1 case is as expected"
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
acus_add_cli_case(acus-regression.run_set EXIT 4 NEEDS inputs TIMEOUT 120
  BEFORE "cp -rL $INPUTS p && cd p && rm -rf suite/expected
acus-regression run suite -o ../a >/dev/null 2>&1 || true
acus-regression accept suite ../a >/dev/null"
  STDOUT "^MOVED +insertion +[0-9]+ of [0-9]+ .*force_axial_n" STDERR "cannot be accepted"
  CREATES b/regression.html j.xml
  COMMAND acus-regression run p/suite --set /needle=needles/trocar_18g.json --junit j.xml -o b)
acus_add_cli_case(acus-regression.no_accepting_of_set EXIT 3 NEEDS inputs TIMEOUT 120
  BEFORE "cp -rL $INPUTS p && rm -rf p/suite/expected
acus-regression run p/suite --set /needle=needles/trocar_18g.json -o b >/dev/null 2>&1 || true"
  STDERR "b: is a result with --set .*trocar_18g.*run it without"
  COMMAND acus-regression accept p/suite b)
set(new_options --ct p/ct.nrrd --labels p/labels.seg.nrrd --transform p/ct_from_reference.tfm)
acus_add_cli_case(acus-regression.made EXIT 0 NEEDS inputs TIMEOUT 120
  BEFORE "cp -rL $INPUTS p
acus-regression new p/scenario.json p/session --ct p/ct.nrrd --labels p/labels.seg.nrrd --transform p/ct_from_reference.tfm \\
  --set /effects/ultrasound=null --set /image_rate_hz=1 -o p/made >/dev/null
mv p q && (cd q && acus-regression run made -o a >/dev/null 2>&1 || true)
acus-regression accept q/made q/a >/dev/null"
  STDOUT "1 of 1 case is as expected"
  COMMAND acus-regression run q/made -o b)
acus_add_cli_case(acus-regression.new_without_patient EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "labels" COMMAND acus-regression new $INPUTS/scenario.json $INPUTS/session -o made)
acus_add_cli_case(acus-regression.new_no_session EXIT 2 NEEDS inputs LEAVES_NOTHING
  STDERR "nowhere" COMMAND acus-regression new $INPUTS/scenario.json nowhere ${new_options} -o made)

# Where two replays part: the stage and variable, from one replay of each.
set(bisect_runs "small() {
  acus-replay $INPUTS/scenario.json $INPUTS/session --ct $INPUTS/ct.nrrd --labels $INPUTS/labels.seg.nrrd \\
    --transform $INPUTS/ct_from_reference.tfm --no-film --no-sequence --png none --trace \"$@\" >/dev/null
}
small -o a")
acus_add_cli_case(acus-regression.bisect_same EXIT 0 NEEDS inputs
  BEFORE "${bisect_runs} && small -o b --threads 3" STDOUT "^the same in all 8[0-9]+ steps and all images$"
  COMMAND acus-regression bisect a b)
acus_add_cli_case(acus-regression.bisect_force EXIT 4 NEEDS inputs
  BEFORE "${bisect_runs} && small -o b --set /needle=needles/trocar_18g.json"
  STDOUT "^first different step: number [0-9]+, at [0-9.]+ s, stage needle force, variable [a-z_]+: "
  STDERR "acus-regression: the runs differ"
  COMMAND acus-regression bisect a b)
acus_add_cli_case(acus-regression.bisect_image EXIT 4 NEEDS inputs
  BEFORE "${bisect_runs} && small -o b --set /effects/ct_slice/window/width_hu=401"
  STDOUT "^all 8[0-9]+ steps are the same$" "^first different image: number 0, .*stage CT slice, variable sha256: "
  STDERR "acus-regression: the runs differ"
  COMMAND acus-regression bisect a b)
acus_add_cli_case(acus-regression.bisect_without_trace EXIT 3 NEEDS inputs
  STDERR "reference_run/trace.csv: not there; replay with acus-replay --trace"
  COMMAND acus-regression bisect $INPUTS/reference_run $INPUTS/new_run)
