# acus-dataset: labelled images of many patients.
acus_add_cli_case(acus-dataset.png EXIT 0 NEEDS inputs
  STDOUT "^6 images of 2 insertions in 1 patients" "^train: lumbar_1$"
  CREATES d/manifest.json d/frames.csv d/provenance.json d/sequences/00001/images/00002.png
          d/sequences/00001/labels/00002.png d/sequences/00000/labelled.json
          d/sequences/00000/depth_mm.nii.gz d/sequences/00000/probe.json
  COMMAND acus-dataset $INPUTS/dataset.json --seed 3 -o d)
acus_add_cli_case(acus-dataset.nifti EXIT 0 NEEDS inputs
  CREATES d/sequences/00001/images.nii.gz d/sequences/00001/labels.nii.gz
  COMMAND acus-dataset $INPUTS/dataset.json --format nifti -o d)
acus_add_cli_case(acus-dataset.hdf5 EXIT 0 NEEDS inputs CREATES d/sequences/00001/labelled.h5
  COMMAND acus-dataset $INPUTS/dataset.json --format hdf5 -o d)
acus_add_cli_case(acus-dataset.check EXIT 0 NEEDS inputs LEAVES_NOTHING
  STDOUT "^train: lumbar_1$" "^00001  lumbar_1  scenario  "
  COMMAND acus-dataset $INPUTS/dataset.json --check)
acus_add_cli_case(acus-dataset.no_output EXIT 2 NEEDS inputs LEAVES_NOTHING
  STDERR "--output is required" COMMAND acus-dataset $INPUTS/dataset.json)
acus_add_cli_case(acus-dataset.wrong_format EXIT 2 NEEDS inputs LEAVES_NOTHING
  STDERR "--format" "jpeg" COMMAND acus-dataset $INPUTS/dataset.json --format jpeg -o d)
acus_add_cli_case(acus-dataset.no_such_file EXIT 3 LEAVES_NOTHING
  STDERR "nowhere.json" COMMAND acus-dataset nowhere.json -o d)
acus_add_cli_case(acus-dataset.mistyped_range EXIT 3
  BEFORE "echo '{\"format\": \"acus-dataset/1\", \"patients\": [{\"id\": \"a\"}], \"ranges\": {\"gain_db\": [0, 1]}}' > d.json"
  STDERR "d.json" "/ranges/gain_db: unknown key. known here: .*gain_offset_db" COMMAND acus-dataset d.json -o d)
acus_add_cli_case(acus-dataset.three_splits_of_one_patient EXIT 3
  BEFORE "echo '{\"format\": \"acus-dataset/1\", \"patients\": [{\"id\": \"a\"}]}' > d.json"
  STDERR "d.json: /splits: 3 splits for 1 patients. each needs one of its own"
  COMMAND acus-dataset d.json -o d)
acus_add_cli_case(acus-dataset.patient_without_corridor EXIT 3 NEEDS inputs
  BEFORE "echo '{\"format\": \"acus-dataset/1\", \"scenarios\": [\"'$INPUTS'/scenario.json\"], \"patients\": [{\"id\": \"a\", \"ct\": \"'$INPUTS'/ct.nrrd\", \"labels\": \"'$INPUTS'/labels.seg.nrrd\"}], \"splits\": {\"train\": 1, \"validation\": 0, \"test\": 0}}' > d.json"
  STDERR "/patient/corridor: is missing" COMMAND acus-dataset d.json -o d)
acus_add_cli_case(acus-dataset.existing_folder EXIT 3 NEEDS inputs LEAVES_NOTHING
  BEFORE "mkdir d && touch d/mine" STDERR "d: " COMMAND acus-dataset $INPUTS/dataset.json --overwrite -o d)
