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
acus_add_cli_case(acus-tradeoff.unknown_sweep EXIT 2 LEAVES_NOTHING
  STDERR "unknown command .tissues." "Did you mean tissue[?]"
  COMMAND acus-tradeoff tissues -o t)
acus_add_cli_case(acus-tradeoff.no_output EXIT 2 LEAVES_NOTHING STDERR "--output"
  COMMAND acus-tradeoff tissue)
acus_add_cli_case(acus-tradeoff.folder_exists EXIT 3 LEAVES_NOTHING BEFORE "mkdir t\necho mine > t/notes.txt"
  STDERR "--overwrite" COMMAND acus-tradeoff tissue --quick -o t)

# The knobs of a scenario over a session.
set(subject $INPUTS/scenario.json $INPUTS/session --ct $INPUTS/ct.nrrd
    --labels $INPUTS/labels.seg.nrrd --transform $INPUTS/ct_from_reference.tfm)
list(JOIN subject " " subject_text)
set(scene scene ${subject})
set(scene_text "scene ${subject_text}")
acus_add_cli_case(acus-tradeoff.scene EXIT 0 NEEDS inputs TIMEOUT 120
  STDOUT "^step_rate_hz +step us" " reference$"
         "^step_rate_hz 500 instead of 2000: force [0-9.]+ N RMS more error"
  CREATES t/tradeoff.csv t/tradeoff.json t/provenance.json t/plan.json
  COMMAND acus-tradeoff ${scene} --knob step_rate_hz=500,2000 --repetitions 2 -o t)
acus_add_cli_case(acus-tradeoff.scene_taken_up EXIT 0 NEEDS inputs TIMEOUT 120
  BEFORE "$ACUS_BIN/acus-tradeoff ${scene_text} --seconds 2 --knob step_rate_hz=500,2000 -o t > /dev/null 2>&1
rm t/runs/step_rate_hz-500-r1.json"
  STDOUT "Taken up: 5 of 6 runs were there"
  COMMAND acus-tradeoff ${scene} --seconds 2 --knob step_rate_hz=500,2000 -o t)
acus_add_cli_case(acus-tradeoff.scene_other_plan EXIT 3 NEEDS inputs TIMEOUT 120 LEAVES_NOTHING
  BEFORE "$ACUS_BIN/acus-tradeoff ${scene_text} --seconds 1 --knob step_rate_hz=500,2000 --repetitions 1 -o t > /dev/null 2>&1"
  STDERR "/to_s: 1.0 there, 2.0 now" "--overwrite"
  COMMAND acus-tradeoff ${scene} --seconds 2 --knob step_rate_hz=500,2000 --repetitions 1 -o t)
acus_add_cli_case(acus-tradeoff.scene_list EXIT 0 NEEDS inputs LEAVES_NOTHING
  STDOUT "^case step_rate_hz-500-r0 after step_rate_hz-2000-r0" "^Left out: force_model=tissue"
  COMMAND acus-tradeoff ${scene} --list --knob step_rate_hz=500,2000 --knob force_model)
acus_add_cli_case(acus-tradeoff.scene_knob_typo EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "did you mean step_rate_hz[?]" "ultrasound_model"
  COMMAND acus-tradeoff ${scene} --knob step_rate -o t)
acus_add_cli_case(acus-tradeoff.scene_level_typo EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "did you mean beams[?]" "vidal_2008, alamilla_2021, columns_2010, beams"
  COMMAND acus-tradeoff ${scene} --knob ultrasound_model=columns_2010,beam -o t)
acus_add_cli_case(acus-tradeoff.scene_no_output EXIT 2 NEEDS inputs LEAVES_NOTHING STDERR "--output"
  COMMAND acus-tradeoff ${scene})
acus_add_cli_case(acus-tradeoff.scene_not_a_sweep EXIT 3 NEEDS inputs
  BEFORE "mkdir t && echo mine > t/notes.txt" STDERR "no folder of a sweep"
  COMMAND acus-tradeoff ${scene} --knob step_rate_hz -o t --overwrite)
acus_add_cli_case(acus-tradeoff.scene_case_by_case EXIT 0 NEEDS inputs TIMEOUT 120
  BEFORE "$ACUS_BIN/acus-tradeoff ${scene_text} --seconds 3 --knob step_rate_hz=500,2000 --repetitions 1 -o t --list > list
! test -e t/tradeoff.csv
$ACUS_BIN/acus-tradeoff ${scene_text} --seconds 3 --knob step_rate_hz=500,2000 --repetitions 1 -o t --case step_rate_hz-500-r0"
  STDOUT "^case step_rate_hz-500-r0 after step_rate_hz-2000-r0 .there." "^case step_rate_hz-2000-r0 .there."
  COMMAND acus-tradeoff ${scene} --seconds 3 --knob step_rate_hz=500,2000 --repetitions 1 -o t --list)
# Killed in the middle, it goes on: the same errors as in one go.
acus_add_cli_case(acus-tradeoff.scene_killed EXIT 0 NEEDS inputs TIMEOUT 300 STDOUT "^Taken up"
  COMMAND ${ACUS_BASH} ${CMAKE_CURRENT_LIST_DIR}/kill_sweep.sh ${subject} --images 3
          --knob step_rate_hz=500,2000 --knob ultrasound_model=columns_2010,beams --repetitions 2)
find_program(ACUS_SNAKEMAKE snakemake)
if(ACUS_SNAKEMAKE)
  # Several at a time, by Snakemake: the same errors as one after the other.
  acus_add_cli_case(acus-tradeoff.scene_parallel EXIT 0 NEEDS inputs TIMEOUT 300
    BEFORE "$ACUS_BIN/acus-tradeoff ${scene_text} --images 3 --knob step_rate_hz=500,2000 --knob ultrasound_model=columns_2010,beams --repetitions 2 -o serial > /dev/null 2>&1
${CMAKE_SOURCE_DIR}/pipelines/tradeoff --jobs 2 ${subject_text} --images 3 --knob step_rate_hz=500,2000 --knob ultrasound_model=columns_2010,beams --repetitions 2 -o parallel > table 2>&1
grep -q 'Taken up: 8 of 8 runs were there' table"
    COMMAND ${ACUS_BASH} ${CMAKE_CURRENT_LIST_DIR}/same_errors.sh serial/tradeoff.csv parallel/tradeoff.csv)
  acus_add_cli_case(acus-tradeoff.scene_parallel_typo EXIT 3 NEEDS inputs LEAVES_NOTHING
    STDERR "did you mean step_rate_hz[?]"
    COMMAND ${ACUS_BASH} ${CMAKE_SOURCE_DIR}/pipelines/tradeoff --jobs 2 ${subject} --knob step_rate -o t)
endif()
