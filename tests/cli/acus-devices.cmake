set(devices_session "bash ${CMAKE_CURRENT_LIST_DIR}/devices_inputs.sh")
acus_add_cli_case(acus-devices.play EXIT 0 BEFORE "${devices_session}" LEAVES_NOTHING
  STDOUT "^listening on port [1-9][0-9]+$" "^played 0\\.[0-9]+ s: 10 instants" "^clients: 0 connected"
  COMMAND acus-devices play recording --port 0)
acus_add_cli_case(acus-devices.faster EXIT 0 BEFORE "${devices_session}"
  STDOUT "^played 0\\.[0-9]+ s: 5 instants"
  COMMAND acus-devices play recording --port 0 --speed 10 --rate-hz 50)
acus_add_cli_case(acus-devices.hand EXIT 0 LEAVES_NOTHING STDOUT ": [1-9][0-9]* instants"
  COMMAND acus-devices hand --port 0 --seconds 0.2 --rate-hz 200 --fault drop@0.05:0.05)
acus_add_cli_case(acus-devices.camera EXIT 0 STDOUT "[1-9][0-9]* images"
  COMMAND acus-devices hand --port 0 --seconds 2
          --camera ${CMAKE_SOURCE_DIR}/configs/cameras/webcam_720p.json
                   ${CMAKE_SOURCE_DIR}/configs/facets/training.json)
# The usual end of a program that has none: no error, and the port is free again.
foreach(signal INT TERM)
  acus_add_cli_case(acus-devices.ends_on_sig${signal} EXIT 0 BEFORE "${devices_session}"
    STDOUT "^listening on port" "^played [0-9]" LEAVES_NOTHING
    COMMAND timeout --preserve-status -s ${signal} 2 acus-devices play recording --loop --port 0)
endforeach()
acus_add_cli_case(acus-devices.port_taken EXIT 3 LEAVES_NOTHING
  STDERR "cannot listen on localhost:[0-9]+: Address already in use"
  COMMAND bash ${CMAKE_CURRENT_LIST_DIR}/devices_port_taken.sh)
acus_add_cli_case(acus-devices.bad_fault EXIT 2 LEAVES_NOTHING STDERR "explode@1.*as in occlude@5:2"
  COMMAND acus-devices hand --port 0 --fault explode@1)
acus_add_cli_case(acus-devices.bad_port EXIT 2 LEAVES_NOTHING STDERR "70000"
  COMMAND acus-devices hand --port 70000)
acus_add_cli_case(acus-devices.no_session EXIT 2 LEAVES_NOTHING STDERR "nothing_here"
  COMMAND acus-devices play nothing_here)
acus_add_cli_case(acus-devices.not_a_session EXIT 3 LEAVES_NOTHING BEFORE "echo hello > notes.txt"
  STDERR "notes.txt" COMMAND acus-devices play notes.txt --port 0)
acus_add_cli_case(acus-devices.bad_hand EXIT 3 LEAVES_NOTHING STDERR "0 mm from its entry"
  COMMAND acus-devices hand --port 0 --target 0 0 0)
acus_add_cli_case(acus-devices.short_point EXIT 2 LEAVES_NOTHING STDERR "entry"
  COMMAND acus-devices hand --port 0 --entry 1 2)
