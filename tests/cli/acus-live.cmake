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
# A second process makes the images; a third receives what the session shows.
acus_add_cli_case(acus-live.images_of_a_second_computer EXIT 0 NEEDS inputs
  STDOUT "^same$" "^[3-9][0-9] different images are frames of the replay, 0 are not|1[0-9][0-9] different images are frames of the replay, 0 are not"
         "images from localhost:[0-9]+: [0-9]+, [0-9.]+ ms old" "^Images for " "^Ended: "
  COMMAND bash ${live_checks} images)
acus_add_cli_case(acus-live.second_computer_is_killed EXIT 0 NEEDS inputs
  STDOUT "^same$" "images from localhost:[0-9]+: .*closed the link" "steps_lost.: 0"
  COMMAND bash ${live_checks} images_cut)
acus_add_cli_case(acus-live.make_images_and_output EXIT 2 NEEDS inputs LEAVES_NOTHING
  STDERR "--make-images goes with none of --output, --check and --requests"
  COMMAND acus-live $INPUTS/scenario.json ${virtual} -o s --make-images 0)
acus_add_cli_case(acus-live.make_images_at_no_port EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "address 'here:there': the port must be a number from 0 to 65535"
  COMMAND acus-live $INPUTS/scenario.json ${virtual} ${live_patient} --make-images here:there)
# Without a loudspeaker the session is like any other.
set(cries --set "/effects/pain_reaction={\"sound\": \"cry\"}")
acus_add_cli_case(acus-live.no_loudspeaker EXIT 0 NEEDS inputs
  STDERR "warning: The patient is not heard: .*(loudspeaker: OpenAL Soft finds none|Install the package libopenal1)"
  CREATES s/forces.csv
  COMMAND env ALSOFT_DRIVERS=nothing acus-live $INPUTS/scenario.json ${virtual} ${live_patient}
  ${cries} -o s --duration 2)
acus_add_cli_case(acus-live.no_such_sound EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "/effects/pain_reaction/sound: .*gone.wav"
  COMMAND acus-live $INPUTS/scenario.json ${virtual} ${live_patient}
  --set "/effects/pain_reaction={\"sound\": \"gone.wav\"}" -o s)
acus_add_cli_case(acus-live.check EXIT 0 NEEDS inputs LEAVES_NOTHING
  STDOUT "needle force" "^Needle: virtual hand, 1000 Hz, up to [0-9]+ N" "^Probe: virtual hand"
  COMMAND acus-live $INPUTS/scenario.json ${virtual} ${live_patient} --check)

# Vendors' libraries: tests/stand_ins/marker.cpp leaves the file code_ran where it is loaded.
set(marker ${CMAKE_BINARY_DIR}/tests/stand_ins/marker/libacus_marker.so)
# A file `d.json` with two devices, of which the second is as the argument says.
set(hands "{\"name\": \"left\", \"driver\": \"virtual_hand\"}")
function(devices_with text out)
  set(${out} "echo '{\"format\": \"acus-devices/1\", \"devices\": [${hands}, {\"name\": \"right\", \
\"driver\": \"force_dimension\"${text}}], \"needle\": {\"device\": \"right\"}, \
\"probe\": {\"device\": \"left\"}}' > d.json" PARENT_SCOPE)
endfunction()
devices_with("" d_usual)
devices_with(", \"library\": \"libacus_marker.so\"" d_name)
devices_with(", \"library\": \"./libacus_marker.so\"" d_relative)
devices_with(", \"library\": \"/nowhere/libdhd.so.3\"" d_gone)
set(with_driver acus-live $INPUTS/scenario.json --devices d.json --headless ${live_patient})
acus_add_cli_case(acus-live.check_loads_no_driver EXIT 0 NEEDS inputs LEAVES_NOTHING
  BEFORE "${d_name} && cp ${marker} ."
  STDOUT "^Needle: Force Dimension SDK of /.*/libacus_marker.so .there, not loaded"
         "^Probe: virtual hand"
  COMMAND bash -c "LD_LIBRARY_PATH=$PWD exec \"$@\"" - ${with_driver} --check)
acus_add_cli_case(acus-live.left_handed EXIT 0 NEEDS inputs LEAVES_NOTHING
  BEFORE "${d_name} && cp ${marker} ."
  STDOUT "^Needle: virtual hand" "^Probe: Force Dimension SDK"
  COMMAND bash -c "LD_LIBRARY_PATH=$PWD exec \"$@\"" - ${with_driver} --check --left-handed)
acus_add_cli_case(acus-live.session_loads_the_driver EXIT 3 NEEDS inputs CREATES code_ran
  BEFORE "${d_name} && cp ${marker} ." STDERR "device 'right': .*: its library lacks functions"
  COMMAND bash -c "LD_LIBRARY_PATH=$PWD exec \"$@\"" - ${with_driver} -o s)
acus_add_cli_case(acus-live.check_driver_is_not_there EXIT 3 NEEDS inputs LEAVES_NOTHING
  BEFORE "${d_gone}" STDERR "device 'right': .*/nowhere/libdhd.so.3: no such file"
  COMMAND ${with_driver} --check)
# Where the SDK is installed, the check finds that one.
acus_add_cli_case(acus-live.check_driver_of_the_working_directory EXIT 0|3 NEEDS inputs
  LEAVES_NOTHING BEFORE "${d_usual} && cp ${marker} libdhd.so.3"
  COMMAND ${with_driver} --check)
acus_add_cli_case(acus-live.driver_of_the_working_directory EXIT 3 NEEDS inputs LEAVES_NOTHING
  BEFORE "${d_usual} && cp ${marker} libdhd.so.3" STDERR "device 'right': "
  COMMAND ${with_driver} -o s)
acus_add_cli_case(acus-live.driver_by_an_empty_entry EXIT 3 NEEDS inputs LEAVES_NOTHING
  BEFORE "${d_usual} && cp ${marker} libdhd.so.3"
  STDERR "device 'right': LD_LIBRARY_PATH is '/nowhere:': its entry '.' is the working directory"
  COMMAND env LD_LIBRARY_PATH=/nowhere: ${with_driver} -o s)
acus_add_cli_case(acus-live.driver_by_a_relative_path EXIT 3 NEEDS inputs LEAVES_NOTHING
  BEFORE "${d_relative} && cp ${marker} ."
  STDERR "d.json: /devices/1/library: is './libacus_marker.so'.*allowed: an absolute path"
  COMMAND ${with_driver} --check)
# As fast as the computer is, and the same on every computer; without --duration to the end of what is followed.
acus_add_cli_case(acus-live.virtual_time EXIT 0 NEEDS inputs STDOUT "^same$" "lost: 0"
  COMMAND bash ${live_checks} virtual_time)
acus_add_cli_case(acus-live.virtual_time_in_a_window EXIT 2 NEEDS inputs LEAVES_NOTHING
  STDERR "--virtual-time goes with --headless"
  COMMAND acus-live $INPUTS/scenario.json --devices devices/virtual.json ${live_patient} --virtual-time -o s)
acus_add_cli_case(acus-live.virtual_time_without_an_end EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "--virtual-time: give --duration, or --hand"
  COMMAND acus-live $INPUTS/scenario.json ${virtual} ${live_patient} --virtual-time -o s)
acus_add_cli_case(acus-live.no_output EXIT 2 NEEDS inputs LEAVES_NOTHING
  STDERR "--output is required"
  COMMAND acus-live $INPUTS/scenario.json ${virtual})
# A request as in docs/concepts/live_session.md, with more keys as the argument says.
function(request output more out)
  set(${out} "{\"format\": \"acus-session-request/1\", \"output\": \"${output}\", \
\"duration_s\": 0.5${more}}" PARENT_SCOPE)
endfunction()
request(first "" request_first)
request(second ", \"left_handed\": true" request_second)
request(third ", \"exercise\": \"gone.json\"" request_third)
acus_add_cli_case(acus-live.requests EXIT 3 NEEDS inputs
  BEFORE "(echo '${request_first}' && echo '${request_third}' && echo nonsense && echo '${request_second}') > r"
  STDOUT "\"event\":\"ready\"" "\"code\":0,\"event\":\"ended\".*\"output\":\"first\""
         "\"code\":3,\"event\":\"refused\",\"message\":\"gone.json: no such file"
         "request: is no JSON object in one line: nonsense" "\"output\":\"second\""
  CREATES first/summary.json first/forces.csv second/summary.json second/forces.csv
  COMMAND bash -c "exec \"$@\" < r" - acus-live $INPUTS/scenario.json ${virtual} ${live_patient} --requests)
acus_add_cli_case(acus-live.requests_and_output EXIT 2 NEEDS inputs LEAVES_NOTHING
  STDERR "--requests goes with neither --output nor --check"
  COMMAND acus-live $INPUTS/scenario.json ${virtual} -o s --requests)
acus_add_cli_case(acus-live.requests_and_exercise EXIT 2 NEEDS inputs LEAVES_NOTHING
  STDERR "--requests: --exercise, .* are those of each request"
  COMMAND acus-live $INPUTS/scenario.json ${virtual} --duration 3 --requests)
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

# Ten minutes of it are run by hand: docs/concepts/live_session.md. It judges times of steps, so it runs alone
# and again if the machine was busy with something else.
add_test(NAME cli.live-endurance.faults
  COMMAND ${ACUS_BASH} ${CMAKE_SOURCE_DIR}/developer/live-endurance --seconds 20 --faults
          --least-rate 10 --patient ${ACUS_CLI_FOLDER}/inputs -o ${ACUS_CLI_FOLDER}/live-endurance)
set_tests_properties(cli.live-endurance.faults PROPERTIES
  LABELS "cli;performance" TIMEOUT 120 FIXTURES_REQUIRED inputs RUN_SERIAL TRUE
  ENVIRONMENT "ACUS_BIN=${CMAKE_BINARY_DIR}/bin")

# Where the system has no driver, whoever asks for a graphics card is told before the session begins.
acus_add_cli_case(acus-live.no_graphics_driver EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "no driver for OpenGL 4.5 was found; install"
  COMMAND ${CMAKE_SOURCE_DIR}/pipelines/common/on_display.sh env __EGL_VENDOR_LIBRARY_DIRS=/nowhere acus-live $INPUTS/scenario.json
  --devices devices/virtual.json ${live_patient} -o s --volume-rays graphics)
# --check refuses what a session would refuse before its first step.
acus_add_cli_case(acus-live.check_output_is_there EXIT 3 NEEDS inputs
  BEFORE "mkdir s && echo mine > s/notes.txt" STDERR "s: exists already; choose another"
  COMMAND acus-live $INPUTS/scenario.json ${virtual} ${live_patient} --check -o s)
acus_add_cli_case(acus-live.check_camera_model_is_missing EXIT 3 NEEDS inputs LEAVES_NOTHING
  BEFORE "sed 's#\"needle\":#\"camera\": {\"place\": \"folder:.\", \"model\": \"cameras/none.json\", \"facets\": \"facets/training.json\"}, &#' ${CMAKE_SOURCE_DIR}/configs/devices/virtual.json > d.json"
  STDERR "cameras/none.json: no such file"
  COMMAND acus-live $INPUTS/scenario.json --devices d.json --headless ${live_patient} --check)
acus_add_cli_case(acus-live.graphics EXIT 0 LEAVES_NOTHING
  STDOUT "^(graphics: .*OpenGL [4-9]|processor: no graphics card .*); (the processor )?renders the volume view"
  COMMAND acus-live --graphics)
