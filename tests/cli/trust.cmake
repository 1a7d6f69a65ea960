# What holds for programs in odd surroundings: little memory, small stacks, full disks, signals.
set(trust_replay acus-replay $INPUTS/scenario.json $INPUTS/session --ct $INPUTS/ct.nrrd
    --labels $INPUTS/labels.seg.nrrd --transform $INPUTS/ct_from_reference.tfm)

acus_add_cli_case(trust.small_stack EXIT 0 NEEDS inputs TIMEOUT 120 CREATES run/report.html
  COMMAND bash -c "ulimit -s 256 && exec \"$@\"" - ${trust_replay} -o run)

# Standard output that cannot be written is not success.
foreach(program ${ACUS_PROGRAMS})
  acus_add_cli_case(trust.full_output.${program} EXIT 3
    STDERR "^${program}: standard output cannot be written"
    COMMAND bash -c "exec ${program} --help > /dev/full")
endforeach()
acus_add_cli_case(trust.full_output_of_a_result EXIT 3 NEEDS inputs
  STDERR "^acus-replay: standard output cannot be written" CREATES run/report.html
  COMMAND bash -c "exec \"$@\" > /dev/full" - ${trust_replay} -o run)
acus_add_cli_case(trust.reader_that_ends EXIT 3 NEEDS inputs CREATES run/report.html
  STDERR "^acus-replay: standard output cannot be written"
  COMMAND bash -c "set -o pipefail && \"$@\" | true" - ${trust_replay} -o run)

# Folders that are being written.
foreach(how without_overwrite recording)
  acus_add_cli_case(trust.folder_in_use.${how} EXIT 0 NEEDS inputs TIMEOUT 120 STDOUT "^refused$"
    COMMAND bash ${CMAKE_CURRENT_LIST_DIR}/folder_in_use.sh ${how})
endforeach()

# Every call of the system that can be refused, one at a time; refused_calls.py by itself tries all of them.
add_library(fail_calls MODULE ${CMAKE_SOURCE_DIR}/tests/faults/fail_calls.cpp)
target_compile_features(fail_calls PRIVATE cxx_std_20)
if(NOT ACUS_SANITIZE)  # Sanitizers want to be loaded first.
  acus_add_cli_case(trust.refused_calls EXIT 0 NEEDS inputs TIMEOUT 600
    STDOUT "segmentation: rename: [1-9]" "replay: write: [1-9]" "live session: memory: [1-9]"
    COMMAND bash ${CMAKE_CURRENT_LIST_DIR}/refused_calls.sh $<TARGET_FILE:fail_calls>
            ${CMAKE_SOURCE_DIR}/tests/faults/refused_calls.py 6)
endif()

# Changes on the command line are blamed by their name.
acus_add_cli_case(trust.set_of_a_wrong_kind EXIT 3 LEAVES_NOTHING NEEDS inputs
  STDERR "^acus-replay: --set /image_rate_hz=\"fast\": with this change, .*scenario.json"
  COMMAND ${trust_replay} --check --set /image_rate_hz=fast)
acus_add_cli_case(trust.set_of_broken_json EXIT 3 LEAVES_NOTHING NEEDS inputs
  STDERR "^acus-replay: --set /effects=.\"a\":1: what follows the '=' is not valid JSON"
  COMMAND ${trust_replay} --check --set "/effects={\"a\":1")
acus_add_cli_case(trust.wrong_file_is_not_blamed_on_set EXIT 3 LEAVES_NOTHING NEEDS inputs
  BEFORE "sed 's/\"effects\"/\"efects\"/' $INPUTS/scenario.json > s.json"
  STDERR "^acus-replay: .*s.json: does not fit its schema"
  COMMAND acus-replay s.json $INPUTS/session --check --set /image_rate_hz=20)
acus_add_cli_case(trust.set_of_a_missing_preset EXIT 3 LEAVES_NOTHING NEEDS inputs
  STDERR "^acus-replay: --set /needle=\"none.json\"" COMMAND ${trust_replay} --check --set /needle=none.json)

# Outputs that are sent away.
acus_add_cli_case(trust.no_folders EXIT 0 NEEDS inputs TIMEOUT 120 STDOUT "^no folder is named$"
  BEFORE "mkdir 'Jane Doe' && cp -rL $INPUTS/ct.nrrd $INPUTS/labels.seg.nrrd $INPUTS/session \
$INPUTS/scenario.json $INPUTS/ct_from_reference.tfm 'Jane Doe'"
  COMMAND bash -c "cd 'Jane Doe' && acus-replay scenario.json \"$PWD/session\" --ct ct.nrrd --labels \
\"$PWD/labels.seg.nrrd\" --transform ct_from_reference.tfm --png none --no-folders -o ../run >/dev/null && \
cd .. && test -s run/report.html && ! grep -rlaE 'Jane|/share/acus' run && echo no folder is named")

acus_add_cli_case(trust.no_network EXIT 0 NEEDS inputs TIMEOUT 120 STDOUT "^Report: |^skipped"
  COMMAND bash -c "unshare -rn true || exec echo skipped
exec unshare -rn \"$@\"" - ${trust_replay} --png none -o run)

# A sweep's list ends, whatever the seed.
acus_add_cli_case(trust.list_of_combinations EXIT 0 NEEDS inputs TIMEOUT 60 STDOUT "^case jointly-"
  COMMAND acus-tradeoff scene $INPUTS/scenario.json $INPUTS/session --ct $INPUTS/ct.nrrd
          --labels $INPUTS/labels.seg.nrrd --jointly --list)

# A mutant behind its switch does what the change of the source itself does.
acus_add_cli_case(trust.mutants EXIT 0 STDOUT "changes, [0-9]+ tokens"
  COMMAND python3 ${CMAKE_CURRENT_LIST_DIR}/mutants.py ${CMAKE_SOURCE_DIR} mutants)
