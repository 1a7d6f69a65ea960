# acus-replay: what a user gets, and what he is told when something is wrong.
set(patient --ct $INPUTS/ct.nrrd --labels $INPUTS/labels.seg.nrrd
    --transform $INPUTS/ct_from_reference.tfm)

acus_add_cli_case(acus-replay.run EXIT 0 NEEDS inputs
  STDOUT "^Replayed " "^Report: run/report.html"
  CREATES run/report.html run/forces.csv run/events.csv run/images.igs.mha run/film.mp4 run/metrics.json
          run/run.json run/provenance.json
  COMMAND acus-replay $INPUTS/scenario.json $INPUTS/session ${patient} -o run)
acus_add_cli_case(acus-replay.explain EXIT 0 NEEDS inputs LEAVES_NOTHING
  STDOUT "effect ultrasound is called for" "us/run" "^CT slice +image +out"
  COMMAND acus-replay scenarios/lumbar_puncture.json $INPUTS/session ${patient} --explain
          --set /effects/ct_slice=null)
# Labels of which acus-segment is not sure: the scenario states it when it is loaded, and so does its report.
acus_add_cli_case(acus-replay.unsure_labels EXIT 0 NEEDS inputs
  BEFORE "ln -s $INPUTS/labels.seg.nrrd .\necho '{\"format\": \"acus-segmentation-quality/1\", \"parts\": [{\"name\": \"kidney_left\", \"sure\": false, \"in_labels\": true, \"why\": \"larger than 270 ml\"}, {\"name\": \"bone\", \"sure\": true, \"in_labels\": true, \"why\": \"\"}]}' > quality.json"
  STDERR "warning: unsure in the labels of this patient: kidney_left .larger than 270 ml.\\. "
  COMMAND bash -c "acus-replay $INPUTS/scenario.json $INPUTS/session --ct $INPUTS/ct.nrrd --labels labels.seg.nrrd --transform $INPUTS/ct_from_reference.tfm -o run --set /effects/ultrasound=null --set /effects/ct_slice=null && grep -q 'kidney_left (larger than 270 ml)' run/report.html && grep -q 'kidney_left (larger than 270 ml)' run/run.json")
# A nick in the skin, at the corridor's entry: read only where it is called for.
acus_add_cli_case(acus-replay.skin_nick EXIT 0 NEEDS inputs LEAVES_NOTHING
  STDOUT "^needle force +force +needle, tissue, needle preset, force table, corridor"
  COMMAND acus-replay $INPUTS/scenario.json $INPUTS/session ${patient} --explain
          --set /effects/needle_force/skin_nick_radius_mm=3 --set /patient/corridor=$INPUTS/corridor_ct.csv)
acus_add_cli_case(acus-replay.skin_nick_without_a_corridor EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "needle force.* needs corridor"
  COMMAND acus-replay $INPUTS/scenario.json $INPUTS/session ${patient} -o r
          --set /effects/needle_force/skin_nick_radius_mm=3)
acus_add_cli_case(acus-replay.skin_nick_in_deformed_tissue EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "skin_nick_radius_mm: only the models layered, alamilla and vidal have a nick"
  COMMAND acus-replay scenarios/liver_biopsy_finite_strain.json $INPUTS/session ${patient} -o r
          --set /effects/needle_force/skin_nick_radius_mm=3)
acus_add_cli_case(acus-replay.preset_of_measured_forces EXIT 0 NEEDS inputs
  STDOUT "largest axial force: [1-9]" "punctures: [1-9]" CREATES r/forces.csv
  COMMAND acus-replay scenarios/liver_biopsy_measured.json $INPUTS/session ${patient} -o r
          --set /effects/ultrasound=null --set /effects/ct_slice=null)
acus_add_cli_case(acus-replay.preset_of_viscoelastic_forces EXIT 0 NEEDS inputs
  STDOUT "largest axial force: [1-9]" "punctures: [1-9]" CREATES r/forces.csv
  COMMAND acus-replay scenarios/liver_biopsy_viscoelastic.json $INPUTS/session ${patient} -o r
          --set /effects/ultrasound=null --set /effects/ct_slice=null)
foreach(model springs 2d)
  acus_add_cli_case(acus-replay.preset_of_viscoelastic_${model} EXIT 0 NEEDS inputs
    STDOUT "largest axial force: [1-9]" "punctures: [1-9]" CREATES r/forces.csv
    COMMAND acus-replay scenarios/liver_biopsy_viscoelastic_${model}.json $INPUTS/session ${patient} -o r
            --set /patient/corridor=$INPUTS/corridor_ct.csv
            --set /effects/ultrasound=null --set /effects/ct_slice=null)
endforeach()
acus_add_cli_case(acus-replay.elastic_table_that_would_flow EXIT 3 NEEDS inputs LEAVES_NOTHING
  BEFORE "sed 's/0.43/0.7/' \"${CMAKE_SOURCE_DIR}/configs/elasticity/viscoelastic.json\" > flow.json"
  STDERR "flow.json: /relaxation/terms: the shares sum to 1.02; they must stay below 1"
  COMMAND acus-replay scenarios/liver_biopsy_viscoelastic_2d.json ${patient} --check
          --set /patient/corridor=$INPUTS/corridor_ct.csv --set /effects/tissue/elasticity=flow.json)
acus_add_cli_case(acus-replay.a_fitted_table EXIT 0 NEEDS inputs
  BEFORE "bash ${CMAKE_CURRENT_LIST_DIR}/fit_inputs.sh\n$ACUS_BIN/acus-fit a.csv recording --tissue liver -o fit >/dev/null"
  STDOUT "largest axial force: [1-9]" CREATES r/forces.csv
  COMMAND acus-replay scenarios/liver_biopsy_viscoelastic.json $INPUTS/session ${patient} -o r
          --set /effects/needle_force/table=fit/forces.json
          --set /effects/ultrasound=null --set /effects/ct_slice=null)
# Textures learned from example images: the shipped ones, one that is missing, one in colour.
set(examples acus-replay scenarios/alamilla_2021.json $INPUTS/session ${patient} -o r
    --set /effects/view_3d=null)
set(example_table "${CMAKE_SOURCE_DIR}/configs/acoustics/alamilla_2021_examples.json")
acus_add_cli_case(acus-replay.textures_from_examples EXIT 0 NEEDS inputs
  STDOUT "^Replayed " CREATES r/images.igs.mha r/provenance.json
  COMMAND ${examples} --set /effects/ultrasound/alamilla_2021/acoustics=acoustics/alamilla_2021_examples.json)
acus_add_cli_case(acus-replay.texture_without_its_example EXIT 3 NEEDS inputs LEAVES_NOTHING
  BEFORE "sed 's/textures.fat.png/textures\\/nowhere.png/' \"${example_table}\" > table.json"
  STDERR "textures/nowhere.png"
  COMMAND ${examples} --check --set /effects/ultrasound/alamilla_2021/acoustics=table.json)
acus_add_cli_case(acus-replay.texture_from_what_is_no_image EXIT 3 NEEDS inputs LEAVES_NOTHING
  BEFORE "sed 's/textures.fat.png/table.json/' \"${example_table}\" > table.json"
  STDERR "table.json: is not a PNG"
  COMMAND ${examples} --set /effects/ultrasound/alamilla_2021/acoustics=table.json)

# The direct method in place of the tracking wall, and why not with another model.
acus_add_cli_case(acus-replay.direct_method EXIT 0 NEEDS inputs
  STDOUT "largest axial force: [1-9]" CREATES r/forces.csv
  COMMAND acus-replay scenarios/alamilla_2021.json $INPUTS/session ${patient} -o r
          --set /effects/ultrasound=null --set /effects/view_3d=null --set /effects/needle_force/wall=direct)
acus_add_cli_case(acus-replay.direct_method_of_another_model EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "needle_force/wall is .direct.: only the model alamilla has the direct method"
  COMMAND acus-replay $INPUTS/scenario.json $INPUTS/session ${patient} -o r --set /effects/needle_force/wall=direct)
# A scene of surfaces, its image from voxels and from the triangles themselves; the latter without surfaces.
set(surface_inputs "bash ${CMAKE_CURRENT_LIST_DIR}/surface_inputs.sh")
set(surfaces acus-replay scenarios/alamilla_2021.json $INPUTS/session --transform $INPUTS/ct_from_reference.tfm
    --set /effects/view_3d=null --set /image_rate_hz=2)
set(triangles --set /effects/ultrasound/alamilla_2021/labels_from=triangles)
acus_add_cli_case(acus-replay.surfaces_by_triangles EXIT 0 NEEDS inputs BEFORE "${surface_inputs} compare"
  STDOUT "^Replayed " CREATES r/images.igs.mha r/forces.csv
  COMMAND ${surfaces} --set /patient/surfaces=surfaces.json ${triangles} -o r)
acus_add_cli_case(acus-replay.triangles_without_surfaces EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "alamilla_2021/labels_from is .triangles., but there is no /patient/surfaces"
  COMMAND acus-replay scenarios/alamilla_2021.json $INPUTS/session ${patient} ${triangles} -o r)
acus_add_cli_case(acus-replay.triangles_of_an_open_surface EXIT 3 NEEDS inputs LEAVES_NOTHING
  BEFORE "${surface_inputs} && sed -i '$d' bone.obj"
  STDERR "bone.obj: is not closed"
  COMMAND ${surfaces} --set /patient/surfaces=surfaces.json ${triangles} -o r)
acus_add_cli_case(acus-replay.labels_from_nothing_known EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "labels_from" "label_map"
  COMMAND acus-replay scenarios/alamilla_2021.json $INPUTS/session ${patient} -o r
          --set /effects/ultrasound/alamilla_2021/labels_from=voxels)

# A CT without labels: springs by HU, from the preset, and why not with another model.
acus_add_cli_case(acus-replay.springs_by_hu EXIT 0 NEEDS inputs
  STDOUT "largest axial force: 0\\.[1-9]|largest axial force: [1-9]"
  STDERR "warning: there is no label map: the springs' tissues are identified by the CT's HU"
  CREATES r/forces.csv
  COMMAND acus-replay scenarios/fortmeier_2016_hu.json $INPUTS/session --ct $INPUTS/ct.nrrd
          --transform $INPUTS/ct_from_reference.tfm -o r --set /effects/ct_slice=null)
acus_add_cli_case(acus-replay.springs_by_hu_of_a_wrong_row EXIT 3 NEEDS inputs LEAVES_NOTHING
  BEFORE "sed 's/\"hu\": 80/\"hu\": 30/' \"${CMAKE_SOURCE_DIR}/configs/forces/fortmeier_hu.json\" > wrong.json"
  STDERR "wrong.json: /hu_springs/3/hu: is 30; it must be above the row before, 40"
  COMMAND acus-replay scenarios/fortmeier_2016_hu.json $INPUTS/session --ct $INPUTS/ct.nrrd
          --transform $INPUTS/ct_from_reference.tfm -o r --set /effects/tissue/table=wrong.json)
acus_add_cli_case(acus-replay.explain_sleep EXIT 0 NEEDS inputs LEAVES_NOTHING
  STDOUT "^needle force +force +needle, tissue, needle preset, force table"
         "needle force: needle outside the tissue in [0-9.]+ % of the steps"
  COMMAND acus-replay scenarios/lumbar_puncture.json $INPUTS/session ${patient} --explain
          --set /effects/ct_slice=null --set /effects/ultrasound=null)
acus_add_cli_case(acus-replay.explain_without_session EXIT 0 NEEDS inputs LEAVES_NOTHING
  STDOUT "^B-mode +image +in +effect ultrasound is called for" "^B-mode +B-mode image +ct, acoustics"
  COMMAND acus-replay $INPUTS/scenario.json ${patient} --explain)
acus_add_cli_case(acus-replay.check_a_session EXIT 3 NEEDS inputs LEAVES_NOTHING
  BEFORE "mkdir s && cp $INPUTS/session/needle.csv s && echo '{\"format\": \"acus-session/1\", \"name\": \"n\", \"reference_frame\": \"Reference\", \"streams\": [{\"file\": \"needle.csv\", \"tool\": \"needle\"}]}' > s/session.json"
  STDERR "needs probe poses: the session has no probe stream; for effects/"
  COMMAND acus-replay $INPUTS/scenario.json s ${patient} --check)
acus_add_cli_case(acus-replay.unneeded_file_is_not_there EXIT 0 NEEDS inputs LEAVES_NOTHING
  STDOUT ": OK"
  COMMAND acus-replay $INPUTS/scenario.json ${patient} --check --set /patient/mesh=nowhere
          --set /patient/corridor=nowhere.csv)
acus_add_cli_case(acus-replay.fitted_table EXIT 0 NEEDS inputs STDOUT "needle force" ": OK"
  BEFORE "bash ${CMAKE_CURRENT_LIST_DIR}/fit_inputs.sh
$ACUS_BIN/acus-fit a.csv recording --tissue liver -o fit >/dev/null"
  COMMAND acus-replay $INPUTS/scenario.json ${patient} --check
          --set /effects/needle_force/table=fit/forces.json)
set(measured_fit "bash ${CMAKE_CURRENT_LIST_DIR}/fit_inputs.sh
$ACUS_BIN/acus-fit a.csv --models mechanical -o fit >/dev/null")
acus_add_cli_case(acus-replay.measured_forces EXIT 0 NEEDS inputs BEFORE "${measured_fit}"
  STDOUT "^Replayed " CREATES run/forces.csv
  COMMAND acus-replay $INPUTS/scenario.json $INPUTS/session ${patient} -o run
          --set /effects/needle_force/model=measured
          --set /effects/needle_force/measured=fit/measured.json)
acus_add_cli_case(acus-replay.measured_forces_without_a_file EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "/effects/needle_force: model \"measured\" needs the file of the fit"
  COMMAND acus-replay $INPUTS/scenario.json ${patient} --check
          --set /effects/needle_force/model=measured)
acus_add_cli_case(acus-replay.measured_forces_of_another_recording EXIT 3 NEEDS inputs
  LEAVES_NOTHING BEFORE "${measured_fit}"
  STDERR "no recording is named 'b'; there are: mean, a"
  COMMAND acus-replay $INPUTS/scenario.json $INPUTS/session ${patient} -o run
          --set /effects/needle_force/model=measured --set /effects/needle_force/recording=b
          --set /effects/needle_force/measured=fit/measured.json)
acus_add_cli_case(acus-replay.check EXIT 0 NEEDS inputs LEAVES_NOTHING
  STDOUT "needle force" ": OK"
  COMMAND acus-replay $INPUTS/scenario.json ${patient} --check)
acus_add_cli_case(acus-replay.no_registration EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "in the frame Reference, not in that of the CT" "--transform identity"
  COMMAND acus-replay scenarios/lumbar_puncture.json $INPUTS/session --ct $INPUTS/ct.nrrd --labels $INPUTS/labels.seg.nrrd -o r)
acus_add_cli_case(acus-replay.identity_as_registration EXIT 0 NEEDS inputs LEAVES_NOTHING STDOUT ": OK"
  COMMAND acus-replay scenarios/lumbar_puncture.json $INPUTS/session --ct $INPUTS/ct.nrrd --labels $INPUTS/labels.seg.nrrd
  --transform identity --check)
acus_add_cli_case(acus-replay.labels_as_ct EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "labels.seg.nrrd: is a label map .*Give labels by --labels"
  COMMAND acus-replay scenarios/lumbar_puncture.json $INPUTS/session --ct $INPUTS/labels.seg.nrrd
  --labels $INPUTS/labels.seg.nrrd --transform $INPUTS/ct_from_reference.tfm -o r)
acus_add_cli_case(acus-replay.no_such_scenario EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "scenarios/lumbar_punctur.json: no such file; tried"
  COMMAND acus-replay scenarios/lumbar_punctur.json $INPUTS/session -o run)
acus_add_cli_case(acus-replay.mistyped_effect EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "/effects/ultrasond: unknown key; did you mean .ultrasound.\\?"
  COMMAND acus-replay $INPUTS/scenario.json $INPUTS/session ${patient} -o run
          --set /effects/ultrasond/needle=false)
acus_add_cli_case(acus-replay.missing_input EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "needs ct: /patient/ct is not given" "take the effect out"
  COMMAND acus-replay scenarios/lumbar_puncture.json $INPUTS/session -o run
          --labels $INPUTS/labels.seg.nrrd)
acus_add_cli_case(acus-replay.time_going_back EXIT 3 NEEDS inputs
  BEFORE "cp -rL $INPUTS/session s && awk -F, -v OFS=, 'NR==50{$1=0.001}1' s/needle.csv > n && mv n s/needle.csv"
  STDERR "s/needle.csv:50: "
  COMMAND acus-replay $INPUTS/scenario.json s ${patient} -o run)
acus_add_cli_case(acus-replay.nan_in_session EXIT 3 NEEDS inputs
  BEFORE "cp -rL $INPUTS/session s && awk -F, -v OFS=, 'NR==77{$3=\"nan\"}1' s/needle.csv > n && mv n s/needle.csv"
  STDERR "s/needle.csv:77: .*nan"
  COMMAND acus-replay $INPUTS/scenario.json s ${patient} -o run)
acus_add_cli_case(acus-replay.keeps_an_earlier_run EXIT 3 NEEDS inputs LEAVES_NOTHING
  BEFORE "mkdir run && echo mine > run/notes.txt"
  STDERR "not the output of an earlier run"
  COMMAND acus-replay $INPUTS/scenario.json $INPUTS/session ${patient} -o run --overwrite)

# The force on the probe.
acus_add_cli_case(acus-replay.probe_force EXIT 0 NEEDS inputs
  STDOUT "largest probe force"
  CREATES run/probe_forces.csv run/probe_forces.svg run/report.html
  COMMAND acus-replay scenarios/palpation.json $INPUTS/session ${patient} -o run
          --set /effects/probe_force/press_mm=8)
# Palpation that is seen changes the images, no force; without what computes it elsewhere.
string(REPLACE ";" " " palpate "acus-replay scenarios/palpation.json $INPUTS/session ${patient} --quiet --set /effects/probe_force/press_mm=8 --set /effects/probe_force/multi_proxy/tool=fingertip")
acus_add_cli_case(acus-replay.palpation_is_seen EXIT 0 NEEDS inputs CREATES run/images.igs.mha
  COMMAND bash -c "${palpate} -o plain && ${palpate} -o run --set /effects/probe_force/multi_proxy/image=true && cmp plain/probe_forces.csv run/probe_forces.csv && ! cmp -s plain/images.igs.mha run/images.igs.mha")
acus_add_cli_case(acus-replay.palpation_seen_twice EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "multi_proxy/image and /effects/tissue/pressed_by_probe both press the tissue in the images"
  COMMAND acus-replay scenarios/fortmeier_2016.json $INPUTS/session ${patient} -o run
          --set /effects/tissue/pressed_by_probe=true)
acus_add_cli_case(acus-replay.display EXIT 0 NEEDS inputs STDOUT "^Replayed " CREATES run/images.igs.mha
  COMMAND acus-replay $INPUTS/scenario.json $INPUTS/session ${patient} -o run
          --set /effects/ultrasound/model=aperture
          --set /effects/ultrasound/display=displays/abdomen.json)
acus_add_cli_case(acus-replay.display_of_another_model EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "/effects/ultrasound/display: .displays/abdomen.json. with the model vidal_2008"
         "models beams and aperture"
  COMMAND acus-replay $INPUTS/scenario.json ${patient} --check
          --set /effects/ultrasound/model=vidal_2008
          --set /effects/ultrasound/display=displays/abdomen.json)
acus_add_cli_case(acus-replay.broken_display EXIT 3 NEEDS inputs LEAVES_NOTHING
  BEFORE "echo '{\"format\": \"acus-display/1\", \"name\": \"n\", \"compound_angles\": 4}' > d.json"
  STDERR "d.json: does not fit its schema" "/compound_angles: must be one of"
  COMMAND acus-replay $INPUTS/scenario.json ${patient} --check
          --set /effects/ultrasound/model=beams --set /effects/ultrasound/display=d.json)
acus_add_cli_case(acus-replay.mistyped_probe_model EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "/effects/probe_force/model: must be one of .*multi_proxy.*got .multi-proxy"
  COMMAND acus-replay scenarios/palpation.json $INPUTS/session ${patient} -o run
          --set /effects/probe_force/model=multi-proxy)
acus_add_cli_case(acus-replay.too_many_proxies EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "/effects/probe_force/multi_proxy/proxies: .*64.*got 65"
  COMMAND acus-replay scenarios/palpation.json $INPUTS/session ${patient} -o run
          --set /effects/probe_force/multi_proxy/proxies=65)
acus_add_cli_case(acus-replay.probe_force_without_labels EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "probe force .effect probe_force is called for. needs labels"
  COMMAND acus-replay scenarios/palpation.json $INPUTS/session --ct $INPUTS/ct.nrrd -o run
          --set /effects/probe_force/multi_proxy/reads=labels)
acus_add_cli_case(acus-replay.guidance EXIT 0 NEEDS inputs
  STDOUT "largest lateral force: 0 N"
  COMMAND acus-replay $INPUTS/scenario.json $INPUTS/session ${patient} -o run
          --set /effects/needle_force/guidance=none --set /effects/ultrasound=null --set /effects/ct_slice=null)
acus_add_cli_case(acus-replay.mistyped_guidance EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "/effects/needle_force/guidance: must be one of .*virtual_fixture"
  COMMAND acus-replay $INPUTS/scenario.json $INPUTS/session ${patient} -o run
          --set /effects/needle_force/guidance=fixture)
acus_add_cli_case(acus-replay.exercise EXIT 0 NEEDS inputs
  STDOUT "^Goals met: [0-9] of 7" CREATES run/training.json run/report.html
  COMMAND acus-replay $INPUTS/scenario.json $INPUTS/session ${patient} -o run --trainee A7 --no-film
          --set /patient/corridor=$INPUTS/target_ct.csv --exercise exercises/lumbar_puncture.json)
acus_add_cli_case(acus-replay.exercise_without_target EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "has a goal for .tip to target at the end." "give /patient/corridor"
  COMMAND acus-replay $INPUTS/scenario.json $INPUTS/session ${patient} -o run --no-film
          --exercise exercises/lumbar_puncture.json)
# What a run refuses before its first step, the check refuses, too.
acus_add_cli_case(acus-replay.check_no_table EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "needle" COMMAND acus-replay $INPUTS/scenario.json ${patient} --check
          --set /needle=nowhere/needle.json)
acus_add_cli_case(acus-replay.check_broken_table EXIT 3 NEEDS inputs LEAVES_NOTHING
  BEFORE "echo '{}' > broken.json" STDERR "broken.json"
  COMMAND acus-replay $INPUTS/scenario.json ${patient} --check --set /effects/needle_force/table=$PWD/broken.json)
acus_add_cli_case(acus-replay.check_labels_of_another EXIT 3 NEEDS inputs LEAVES_NOTHING
  BEFORE "head -c 900 $INPUTS/labels.seg.nrrd > cut.seg.nrrd" STDERR "cut.seg.nrrd"
  COMMAND acus-replay $INPUTS/scenario.json --ct $INPUTS/ct.nrrd --labels cut.seg.nrrd --check)

# Labelled images.
acus_add_cli_case(acus-replay.labels_in_image EXIT 0 NEEDS inputs
  CREATES r/labelled/images/00000.png r/labelled/labels/00000.png r/labelled/frames.csv
          r/labelled/labelled.json r/labelled/depth_mm.nii.gz
  COMMAND acus-replay $INPUTS/scenario.json $INPUTS/session --ct $INPUTS/ct.nrrd
          --labels $INPUTS/labels.seg.nrrd --transform $INPUTS/ct_from_reference.tfm
          --labels-in-image png --no-film --png none -o r)
acus_add_cli_case(acus-replay.labels_in_image_wrong_format EXIT 2 NEEDS inputs LEAVES_NOTHING
  STDERR "--labels-in-image" "jpeg"
  COMMAND acus-replay $INPUTS/scenario.json $INPUTS/session --labels-in-image jpeg -o r)
acus_add_cli_case(acus-replay.labels_in_image_without_map EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "labels of images: the patient has no label map"
  COMMAND acus-replay $INPUTS/scenario.json $INPUTS/session --ct $INPUTS/ct.nrrd
          --transform $INPUTS/ct_from_reference.tfm --set /effects/needle_force=null
          --labels-in-image png --no-film --png none -o r)

# Emulated, without AVX and fused multiply-add: the same bytes. The rest of the presets by hand.
add_test(NAME cli.processors
  COMMAND ${ACUS_BASH} ${CMAKE_SOURCE_DIR}/developer/processors -o ${ACUS_CLI_FOLDER}/processors
          ${CMAKE_SOURCE_DIR}/configs/scenarios/lumbar_puncture.json
          ${CMAKE_SOURCE_DIR}/configs/scenarios/liver_biopsy_beams.json)
set_tests_properties(cli.processors PROPERTIES LABELS "cli" TIMEOUT 300
  ENVIRONMENT "ACUS_BIN=${CMAKE_BINARY_DIR}/bin")
# --check refuses what a run would refuse before its first step.
acus_add_cli_case(acus-replay.check_output_is_there EXIT 3 NEEDS inputs
  BEFORE "mkdir run && echo mine > run/notes.txt" STDERR "run: exists already; choose another"
  COMMAND acus-replay $INPUTS/scenario.json $INPUTS/session ${patient} --check -o run)
acus_add_cli_case(acus-replay.check_output_cannot_be_made EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "/proc/run: cannot be made"
  COMMAND acus-replay $INPUTS/scenario.json $INPUTS/session ${patient} --check -o /proc/run)
acus_add_cli_case(acus-replay.check_goal_without_target EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "goal for \"tip to target at the end\", but neither the exercise nor the scenario has a target"
  COMMAND acus-replay $INPUTS/scenario.json $INPUTS/session ${patient} --check
          --exercise exercises/lumbar_puncture.json)
acus_add_cli_case(acus-replay.goal_without_target EXIT 3 NEEDS inputs LEAVES_NOTHING
  STDERR "neither the exercise nor the scenario has a target"
  COMMAND acus-replay $INPUTS/scenario.json $INPUTS/session ${patient} -o run
          --exercise exercises/lumbar_puncture.json)
