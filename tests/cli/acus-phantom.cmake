# A small patient; the full example of --help is run by run_examples.sh.
set(small ${CMAKE_SOURCE_DIR}/testdata/small_lumbar.json)
acus_add_cli_case(acus-phantom.patient EXIT 0
  CREATES p/ct.nrrd p/labels.seg.nrrd p/truth.json p/markers_ct.csv p/markers_mannequin.csv
          p/target_ct.csv p/force_curves p/sessions/insertion/needle.csv p/provenance.json
  COMMAND acus-phantom patient lumbar --config ${small} --seed 3 --quiet -o p)
acus_add_cli_case(acus-phantom.scene EXIT 0 NEEDS inputs
  CREATES s/truth.json s/markers_ct.csv s/markers_mannequin.csv s/target_ct.csv
          s/sessions/insertion/probe.csv s/provenance.json
  BEFORE "ln -s $INPUTS/labels.seg.nrrd ."
  COMMAND acus-phantom scene labels.seg.nrrd -o s --quiet)
acus_add_cli_case(acus-phantom.unknown_patient EXIT 2 LEAVES_NOTHING
  STDERR "lumbar" COMMAND acus-phantom patient lumber -o p)
acus_add_cli_case(acus-phantom.no_kind EXIT 2 LEAVES_NOTHING
  STDERR "kind is required" COMMAND acus-phantom patient -o p)
acus_add_cli_case(acus-phantom.missing_config EXIT 2 LEAVES_NOTHING
  STDERR "none.json" COMMAND acus-phantom patient lumbar --config none.json -o p)
acus_add_cli_case(acus-phantom.misspelt_key EXIT 3
  BEFORE "sed s/clearance_mm/clearence_mm/ ${small} > c.json"
  STDERR "c.json" "/insertion" "clearance_mm"
  COMMAND acus-phantom patient lumbar --config c.json -o p)
acus_add_cli_case(acus-phantom.cut_config EXIT 3
  BEFORE "head -c 300 ${small} > c.json"
  STDERR "c.json" COMMAND acus-phantom patient lumbar --config c.json -o p)
acus_add_cli_case(acus-phantom.unknown_landmark EXIT 3 BEFORE "sed s/canal_L3L4/canal_L9L9/ ${small} > c.json"
  STDERR "canal_L9L9" "canal_L3L4" COMMAND acus-phantom patient lumbar --config c.json --quiet -o p)
acus_add_cli_case(acus-phantom.no_way EXIT 4
  BEFORE "sed 's/0.20, 0.88, -0.42/0, -1, 0/' ${small} > c.json"
  STDERR "no free straight path" "cone_deg"
  COMMAND acus-phantom patient lumbar --config c.json --quiet -o p)
acus_add_cli_case(acus-phantom.scene_of_rubbish EXIT 3 LEAVES_NOTHING
  BEFORE "head -c 500 ${small} > labels.seg.nrrd"
  STDERR "labels.seg.nrrd" COMMAND acus-phantom scene labels.seg.nrrd -o s)
acus_add_cli_case(acus-phantom.warp EXIT 0 NEEDS inputs
  CREATES p/phase_00.nrrd p/phase_03.nrrd p/deeper.nrrd p/phases.csv p/signal.csv p/landmarks.csv
          p/truth/phase_00.nrrd p/cavity.seg.nrrd p/motion_truth.json p/provenance.json
  COMMAND acus-phantom warp $INPUTS/liver_patient/ct.nrrd --quiet --phases 4 --diaphragm-mm 35
          --labels $INPUTS/liver_patient/labels.seg.nrrd -o p)
acus_add_cli_case(acus-phantom.warp_without_lung EXIT 3 NEEDS inputs
  STDERR "diaphragm"
  COMMAND acus-phantom warp $INPUTS/ct.nrrd --labels $INPUTS/labels.seg.nrrd --quiet -o p)
acus_add_cli_case(acus-phantom.warp_other_labels EXIT 3 NEEDS inputs
  STDERR "another grid"
  COMMAND acus-phantom warp $INPUTS/liver_patient/ct.nrrd --labels $INPUTS/labels.seg.nrrd --quiet -o p)
# Targets and windows, on the small lumbar patient.
set(scene_labels "ln -s $INPUTS/labels.seg.nrrd .")
acus_add_cli_case(acus-phantom.scene_of_a_structure EXIT 0 NEEDS inputs BEFORE "${scene_labels}"
  CREATES s/truth.json s/corridor_ct.csv s/sessions/insertion/needle.csv
  STDOUT "^Target: spinal_canal, [0-9.]+ mm inside it" "^Window: paramedian" "^Path: [0-9.]+ mm from"
         "^Passes through: skin .*spinal_canal" "^First attempt: " "^Session: insertion"
  COMMAND acus-phantom scene labels.seg.nrrd --target spinal_canal -o s)
acus_add_cli_case(acus-phantom.scene_through_a_window EXIT 0 NEEDS inputs BEFORE "${scene_labels}"
  CREATES s/truth.json STDOUT "^Window: transverse"
  COMMAND acus-phantom scene labels.seg.nrrd --window transverse -o s --quiet)
acus_add_cli_case(acus-phantom.scene_of_an_unknown_structure EXIT 3 LEAVES_NOTHING NEEDS inputs
  BEFORE "${scene_labels}" STDERR "no spinal_cannal" "did you mean 'spinal_canal'" "It has .*fat"
  COMMAND acus-phantom scene labels.seg.nrrd --target spinal_cannal -o s)
acus_add_cli_case(acus-phantom.scene_of_bone EXIT 3 LEAVES_NOTHING NEEDS inputs
  BEFORE "${scene_labels}" STDERR "--target bone: a needle does not end there"
  COMMAND acus-phantom scene labels.seg.nrrd --target bone -o s)
acus_add_cli_case(acus-phantom.scene_outside_the_volume EXIT 3 LEAVES_NOTHING NEEDS inputs
  BEFORE "${scene_labels}" STDERR "--target 0,0,900: lies outside the volume, which reaches from"
  COMMAND acus-phantom scene labels.seg.nrrd --target 0,0,900 -o s)
acus_add_cli_case(acus-phantom.scene_of_an_unknown_window EXIT 2 LEAVES_NOTHING NEEDS inputs
  BEFORE "${scene_labels}" STDERR "--window" "paramedian"
  COMMAND acus-phantom scene labels.seg.nrrd --window paramedial -o s)
acus_add_cli_case(acus-phantom.scene_of_a_blocked_window EXIT 4 LEAVES_NOTHING NEEDS inputs
  BEFORE "${scene_labels}"
  STDERR "no free path leads to \\(0,9.5,36\\) through the window anterior" "% meet bone" "free: --window"
  COMMAND acus-phantom scene labels.seg.nrrd --target 0,9.5,36 --window anterior -o s --quiet)
# Vessels, ducts and a lesion in the small liver patient, and a scene on them.
acus_add_cli_case(acus-phantom.ducts EXIT 0 NEEDS inputs
  STDOUT "^Vessels: [0-9]+ tubes" "^Bile ducts: [0-9]+ tubes" "^Lesion: at "
  CREATES d/ct.nrrd d/labels.seg.nrrd d/ducts.csv d/ducts.json d/provenance.json
  COMMAND acus-phantom ducts $INPUTS/liver_patient/ct.nrrd --seed 2 --lesion-mm 12 12 12
          --labels $INPUTS/liver_patient/labels.seg.nrrd --vessel-mm 8 --duct-mm 6 -o d)
acus_add_cli_case(acus-phantom.ducts_other_labels EXIT 3 LEAVES_NOTHING NEEDS inputs
  STDERR "another grid"
  COMMAND acus-phantom ducts $INPUTS/liver_patient/ct.nrrd --labels $INPUTS/labels.seg.nrrd -o d)
acus_add_cli_case(acus-phantom.ducts_too_large EXIT 4 LEAVES_NOTHING NEEDS inputs
  STDERR "a lesion with a radius of 100 mm" "fits nowhere into the liver"
  COMMAND acus-phantom ducts $INPUTS/liver_patient/ct.nrrd --lesion-mm 200 200 200
          --labels $INPUTS/liver_patient/labels.seg.nrrd -o d)
acus_add_cli_case(acus-phantom.ducts_in_a_session EXIT 0 NEEDS inputs TIMEOUT 300
  STDOUT "largest axial force: [0-9.]+ N" CREATES run/report.html
  BEFORE "acus-phantom ducts $INPUTS/liver_patient/ct.nrrd --labels $INPUTS/liver_patient/labels.seg.nrrd --seed 2 --vessel-mm 8 --duct-mm 6 -o d\nacus-phantom scene d/labels.seg.nrrd --target gallbladder -o s\nacus-register --from s/markers_mannequin.csv --to s/markers_ct.csv --target s/target_ct.csv -o r\nacus-breathing --single d/ct.nrrd --labels d/labels.seg.nrrd --model surrogate --resolution 24 -o motion"
  COMMAND bash -c "acus-replay scenarios/fortmeier_2016.json s/sessions/insertion --ct d/ct.nrrd --labels d/labels.seg.nrrd --transform r/ct_from_reference.tfm --set /patient/corridor=$PWD/s/corridor_ct.csv --set /effects/breathing/motion=$PWD/motion --set /effects/ultrasound=null --set /effects/ct_slice=null --set /effects/fluoroscopy=null --set /effects/view_3d=null -o run")
acus_add_cli_case(acus-phantom.scene_at_a_height_without_vertebrae EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "vertebrae.csv, which does not exist; acus-segment writes it"
  COMMAND acus-phantom scene $INPUTS/labels.seg.nrrd --target L3-L4 -o s)
