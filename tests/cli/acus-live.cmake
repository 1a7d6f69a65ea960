# acus-live: what a user gets without windows, and what he is told when something is wrong.
set(live_patient --set /patient/ct=$INPUTS/ct.nrrd --set /patient/labels=$INPUTS/labels.seg.nrrd
    --set /patient/ct_from_reference_file=$INPUTS/ct_from_reference.tfm)
set(virtual --devices devices/virtual.json --headless)

set(live_checks ${CMAKE_CURRENT_LIST_DIR}/live_checks.sh)
acus_add_cli_case(acus-live.replays_to_the_same_bytes EXIT 0 NEEDS inputs STDOUT "^same$"
  CREATES s/session.json s/needle.csv s/probe.csv s/forces.csv s/summary.json s/provenance.json
  COMMAND bash ${live_checks} replay)
acus_add_cli_case(acus-live.ends_on_a_signal_with_a_whole_recording EXIT 0 NEEDS inputs
  STDOUT "^same$" "ended_by.*stopped" "steps_lost.: 0"
  COMMAND bash ${live_checks} signal)
acus_add_cli_case(acus-live.killed_it_leaves_what_can_be_replayed EXIT 0 NEEDS inputs
  STDOUT "^same$"
  COMMAND bash ${live_checks} kill)
acus_add_cli_case(acus-live.check EXIT 0 NEEDS inputs LEAVES_NOTHING
  STDOUT "needle force" "^Needle: virtual hand, 1000 Hz, up to [0-9]+ N" "^Probe: virtual hand"
  COMMAND acus-live $INPUTS/scenario.json ${virtual} ${live_patient} --check)
acus_add_cli_case(acus-live.no_output EXIT 2 NEEDS inputs LEAVES_NOTHING
  STDERR "--output is required"
  COMMAND acus-live $INPUTS/scenario.json ${virtual})
acus_add_cli_case(acus-live.no_devices_file EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "devices/virtuel.json: no such file"
  COMMAND acus-live $INPUTS/scenario.json --devices devices/virtuel.json -o s ${live_patient})
acus_add_cli_case(acus-live.nothing_held EXIT 3 NEEDS inputs LEAVES_NOTHING
  BEFORE "echo '{\"format\": \"acus-devices/1\", \"devices\": []}' > d.json"
  STDERR "d.json: neither needle nor probe is on a device or tracked"
  COMMAND acus-live $INPUTS/scenario.json --devices d.json -o s ${live_patient})
acus_add_cli_case(acus-live.keeps_what_is_there EXIT 3 NEEDS inputs LEAVES_NOTHING
  BEFORE "mkdir s && echo mine > s/notes.txt"
  STDERR "s: is not the output of an earlier run"
  COMMAND acus-live $INPUTS/scenario.json ${virtual} ${live_patient} -o s --overwrite)

# Ten minutes of it are run by hand: docs/concepts/live_session.md.
add_test(NAME cli.live-endurance.faults
  COMMAND ${ACUS_BASH} ${CMAKE_SOURCE_DIR}/pipelines/live-endurance --seconds 20 --faults
          --least-rate 10 --patient ${ACUS_CLI_FOLDER}/inputs -o ${ACUS_CLI_FOLDER}/live-endurance)
set_tests_properties(cli.live-endurance.faults PROPERTIES
  LABELS "cli" TIMEOUT 120 FIXTURES_REQUIRED inputs
  ENVIRONMENT "ACUS_BIN=${CMAKE_BINARY_DIR}/bin")
