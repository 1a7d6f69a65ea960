set(rf_small "printf '%s' '{\"format\": \"acus-rf/1\", \"probe\": \"probes/linear_l7_4.json\", \"plane_waves_deg\": [0], \"samples\": 600, \"points\": [{\"at_mm\": [1, 12]}], \"image\": {\"depth_mm\": 20, \"step_mm\": [0.5, 0.1]}}' > small.json")
acus_add_cli_case(acus-rf.simulate EXIT 0 BEFORE "${rf_small}"
  CREATES out/channels.npy out/channels.mat out/iq.npy out/rf_lines.mha out/bmode.png out/provenance.json
  COMMAND acus-rf simulate small.json -o out)
acus_add_cli_case(acus-rf.beamform_is_the_same EXIT 0 BEFORE "${rf_small}"
  COMMAND bash -c "acus-rf simulate small.json -o a >/dev/null && acus-rf beamform small.json --data a/channels.mat -o b >/dev/null && cmp a/iq.npy b/iq.npy && cmp a/rf_lines.mha b/rf_lines.mha")
acus_add_cli_case(acus-rf.same_bits EXIT 0
  COMMAND bash -c "acus-rf simulate rf/three_points.json --threads 1 -o a >/dev/null && acus-rf simulate rf/three_points.json --threads 3 -o b >/dev/null && cmp a/channels.npy b/channels.npy && cmp a/iq.npy b/iq.npy")
acus_add_cli_case(acus-rf.rf_real EXIT 0 BEFORE "${rf_small}"
  STDOUT "UltrasoundImageType = RF_REAL"
  COMMAND bash -c "acus-rf simulate small.json -o a >/dev/null && grep -a UltrasoundImageType a/rf_lines.mha")
acus_add_cli_case(acus-rf.no_command EXIT 2 LEAVES_NOTHING STDERR "subcommand"
  COMMAND acus-rf --threads 1)
acus_add_cli_case(acus-rf.no_transmission EXIT 3 LEAVES_NOTHING
  BEFORE "${rf_small}\nsed -i 's/\\[0\\]/[]/' small.json"
  STDERR "small.json: has no transmission" COMMAND acus-rf simulate small.json -o out)
acus_add_cli_case(acus-rf.unknown_key EXIT 3 LEAVES_NOTHING
  BEFORE "${rf_small}\nsed -i 's/samples/sample/' small.json"
  STDERR "small.json" "samples" COMMAND acus-rf simulate small.json -o out)
acus_add_cli_case(acus-rf.not_matlab EXIT 3 LEAVES_NOTHING
  BEFORE "${rf_small}\necho no > a.mat"
  STDERR "a.mat: is not a MATLAB file" COMMAND acus-rf beamform small.json --data a.mat -o out)
acus_add_cli_case(acus-rf.wrong_probe EXIT 3
  BEFORE "${rf_small}"
  STDERR "the data have 1 transmissions, the settings 2"
  COMMAND bash -c "acus-rf simulate small.json -o a && sed 's/\\[0\\]/[0, 1]/' small.json > two.json && acus-rf beamform two.json --data a/channels.mat -o b")
acus_add_cli_case(acus-rf.cut_off EXIT 3
  BEFORE "${rf_small}"
  STDERR "cut.mat: is cut off"
  COMMAND bash -c "acus-rf simulate small.json -o a && head -c 5000 a/channels.mat > cut.mat && acus-rf beamform small.json --data cut.mat -o b")
