# Sweeps of single models: what measures the product, not the product.
acus_add_cli_case(model_sweeps.tissue EXIT 0 TIMEOUT 300
  STDOUT "^element_size_mm" "default$" "paper$"
  CREATES t/tradeoff.csv t/tradeoff.json t/tradeoff.svg t/tradeoff.html t/provenance.json
  COMMAND ${CMAKE_BINARY_DIR}/tests/model_sweeps tissue --quick -o t)
acus_add_cli_case(model_sweeps.errors_fall EXIT 0 TIMEOUT 300
  BEFORE "$ACUS_BIN/../tests/model_sweeps tissue --quick --quiet -o t > table.txt
${CMAKE_CURRENT_LIST_DIR}/check_tradeoff.sh t/tradeoff.csv"
  COMMAND ${CMAKE_BINARY_DIR}/tests/model_sweeps --version)
acus_add_cli_case(model_sweeps.image EXIT 0 TIMEOUT 120 STDOUT "^lines" "^elevation_planes" "default$"
  CREATES t/tradeoff.csv t/tradeoff.json t/tradeoff.svg t/tradeoff.html t/provenance.json
  COMMAND ${CMAKE_BINARY_DIR}/tests/model_sweeps image --quick -o t)
acus_add_cli_case(model_sweeps.needle EXIT 0 TIMEOUT 120 STDOUT "^num_nodes" "^step_ms" "default$"
  CREATES t/tradeoff.csv t/tradeoff.json t/tradeoff.svg t/tradeoff.html t/provenance.json
  COMMAND ${CMAKE_BINARY_DIR}/tests/model_sweeps needle --quick -o t)
acus_add_cli_case(model_sweeps.fluid EXIT 0 TIMEOUT 120 STDOUT "^num_shells" "^step_ms" "default$"
  CREATES t/tradeoff.csv t/tradeoff.json t/tradeoff.svg t/tradeoff.html t/provenance.json
  COMMAND ${CMAKE_BINARY_DIR}/tests/model_sweeps fluid --quick -o t)
acus_add_cli_case(model_sweeps.forces EXIT 0 TIMEOUT 120
  STDOUT "^friction, explicit Euler: step_ms" "^model" "UNUSABLE" "default$"
  CREATES t/tradeoff.csv t/tradeoff.json t/tradeoff.svg t/tradeoff.html t/provenance.json
  COMMAND ${CMAKE_BINARY_DIR}/tests/model_sweeps forces --quick -o t)
acus_add_cli_case(model_sweeps.breathing EXIT 0 TIMEOUT 120
  STDOUT "^field_nodes" "^key_frames" "^model" "^haptic_iterations" "^pixel_iterations" "default$" "paper$"
  CREATES t/tradeoff.csv t/tradeoff.json t/tradeoff.svg t/tradeoff.html t/provenance.json
  COMMAND ${CMAKE_BINARY_DIR}/tests/model_sweeps breathing --quick -o t)
acus_add_cli_case(model_sweeps.probe EXIT 0 TIMEOUT 120 STDOUT "^proxies, face on round skin" "default$"
  CREATES t/tradeoff.csv t/tradeoff.json t/tradeoff.svg t/tradeoff.html t/provenance.json
  COMMAND ${CMAKE_BINARY_DIR}/tests/model_sweeps probe --quick -o t)
acus_add_cli_case(model_sweeps.views EXIT 0 TIMEOUT 120
  STDOUT "^fluoroscopy: detail" "^volume rendering: ray step_mm, skin" "default$"
  CREATES t/tradeoff.csv t/tradeoff.json t/tradeoff.svg t/tradeoff.html t/provenance.json
  COMMAND ${CMAKE_BINARY_DIR}/tests/model_sweeps views --quick -o t)
acus_add_cli_case(model_sweeps.registration EXIT 0 TIMEOUT 120 STDOUT "^spacing_mm" "^wall" "default$"
  CREATES t/tradeoff.csv t/tradeoff.json t/tradeoff.svg t/tradeoff.html t/provenance.json
  COMMAND ${CMAKE_BINARY_DIR}/tests/model_sweeps registration --quick -o t)
acus_add_cli_case(model_sweeps.machine EXIT 0 CREATES machine.json
  COMMAND ${CMAKE_BINARY_DIR}/tests/model_sweeps machine -o machine.json)
acus_add_cli_case(model_sweeps.unknown_sweep EXIT 2 LEAVES_NOTHING
  STDERR "unknown command .tissues." "Did you mean tissue[?]"
  COMMAND ${CMAKE_BINARY_DIR}/tests/model_sweeps tissues -o t)
acus_add_cli_case(model_sweeps.no_output EXIT 2 LEAVES_NOTHING STDERR "--output"
  COMMAND ${CMAKE_BINARY_DIR}/tests/model_sweeps tissue)
acus_add_cli_case(model_sweeps.folder_exists EXIT 3 LEAVES_NOTHING BEFORE "mkdir t\necho mine > t/notes.txt"
  STDERR "--overwrite" COMMAND ${CMAKE_BINARY_DIR}/tests/model_sweeps tissue --quick -o t)

acus_add_cli_case(model_sweeps.enough EXIT 0 TIMEOUT 120
  STDOUT "^element_size_mm: no setting measured is enough for 0.05 N; the nearest, 6, is"
         "^contact_spacing_mm: 3 is enough for 0.05 N"
  CREATES t/tradeoff.html COMMAND ${CMAKE_BINARY_DIR}/tests/model_sweeps tissue --quick --accuracy force=50mN -o t)
acus_add_cli_case(model_sweeps.enough_of_what EXIT 3 LEAVES_NOTHING
  STDERR "errors of forces only" COMMAND ${CMAKE_BINARY_DIR}/tests/model_sweeps tissue --quick --accuracy image=30dB -o t)
