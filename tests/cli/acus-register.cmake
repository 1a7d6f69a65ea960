set(register_inputs "bash ${CMAKE_CURRENT_LIST_DIR}/register_inputs.sh")
acus_add_cli_case(acus-register.example EXIT 0 BEFORE "${register_inputs}"
  STDOUT "^A +0\\.[0-9]+" "FRE 0\\.[0-9]+ mm over 6 points" "^canal +0\\.[0-9]+"
  CREATES registered/ct_from_reference.tfm registered/registration.json
          registered/residuals.svg registered/provenance.json
  COMMAND acus-register --from mannequin.csv --to ct.csv --target target.csv -o registered)
acus_add_cli_case(acus-register.pivot_example EXIT 0 BEFORE "${register_inputs}"
  STDOUT "tip in the tool's frame +1\\.000 +2\\.000 +150\\.000 mm" "10\\.000 +20\\.000 +30\\.000"
  CREATES pointer/registration.json pointer/residuals.svg pointer/provenance.json
  COMMAND acus-register pivot poses -o pointer)
acus_add_cli_case(acus-register.outlier EXIT 0
  BEFORE "${register_inputs}\nsed -i s/70.1,199.8/78.1,199.8/ ct.csv"
  STDERR "warning: point 'D' does not fit the others"
  COMMAND acus-register --from mannequin.csv --to ct.csv -o registered)
acus_add_cli_case(acus-register.leave_out EXIT 0
  BEFORE "${register_inputs}\nsed -i s/70.1,199.8/78.1,199.8/ ct.csv"
  STDOUT "over 5 points"
  COMMAND acus-register --from mannequin.csv --to ct.csv --leave-out D -o registered)
acus_add_cli_case(acus-register.one_file EXIT 2 BEFORE "${register_inputs}" LEAVES_NOTHING
  STDERR "--from and --to is required"
  COMMAND acus-register --from mannequin.csv -o registered)
acus_add_cli_case(acus-register.missing_file EXIT 2 BEFORE "${register_inputs}" LEAVES_NOTHING
  STDERR "none.csv" COMMAND acus-register --from none.csv --to ct.csv -o registered)
acus_add_cli_case(acus-register.not_a_number EXIT 3 LEAVES_NOTHING
  BEFORE "${register_inputs}\nsed -i s/70.1,199.8/nan,199.8/ ct.csv"
  STDERR "ct.csv:5: x_mm is 'nan'"
  COMMAND acus-register --from mannequin.csv --to ct.csv -o registered)
acus_add_cli_case(acus-register.truncated EXIT 3 LEAVES_NOTHING
  BEFORE "${register_inputs}\nhead -c 60 ct.csv > cut.csv"
  STDERR "cut.csv:[0-9]+: has [0-9] cells.*cut off"
  COMMAND acus-register --from mannequin.csv --to cut.csv -o registered)
acus_add_cli_case(acus-register.on_a_line EXIT 3 LEAVES_NOTHING
  BEFORE "printf 'name,x_mm,y_mm,z_mm\\nA,0,0,0\\nB,1,1,1\\nC,5,5,5\\n' > line.csv"
  STDERR "on a line" COMMAND acus-register --from line.csv --to line.csv -o registered)
acus_add_cli_case(acus-register.pivot_without_turning EXIT 4 LEAVES_NOTHING
  BEFORE "${register_inputs}\ncp poses/1.txt poses/2.txt\nrm poses/[345].txt\ncp poses/1.txt poses/3.txt"
  STDERR "the pointer turned by only" COMMAND acus-register pivot poses -o pointer)
acus_add_cli_case(acus-register.robust EXIT 0
  BEFORE "${register_inputs}\nsed -i s/70.1,199.8/78.1,199.8/ ct.csv"
  STDERR "warning: point 'D' does not fit the others.*it was excluded" STDOUT "over 5 points" "omitted: D"
  COMMAND acus-register --from mannequin.csv --to ct.csv --robust -o registered)
acus_add_cli_case(acus-register.wrong_order EXIT 0
  BEFORE "${register_inputs}\nsed -i -e s/^A,/X,/ -e s/^B,/A,/ -e s/^C,/B,/ -e s/^X,/C,/ ct.csv"
  STDERR "warning: the points seem to be in another order .'A' is 'C', 'B' is 'A', 'C' is 'B'.: then FRE would be 0.[0-9]+ mm"
  COMMAND acus-register --from mannequin.csv --to ct.csv -o registered)
acus_add_cli_case(acus-register.find_order EXIT 0
  BEFORE "${register_inputs}\nsed -i -e s/^A,/X,/ -e s/^B,/A,/ -e s/^C,/B,/ -e s/^X,/C,/ ct.csv"
  STDOUT "FRE 0\\.[0-9]+ mm over 6 points" "the points were put in another order"
  COMMAND acus-register --from mannequin.csv --to ct.csv --find-order -o registered)
acus_add_cli_case(acus-register.same_place EXIT 3 LEAVES_NOTHING
  BEFORE "printf 'name,x_mm,y_mm,z_mm\\nA,1,2,3\\nB,1,2,3\\nC,1,2,3\\n' > one.csv"
  STDERR "all at the same place" COMMAND acus-register --from one.csv --to one.csv -o registered)
acus_add_cli_case(acus-register.weights EXIT 0
  BEFORE "${register_inputs}\nsed -i -e '2,9s:$:,0.1,0.1,0.4:' -e '1s:$:,sd_x_mm,sd_y_mm,sd_z_mm:' mannequin.csv"
  STDOUT "FLE 0.424 mm .given" "canal +0\\.[0-9]+"
  COMMAND acus-register --from mannequin.csv --to ct.csv --target target.csv -o registered)
acus_add_cli_case(acus-register.touch EXIT 0 BEFORE "${register_inputs}"
  STDOUT "FRE 0\\.[0-9]+ mm over 6 points" "of 7 rests those were taken"
  CREATES touched/touched.csv touched/ct_from_reference.tfm touched/residuals.svg
  COMMAND acus-register touch touches.csv --tip-mm 0,0,100 --known ct.csv -o touched)
acus_add_cli_case(acus-register.touch_too_few EXIT 3 LEAVES_NOTHING
  BEFORE "${register_inputs}\nhead -150 touches.csv > short.csv"
  STDERR "the tip rested at 3 places .at 0.0 s, .* but ct.csv has 6 points"
  COMMAND acus-register touch short.csv --tip-mm 0,0,100 --known ct.csv -o touched)
acus_add_cli_case(acus-register.touch_pivot_file EXIT 3 LEAVES_NOTHING
  BEFORE "${register_inputs}\necho '{}' > wrong.json"
  STDERR "is not a pivot calibration"
  COMMAND acus-register touch touches.csv --pivot wrong.json --known ct.csv -o touched)
acus_add_cli_case(acus-register.tracker EXIT 0 BEFORE "${register_inputs}"
  STDOUT "^still +0.12[0-9] " "accuracy 2.100 mm RMS over 1 known distances"
  CREATES tracker/jitter.svg tracker/accuracy.svg tracker/registration.json
  COMMAND acus-register tracker still.csv --measured measured.csv --known known.csv -o tracker)
acus_add_cli_case(acus-register.tracker_nothing EXIT 3 LEAVES_NOTHING
  STDERR "a recording of still tools, or measured and known places" COMMAND acus-register tracker -o t)
acus_add_cli_case(acus-register.hand_eye EXIT 0 BEFORE "${register_inputs}"
  STDOUT "marker in the handle's frame +10\\.000 +20\\.000 +30\\.000"
         "tracker in the device's frame +-?0\\.000 +-?0\\.000 +-500\\.000"
  CREATES eye/handle_from_marker.tfm eye/device_from_tracker.tfm eye/residuals.svg
  COMMAND acus-register hand-eye --device handle.csv --tracker marker.csv -o eye)
acus_add_cli_case(acus-register.hand_eye_still EXIT 4 BEFORE "${register_inputs}" LEAVES_NOTHING
  STDERR "the body turned by only" 
  COMMAND acus-register hand-eye --device still.csv --tracker still.csv -o eye)
acus_add_cli_case(acus-register.facets EXIT 0 BEFORE "${register_inputs}"
  STDOUT "^side +100\\.00 +-?0\\.00 +-?0\\.00" "FRE 0\\.000 mm over 8 points"
  CREATES facets/object.json facets/ct_from_reference.tfm
  COMMAND acus-register facets --points facets.csv --poses facet_poses.csv --ct facets_ct.csv -o facets)
acus_add_cli_case(acus-register.facet_moved EXIT 0
  BEFORE "${register_inputs}\nsed -i -e s/^side,a,7,/side,a,9,/ -e s/^side,b,7,/side,b,9,/ -e s/^side,c,-33,/side,c,-31,/ -e s/^side,d,-33,/side,d,-31,/ facets_ct.csv"
  STDERR "warning: facets 'front' and 'side' do not lie as in CT: the points of one are 2.00 mm"
  COMMAND acus-register facets --points facets.csv --poses facet_poses.csv --ct facets_ct.csv -o facets)
acus_add_cli_case(acus-register.surface EXIT 0 BEFORE "${register_inputs}"
  STDOUT "distance 0\\.0[0-9]+ mm RMS" "held least: (sliding|turning)"
  CREATES surface/ct_from_reference.tfm surface/distances.svg
  COMMAND acus-register surface sweep.csv --skin skin.obj --start start.txt -o surface)
acus_add_cli_case(acus-register.surface_too_few EXIT 3 LEAVES_NOTHING
  BEFORE "${register_inputs}\nhead -9 sweep.csv > few.csv"
  STDERR "needs at least 12 points, got 8"
  COMMAND acus-register surface few.csv --skin skin.obj -o surface)
acus_add_cli_case(acus-register.warp EXIT 0 BEFORE "${register_inputs}" TIMEOUT 120
  STDOUT "skin to mannequin +[0-9.]+ mm RMS before, 0\\.[0-3][0-9] after" "no folding"
  CREATES warped/ct.nrrd warped/labels.seg.nrrd warped/displacement.nrrd warped/registration.json
  COMMAND acus-register warp --ct body_ct.nrrd --labels body_labels.nrrd --skin skin.obj
          --mannequin mannequin.obj --lattice-mm 10 -o warped)
acus_add_cli_case(acus-register.warp_far EXIT 4 BEFORE "${register_inputs}" LEAVES_NOTHING
  STDERR "is the registration right"
  COMMAND acus-register warp --ct body_ct.nrrd --labels body_labels.nrrd --skin skin.obj
          --mannequin mannequin.obj --transform far.txt -o warped)
acus_add_cli_case(acus-register.warp_ignores_no_option EXIT 2 LEAVES_NOTHING BEFORE "${register_inputs}"
  STDERR "--fle-mm: is not for warp"
  COMMAND acus-register warp --ct body_ct.nrrd --labels body_labels.nrrd --skin skin.obj
          --mannequin skin.obj --fle-mm 1 -o warped)
# Poses turn, but the tip moves with them by decimetres.
acus_add_cli_case(acus-register.pivot_not_pivoted EXIT 4 LEAVES_NOTHING
  BEFORE "${register_inputs}"
  STDERR "the pointer was moved, not pivoted" COMMAND acus-register pivot handle.csv -o pointer)
acus_add_cli_case(acus-register.pivot_limit EXIT 2 LEAVES_NOTHING BEFORE "${register_inputs}"
  STDERR "--limit-mm" COMMAND acus-register pivot poses --limit-mm -1 -o pointer)
acus_add_cli_case(acus-register.temporal EXIT 0 BEFORE "${register_inputs}"
  STDOUT "add to the other's times +-6[45]\\.[0-9]+ ms" CREATES lag/registration.json lag/lags.svg
  COMMAND acus-register temporal --tracker log1.csv --other log2.csv -o lag)
acus_add_cli_case(acus-register.temporal_nothing EXIT 2 BEFORE "${register_inputs}" LEAVES_NOTHING
  STDERR "--other or --video" COMMAND acus-register temporal --tracker still.csv -o lag)
acus_add_cli_case(acus-register.temporal_still EXIT 4 BEFORE "${register_inputs}" LEAVES_NOTHING
  STDERR "explains" COMMAND acus-register temporal --tracker log1.csv --other still.csv -o lag)
# A frame drawn from the same geometry as the surface: the start's shift is found. The drawn line is
# thicker than a simulated one, which a tilted plane explains: the program warns of it.
set(image_inputs "bash ${CMAKE_CURRENT_LIST_DIR}/image_inputs.sh")
acus_add_cli_case(acus-register.image EXIT 0 BEFORE "${image_inputs}"
  STDOUT "lateral_mm +-[12]\\.[0-9]+ +0\\.[0-9]+ +yes" "axial_mm +1\\.[0-9]+ +0\\.[0-9]+ +yes"
         "elevational_mm +-?[0-9.]+ +[0-9.]+ +no"
  STDERR "warning: the pose is more than three standard deviations from the start"
  CREATES pose/ct_from_probe.tfm pose/registration.json pose/overlay.png pose/provenance.json
  COMMAND acus-register image frame.pgm --scenario scene.json --start start.txt
          --background muscle --samples 200 -o pose)
acus_add_cli_case(acus-register.image_far EXIT 3 BEFORE "${image_inputs}" LEAVES_NOTHING
  STDERR "nothing of the patient is near the field of view"
  COMMAND acus-register image frame.pgm --scenario scene.json --start far.txt
          --background muscle -o pose)
acus_add_cli_case(acus-register.image_no_scenario EXIT 2 BEFORE "${image_inputs}" LEAVES_NOTHING
  STDERR "--scenario is required"
  COMMAND acus-register image frame.pgm --start start.txt -o pose)
acus_add_cli_case(acus-register.image_other_model EXIT 3 LEAVES_NOTHING
  BEFORE "${image_inputs}\nsed -i 's/\"aperture\", \"aperture\": {\"volume\": \"labels\"}/\"beams\"/' scene.json"
  STDERR "scene.json: /effects/ultrasound/model: must be 'aperture'"
  COMMAND acus-register image frame.pgm --scenario scene.json --start start.txt -o pose)
acus_add_cli_case(acus-register.image_size EXIT 3 LEAVES_NOTHING
  BEFORE "${image_inputs}\nsed -i 's/\"image_width_px\": 160/\"image_width_px\": 170/' probe.json"
  STDERR "the recorded frame has 160 x 160 pixels, the image of the probe 170 x 160"
  COMMAND acus-register image frame.pgm --scenario scene.json --start start.txt
          --background muscle -o pose)
acus_add_cli_case(acus-register.image_damaged EXIT 3 LEAVES_NOTHING
  BEFORE "${image_inputs}\nhead -c 30 surfaces.json > frame.pgm"
  STDERR "frame.pgm: is no image that can be read"
  COMMAND acus-register image frame.pgm --scenario scene.json --start start.txt
          --background muscle -o pose)
acus_add_cli_case(acus-register.image_background EXIT 3 LEAVES_NOTHING BEFORE "${image_inputs}"
  STDERR "muscel.*muscle"
  COMMAND acus-register image frame.pgm --scenario scene.json --start start.txt
          --background muscel -o pose)
# The calibration that the images were made of, to the digits of the files.
set(probe_answer "pixel +0\\.08000 x 0\\.08000 mm" "pixel .0, 0. +11\\.000 +50\\.000 +-4\\.000 mm"
  "640, 480 +0\\.000")
acus_add_cli_case(acus-register.probe EXIT 0 BEFORE "${register_inputs}"
  STDOUT ${probe_answer} "images +20" "^b2 +20 +0 +0\\.000" "the wires are taken to be in the frame of the poses"
  CREATES calibrated/image_to_probe.xml calibrated/probe_from_image.tfm calibrated/registration.json
          calibrated/residuals.svg calibrated/provenance.json
  COMMAND acus-register probe wire_points.csv --phantom wires.csv --image-px 640,480 -o calibrated)
acus_add_cli_case(acus-register.probe_log EXIT 0
  BEFORE "${register_inputs}\ncut -d, -f1-4 wire_points.csv > points.csv"
  STDOUT ${probe_answer}
  COMMAND acus-register probe points.csv --phantom wires.csv --log probe.csv --image-px 640,480 -o calibrated)
acus_add_cli_case(acus-register.probe_stylus EXIT 0 BEFORE "${register_inputs}"
  STDOUT ${probe_answer} "^tip +20 +0 +0\\.000"
  COMMAND acus-register probe tips.csv --image-px 640,480 -o calibrated)
acus_add_cli_case(acus-register.probe_outlier EXIT 0
  BEFORE "${register_inputs}\nsed -i 's/^2.5,b2,\\([0-9]*\\)/2.5,b2,7\\1/' wire_points.csv"
  STDOUT "excluded: 'b2' at 2\\.5 s, [0-9.]+ mm off" "^b2 +20 +1 +0\\.000" "pixel +0\\.08000 x 0\\.08000 mm"
  COMMAND acus-register probe wire_points.csv --phantom wires.csv -o calibrated)
acus_add_cli_case(acus-register.probe_too_few EXIT 4 LEAVES_NOTHING
  BEFORE "${register_inputs}\nhead -82 wire_points.csv > few.csv"
  STDERR "9 images show the three wires of an N. at least 10 are needed: add images"
  COMMAND acus-register probe few.csv --phantom wires.csv -o calibrated)
acus_add_cli_case(acus-register.probe_on_a_line EXIT 4 LEAVES_NOTHING
  BEFORE "${register_inputs}\nawk -F, -v OFS=, 'NR > 1 { $6 += 0.08 * ($3 - 200) } NR > 1 { $3 = 200 } 1' tips.csv > line.csv"
  STDERR "the points lie on a line in the image" "add points at other depths"
  COMMAND acus-register probe line.csv -o calibrated)
acus_add_cli_case(acus-register.probe_unknown_wire EXIT 3 LEAVES_NOTHING
  BEFORE "${register_inputs}\nsed -i 's/^1.0,b3/1.0,x3/' wire_points.csv"
  STDERR "wire_points.csv:27: the phantom has no wire 'x3'. it has 'a1', 'b1'"
  COMMAND acus-register probe wire_points.csv --phantom wires.csv -o calibrated)
acus_add_cli_case(acus-register.probe_no_poses EXIT 3 LEAVES_NOTHING
  BEFORE "${register_inputs}\ncut -d, -f1-4 wire_points.csv > points.csv"
  STDERR "points.csv: has no poses of the probe's marker. add the columns"
  COMMAND acus-register probe points.csv --phantom wires.csv -o calibrated)
acus_add_cli_case(acus-register.probe_other_time EXIT 3 LEAVES_NOTHING
  BEFORE "${register_inputs}\nsed -i 's/^9.5,/99.5,/' wire_points.csv"
  STDERR "99.5 s is not in the recording probe.csv, which runs from 0 to 9.5 s"
  COMMAND acus-register probe wire_points.csv --phantom wires.csv --log probe.csv -o calibrated)
acus_add_cli_case(acus-register.probe_wrong_wires EXIT 4 LEAVES_NOTHING
  BEFORE "${register_inputs}\nsed -i -e 's/,a\\([123]\\),/,x\\1,/' -e 's/,c\\([123]\\),/,a\\1,/' -e 's/,x\\([123]\\),/,c\\1,/' wire_points.csv"
  STDERR "check the names of the wires|do not determine the calibration"
  COMMAND acus-register probe wire_points.csv --phantom wires.csv -o calibrated)
acus_add_cli_case(acus-register.probe_phantom_order EXIT 3 LEAVES_NOTHING
  BEFORE "${register_inputs}\ncat <(sed -n 1p wires.csv) <(sed -n 3p wires.csv) <(sed -n 2p wires.csv) <(sed -n '4,$p' wires.csv) > turned.csv"
  STDERR "turned.csv: wires 'b1' and 'c1' are 20.5.* deg from parallel"
  COMMAND acus-register probe wire_points.csv --phantom turned.csv -o calibrated)
acus_add_cli_case(acus-register.probe_truncated EXIT 3 LEAVES_NOTHING
  BEFORE "${register_inputs}\nhead -c 700 wire_points.csv > cut.csv"
  STDERR "cut.csv:[0-9]+: "
  COMMAND acus-register probe cut.csv --phantom wires.csv -o calibrated)
