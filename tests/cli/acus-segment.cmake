set(segment_ct "ln -s $INPUTS/ct.nrrd .")
acus_add_cli_case(acus-segment.good EXIT 0 NEEDS inputs TIMEOUT 300 BEFORE "${segment_ct}"
  CREATES out/labels.seg.nrrd out/body.stl out/skin.stl out/bone.stl out/preview_axial.png
          out/preview_coronal.png out/preview_sagittal.png out/report.html out/volumes.csv
          out/provenance.json STDOUT "part  .*why"
  COMMAND acus-segment ct.nrrd -o out)
acus_add_cli_case(acus-segment.no_output EXIT 2 NEEDS inputs LEAVES_NOTHING BEFORE "${segment_ct}"
  STDERR "--output is required" COMMAND acus-segment ct.nrrd)
acus_add_cli_case(acus-segment.missing_ct EXIT 2 LEAVES_NOTHING
  STDERR "none.nrrd" COMMAND acus-segment none.nrrd -o out)
acus_add_cli_case(acus-segment.mapping_alone EXIT 2 NEEDS inputs LEAVES_NOTHING
  BEFORE "${segment_ct}\necho {} > m.json" STDERR "--mapping requires --import"
  COMMAND acus-segment ct.nrrd --mapping m.json -o out)
acus_add_cli_case(acus-segment.atlas_without_file EXIT 3 NEEDS inputs LEAVES_NOTHING
  BEFORE "${segment_ct}\nmkdir atlas" STDERR "atlas/atlas.json"
  COMMAND acus-segment ct.nrrd --atlas atlas -o out)
acus_add_cli_case(acus-segment.atlas_without_ct EXIT 3 NEEDS inputs LEAVES_NOTHING
  BEFORE "${segment_ct}\nmkdir atlas\necho '{\"format\": \"acus-atlas/1\", \"patients\": [{\"name\": \"a\", \"ct\": \"no.nrrd\", \"labels\": \"no.nrrd\"}]}' > atlas/atlas.json"
  STDERR "/patients/0/ct.*no.nrrd does not exist"
  COMMAND acus-segment ct.nrrd --atlas atlas -o out)
acus_add_cli_case(acus-segment.truncated EXIT 3 NEEDS inputs LEAVES_NOTHING
  BEFORE "head -c 3000 $INPUTS/ct.nrrd > cut.nrrd" STDERR "cut.nrrd.*(cut off|broken|cannot be read)"
  COMMAND acus-segment cut.nrrd -o out)
acus_add_cli_case(acus-segment.no_series EXIT 3 LEAVES_NOTHING
  BEFORE "mkdir empty" STDERR "no DICOM image" COMMAND acus-segment empty -o out)
acus_add_cli_case(acus-segment.unknown_setting EXIT 3 NEEDS inputs LEAVES_NOTHING
  BEFORE "${segment_ct}\necho '{\"format\": \"acus-segmentation/1\", \"bones\": {}}' > c.json"
  STDERR "bones.*unknown|unknown.*bones" COMMAND acus-segment ct.nrrd --config c.json -o out)
acus_add_cli_case(acus-segment.certainty EXIT 0 NEEDS inputs TIMEOUT 300 BEFORE "${segment_ct}"
  STDOUT "Unsure: " CREATES out/quality.json out/unsure.nrrd out/preview_unsure.png
  COMMAND acus-segment ct.nrrd --certainty -o out)
acus_add_cli_case(acus-segment.vessels_without_liver EXIT 3 NEEDS inputs TIMEOUT 300 LEAVES_NOTHING
  BEFORE "${segment_ct}" STDERR "--vessels: the labels have no liver"
  COMMAND acus-segment ct.nrrd --vessels -o out)
acus_add_cli_case(acus-segment.vertebra_without_point EXIT 3 NEEDS inputs LEAVES_NOTHING
  BEFORE "${segment_ct}" STDERR "L3.*must be a name and a point"
  COMMAND acus-segment ct.nrrd --vertebra L3 -o out)
acus_add_cli_case(acus-segment.label_map_as_ct EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "is a label map .*a CT in Hounsfield units is needed"
  COMMAND acus-segment $INPUTS/labels.seg.nrrd -o out)
# Label maps made elsewhere: by name, and not if they cannot be of the patient.
acus_add_cli_case(acus-segment.import_by_segments EXIT 0 NEEDS inputs TIMEOUT 300 BEFORE "${segment_ct}"
  STDOUT "labels.seg.nrrd: [0-9]+ structures, by the names of its segments"
  CREATES out/labels.seg.nrrd
  COMMAND acus-segment ct.nrrd --import $INPUTS/labels.seg.nrrd -o out)
set(segment_muscle_as_spleen
    "sed 's/\"muscle\", \"tissue\": \"muscle\"/\"spleen\", \"tissue\": \"spleen\"/' ${CMAKE_SOURCE_DIR}/configs/label_maps/acus.json > m.json")
acus_add_cli_case(acus-segment.import_impossible EXIT 3 NEEDS inputs TIMEOUT 300 LEAVES_NOTHING
  BEFORE "${segment_ct}\n${segment_muscle_as_spleen}"
  STDERR "value 3 is 'muscle' for the file, but 'spleen' for the table"
  COMMAND acus-segment ct.nrrd --import $INPUTS/labels.seg.nrrd --mapping m.json -o out)
acus_add_cli_case(acus-segment.import_impossible_accepted EXIT 0 NEEDS inputs TIMEOUT 300
  BEFORE "${segment_ct}\n${segment_muscle_as_spleen}"
  STDERR "warning: .*labels.seg.nrrd: cannot be labels of the patient" CREATES out/labels.seg.nrrd
  COMMAND acus-segment ct.nrrd --import $INPUTS/labels.seg.nrrd --mapping m.json
          --accept-implausible -o out)
acus_add_cli_case(acus-segment.import_empty_folder EXIT 3 NEEDS inputs TIMEOUT 300 LEAVES_NOTHING
  BEFORE "${segment_ct}\nmkdir masks" STDERR "masks: holds 0 DICOM segmentations or structure sets"
  COMMAND acus-segment ct.nrrd --import masks -o out)
acus_add_cli_case(acus-segment.import_a_ct EXIT 3 NEEDS inputs TIMEOUT 300 LEAVES_NOTHING
  BEFORE "${segment_ct}" STDERR "ct.nrrd: values that are not in the mapping: .* and [0-9]+ more"
  COMMAND acus-segment ct.nrrd --import ct.nrrd -o out)
acus_add_cli_case(acus-segment.accept_without_import EXIT 2 NEEDS inputs LEAVES_NOTHING
  BEFORE "${segment_ct}" STDERR "--accept-implausible requires --import"
  COMMAND acus-segment ct.nrrd --accept-implausible -o out)
acus_add_cli_case(acus-segment.three_mappings_for_two EXIT 2 NEEDS inputs LEAVES_NOTHING
  BEFORE "${segment_ct}\necho {} > m.json" STDERR "one for all, or one for each --import"
  COMMAND acus-segment ct.nrrd --import ct.nrrd --import ct.nrrd --mapping m.json --mapping m.json
          --mapping m.json -o out)
# The lumbar puncture of the demo feels the same with the labels found as with the exact ones.
foreach(seed 1 12)
  add_test(NAME cli.acus-segment.spine_session_${seed}
    COMMAND ${ACUS_BASH} ${CMAKE_CURRENT_SOURCE_DIR}/spine_session.sh
            ${ACUS_CLI_FOLDER}/acus-segment.spine_session_${seed} ${seed})
  set_tests_properties(cli.acus-segment.spine_session_${seed} PROPERTIES LABELS cli TIMEOUT 600
    ENVIRONMENT "ACUS_BIN=${CMAKE_BINARY_DIR}/bin;ACUS_CONFIGS=${CMAKE_SOURCE_DIR}/configs")
endforeach()
# Fascia and capsule of a liver biopsy likewise, on a synthetic patient and on a real CT.
foreach(patient "phantom 1" ircadb01)
  separate_arguments(words UNIX_COMMAND "${patient}")
  string(REPLACE " " "_" name "${patient}")
  add_test(NAME cli.acus-segment.liver_session_${name}
    COMMAND ${ACUS_BASH} ${CMAKE_CURRENT_SOURCE_DIR}/liver_session.sh
            ${ACUS_CLI_FOLDER}/acus-segment.liver_session_${name} ${words})
  set_tests_properties(cli.acus-segment.liver_session_${name} PROPERTIES LABELS cli TIMEOUT 600 COST 600
    SKIP_REGULAR_EXPRESSION "^skipped"
    ENVIRONMENT "ACUS_BIN=${CMAKE_BINARY_DIR}/bin;ACUS_CONFIGS=${CMAKE_SOURCE_DIR}/configs;ACUS_SOURCE=${CMAKE_SOURCE_DIR}")
endforeach()
