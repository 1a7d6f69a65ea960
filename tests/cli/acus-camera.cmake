acus_add_cli_case(acus-camera.example EXIT 0 TIMEOUT 300
  STDOUT "^Reference +12 +0" "^Probe +12 +0" "^Needle +12 +0"
  CREATES sample/board/0000.png sample/facets/0011.png sample/truth/Probe.csv
          calibrated/camera.json calibrated/calibration.json calibrated/provenance.json
          tracked/Reference.csv tracked/Probe.csv tracked/Needle.csv tracked/provenance.json
  COMMAND bash -c "acus-camera sample --count 12 -o sample && acus-camera calibrate sample/board -o calibrated && acus-camera track sample/facets --camera calibrated/camera.json -o tracked")
acus_add_cli_case(acus-camera.print EXIT 0
  CREATES sheets/board.pdf sheets/board.svg sheets/board.png sheets/facets.pdf
          sheets/Reference_mannequin_left.svg sheets/provenance.json
  COMMAND acus-camera print -o sheets)
acus_add_cli_case(acus-camera.no_board EXIT 4 LEAVES_NOTHING TIMEOUT 300
  BEFORE "acus-camera sample --count 1 -o sample"
  STDERR "only 1 images show enough of the board, 6 are needed"
  COMMAND acus-camera calibrate sample/board -o calibrated)
acus_add_cli_case(acus-camera.no_image EXIT 3 LEAVES_NOTHING BEFORE "mkdir empty"
  STDERR "empty: there is no image in it" COMMAND acus-camera calibrate empty -o calibrated)
acus_add_cli_case(acus-camera.broken_image EXIT 3 LEAVES_NOTHING
  BEFORE "mkdir broken\necho no > broken/a.png"
  STDERR "broken/a.png: is not an image" COMMAND acus-camera track broken -o tracked)
acus_add_cli_case(acus-camera.other_size EXIT 3 LEAVES_NOTHING TIMEOUT 300
  BEFORE "acus-camera sample --count 1 -o sample"
  STDERR "has 1280 x 720 pixels, the camera's file says 640 x 480"
  COMMAND acus-camera track sample/facets --camera cameras/micron_tracker_2010.json -o tracked)
acus_add_cli_case(acus-camera.no_camera EXIT 3 LEAVES_NOTHING STDERR "none.json"
  COMMAND acus-camera sample --camera none.json -o sample)
acus_add_cli_case(acus-camera.rows_and_columns EXIT 4 LEAVES_NOTHING TIMEOUT 300
  BEFORE "acus-camera sample --count 7 -o sample\necho '{\"format\": \"acus-camera-board/1\", \"name\": \"b\", \"dictionary\": \"aruco_5x5_100\", \"columns\": 9, \"rows\": 6, \"square_mm\": 27, \"paper_mm\": [297, 210]}' > swapped.json"
  STDERR "as on one of 6 columns and 9 rows .rows and columns are swapped."
  COMMAND acus-camera calibrate sample/board --board swapped.json -o calibrated)
acus_add_cli_case(acus-camera.stereo_twice EXIT 3|4 LEAVES_NOTHING TIMEOUT 300
  BEFORE "acus-camera sample --count 2 -o sample\nacus-camera sample --count 1 -o other"
  STDERR "2 images of the left camera, but 1 of the right"
  COMMAND acus-camera stereo sample/board other/board -o pair
          --left-camera ${CMAKE_SOURCE_DIR}/configs/cameras/webcam_720p.json
          --right-camera ${CMAKE_SOURCE_DIR}/configs/cameras/webcam_720p.json)
acus_add_cli_case(acus-camera.hand_eye_counts EXIT 3 LEAVES_NOTHING TIMEOUT 300
  BEFORE "acus-camera sample --count 2 -o sample\nprintf 'time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,status\\n0,0,0,0,1,0,0,0,OK\\n' > body.csv"
  STDERR "body.csv: has 1 poses, sample/board has 2 images"
  COMMAND acus-camera hand-eye sample/board --poses body.csv -o eye
          --camera-file ${CMAKE_SOURCE_DIR}/configs/cameras/webcam_720p.json)
acus_add_cli_case(acus-camera.pair EXIT 0 TIMEOUT 300
  STDOUT "^Reference +3 +3 +0" "^Probe +3 +3 +0"
  CREATES sample/facets_right/0002.png sample/board_right/0002.png tracked/Reference.csv
  COMMAND bash -c "acus-camera sample --count 3 --stereo cameras/micron_pair_2010.json -o sample && acus-camera track sample/facets --right sample/facets_right --stereo cameras/micron_pair_2010.json -o tracked")
acus_add_cli_case(acus-camera.pair_exchanged EXIT 4 LEAVES_NOTHING TIMEOUT 300
  BEFORE "acus-camera sample --count 3 --stereo cameras/micron_pair_2010.json -o sample"
  STDERR "put the facets in different places, .* left and right are exchanged"
  COMMAND acus-camera track sample/facets_right --right sample/facets --stereo cameras/micron_pair_2010.json -o tracked)
acus_add_cli_case(acus-camera.pair_counts EXIT 3 LEAVES_NOTHING TIMEOUT 300
  BEFORE "acus-camera sample --count 2 --stereo cameras/micron_pair_2010.json -o sample\nrm sample/facets_right/0001.png"
  STDERR "there are 2 images of the left camera, but 1 of the right"
  COMMAND acus-camera track sample/facets --right sample/facets_right --stereo cameras/micron_pair_2010.json -o tracked)
