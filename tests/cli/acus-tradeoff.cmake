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
  STDOUT "^case step_rate_hz-500-r0 after step_rate_hz-2000-r0" "^Omitted: force_model=tissue"
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
${CMAKE_SOURCE_DIR}/pipelines/sweep --jobs 2 ${subject_text} --images 3 --knob step_rate_hz=500,2000 --knob ultrasound_model=columns_2010,beams --repetitions 2 -o parallel > table 2>&1
grep -q 'Taken up: 8 of 8 runs were there' table"
    COMMAND ${ACUS_BASH} ${CMAKE_CURRENT_LIST_DIR}/same_errors.sh serial/tradeoff.csv parallel/tradeoff.csv)
  acus_add_cli_case(acus-tradeoff.scene_parallel_typo EXIT 3 NEEDS inputs LEAVES_NOTHING
    STDERR "did you mean step_rate_hz[?]"
    COMMAND ${ACUS_BASH} ${CMAKE_SOURCE_DIR}/pipelines/sweep --jobs 2 ${subject} --knob step_rate -o t)
endif()

# The setting for a budget, for an accuracy, for a live session.
set(short ${scene} --seconds 1 --images 4 --repetitions 1)
list(JOIN short " " short_text)
set(bending --set /effects/needle_force/model=tissue --set /effects/tissue/model=springs
    --set /effects/needle/model=bendable --knob needle_nodes --knob tissue_warp_spacing_mm)
list(JOIN bending " " bending_text)
acus_add_cli_case(acus-tradeoff.scene_budget EXIT 0 NEEDS inputs TIMEOUT 120
  STDOUT "^Chosen for force=1000ms,image=1000ms among [0-9]+ settings measured: "
         "^It takes .* of 1000 ms per force step"
         "^Of an image B-mode takes" "^Written: b/scenario.json"
  CREATES b/scenario.json b/tradeoff.html b/tradeoff.csv b/provenance.json
  COMMAND acus-tradeoff ${short} ${bending} --budget force=1s,image=1s -o b)
acus_add_cli_case(acus-tradeoff.scene_budget_is_replayed EXIT 0 NEEDS inputs TIMEOUT 120
  BEFORE "$ACUS_BIN/acus-tradeoff ${short_text} ${bending_text} --budget image=1s -o b > /dev/null 2>&1
mkdir elsewhere && mv b/scenario.json elsewhere"
  STDOUT "^Values chosen by acus-tradeoff --budget image=1s, predicted on " "image, median: .* predicted" CREATES run/run.json
  COMMAND acus-replay elsewhere/scenario.json $INPUTS/session --no-film --png none -o run)
acus_add_cli_case(acus-tradeoff.scene_accuracy EXIT 0 NEEDS inputs TIMEOUT 120
  STDOUT "^Chosen for image=20dB among" CREATES b/scenario.json
  COMMAND acus-tradeoff ${short} ${bending} --accuracy image=20dB -o b)
acus_add_cli_case(acus-tradeoff.scene_impossible_budget EXIT 4 NEEDS inputs TIMEOUT 120
  STDERR "None of the [0-9]+ settings measured fits image=0.001ms" "The cheapest .* takes "
         "^Of an image B-mode takes"
  CREATES b/tradeoff.html
  COMMAND acus-tradeoff ${short} ${bending} --budget image=1us -o b)
acus_add_cli_case(acus-tradeoff.scene_live EXIT 0 NEEDS inputs TIMEOUT 120
  STDOUT "^Yes, this machine runs the scene live: .* of 1 ms per force step"
  CREATES b/scenario.json
  COMMAND acus-tradeoff ${short} ${bending} --live -o b)
acus_add_cli_case(acus-tradeoff.scene_broken_budget EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "'abc' of force does not begin with a number" "force=0.5ms,image=16ms"
  COMMAND acus-tradeoff ${scene} --budget force=abc -o b)
acus_add_cli_case(acus-tradeoff.scene_budget_and_accuracy EXIT 2 NEEDS inputs LEAVES_NOTHING
  STDERR "--accuracy excludes --budget|--budget excludes --accuracy"
  COMMAND acus-tradeoff ${scene} --budget force=1ms --accuracy force=1N -o b)
acus_add_cli_case(acus-tradeoff.scene_budget_for_a_rate EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "step_rate_hz.*said by the device"
  COMMAND acus-tradeoff ${scene} --budget force=1ms --knob step_rate_hz -o b)
acus_add_cli_case(acus-tradeoff.scene_budget_without_knobs EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "calls for nothing that can be simulated coarser or finer by a number"
  COMMAND acus-tradeoff ${scene} --set /effects/ultrasound=null --budget force=1ms -o b)
acus_add_cli_case(acus-tradeoff.unknown_command EXIT 2 LEAVES_NOTHING
  STDERR "unknown command .scenes." "Did you mean scene[?]"
  COMMAND acus-tradeoff scenes -o t)
