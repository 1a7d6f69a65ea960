acus_add_cli_case(acus-tradeoff.tissue EXIT 0 TIMEOUT 300
  STDOUT "^element_size_mm" "default$" "paper$"
  CREATES t/tradeoff.csv t/tradeoff.json t/tradeoff.svg t/tradeoff.html t/provenance.json
  COMMAND acus-tradeoff tissue --quick -o t)
acus_add_cli_case(acus-tradeoff.errors_fall EXIT 0 TIMEOUT 300
  BEFORE "$ACUS_BIN/acus-tradeoff tissue --quick --quiet -o t > table.txt
${CMAKE_CURRENT_LIST_DIR}/check_tradeoff.sh t/tradeoff.csv"
  COMMAND acus-tradeoff --version)
acus_add_cli_case(acus-tradeoff.image EXIT 0 TIMEOUT 120 STDOUT "^lines" "^elevation_planes" "default$"
  CREATES t/tradeoff.csv t/tradeoff.json t/tradeoff.svg t/tradeoff.html t/provenance.json
  COMMAND acus-tradeoff image --quick -o t)
acus_add_cli_case(acus-tradeoff.needle EXIT 0 TIMEOUT 120 STDOUT "^num_nodes" "^step_ms" "default$"
  CREATES t/tradeoff.csv t/tradeoff.json t/tradeoff.svg t/tradeoff.html t/provenance.json
  COMMAND acus-tradeoff needle --quick -o t)
acus_add_cli_case(acus-tradeoff.forces EXIT 0 TIMEOUT 120
  STDOUT "^friction, explicit Euler: step_ms" "^level" "UNUSABLE" "default$"
  CREATES t/tradeoff.csv t/tradeoff.json t/tradeoff.svg t/tradeoff.html t/provenance.json
  COMMAND acus-tradeoff forces --quick -o t)
acus_add_cli_case(acus-tradeoff.breathing EXIT 0 TIMEOUT 120
  STDOUT "^field_nodes" "^key_frames" "^model" "^haptic_iterations" "^pixel_iterations" "default$" "paper$"
  CREATES t/tradeoff.csv t/tradeoff.json t/tradeoff.svg t/tradeoff.html t/provenance.json
  COMMAND acus-tradeoff breathing --quick -o t)
acus_add_cli_case(acus-tradeoff.probe EXIT 0 TIMEOUT 120 STDOUT "^proxies, face on round skin" "default$"
  CREATES t/tradeoff.csv t/tradeoff.json t/tradeoff.svg t/tradeoff.html t/provenance.json
  COMMAND acus-tradeoff probe --quick -o t)
acus_add_cli_case(acus-tradeoff.views EXIT 0 TIMEOUT 120
  STDOUT "^fluoroscopy: detail" "^volume rendering: ray step_mm, skin" "default$"
  CREATES t/tradeoff.csv t/tradeoff.json t/tradeoff.svg t/tradeoff.html t/provenance.json
  COMMAND acus-tradeoff views --quick -o t)
acus_add_cli_case(acus-tradeoff.registration EXIT 0 TIMEOUT 120 STDOUT "^spacing_mm" "^wall" "default$"
  CREATES t/tradeoff.csv t/tradeoff.json t/tradeoff.svg t/tradeoff.html t/provenance.json
  COMMAND acus-tradeoff registration --quick -o t)
acus_add_cli_case(acus-tradeoff.unknown_sweep EXIT 2 LEAVES_NOTHING STDERR "tissues" "tissue"
  COMMAND acus-tradeoff tissues -o t)
acus_add_cli_case(acus-tradeoff.no_output EXIT 2 LEAVES_NOTHING STDERR "--output"
  COMMAND acus-tradeoff tissue)
acus_add_cli_case(acus-tradeoff.folder_exists EXIT 3 LEAVES_NOTHING BEFORE "mkdir t\necho mine > t/notes.txt"
  STDERR "--overwrite" COMMAND acus-tradeoff tissue --quick -o t)
