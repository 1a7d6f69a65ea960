set(two_runs "cp -r $INPUTS/reference_run a\ncp -r a b")
acus_add_cli_case(acus-compare.same EXIT 0 NEEDS inputs BEFORE "${two_runs}"
  STDOUT "The runs agree: " "^ok +images: smallest PSNR"
  CREATES c/comparison.json c/comparison.html c/worst_frame.png c/provenance.json
  COMMAND acus-compare a b --tolerances tolerances/identical.json -o c)
acus_add_cli_case(acus-compare.forces_differ EXIT 4 NEEDS inputs
  BEFORE "${two_runs}\nawk -F, -v OFS=, 'NR > 1 { \$4 += 0.5 } 1' a/forces.csv > b/forces.csv"
  STDOUT "^FAIL +force_axial_n: RMS difference +0\\.5 +<= 0\\.001 +N" "The runs DIFFER"
  STDERR "the runs differ in 2 of [0-9]+ checks, first: force_axial_n: RMS difference"
  CREATES c/comparison.json c/comparison.html c/worst_frame.png
  COMMAND acus-compare a b -o c)
acus_add_cli_case(acus-compare.own_tolerances EXIT 0 NEEDS inputs
  BEFORE "${two_runs}\nawk -F, -v OFS=, 'NR > 1 { \$4 += 0.5 } 1' a/forces.csv > b/forces.csv
echo '{\"format\": \"acus-tolerances/1\", \"forces\": {\"rms_n\": 0.6, \"max_n\": 0.6}}' > t.json"
  STDOUT "The runs agree"
  COMMAND acus-compare a b --tolerances t.json)
acus_add_cli_case(acus-compare.wrong_tolerances EXIT 3 LEAVES_NOTHING
  BEFORE "mkdir a b\necho '{\"format\": \"acus-tolerances/1\", \"forces\": {\"rms\": 1}}' > t.json"
  STDERR "t.json: " "/forces/rms: unknown key"
  COMMAND acus-compare a b --tolerances t.json -o c)
acus_add_cli_case(acus-compare.no_such_run EXIT 2 LEAVES_NOTHING BEFORE "mkdir a"
  STDERR "nowhere" COMMAND acus-compare a nowhere -o c)
acus_add_cli_case(acus-compare.not_a_run EXIT 3 LEAVES_NOTHING BEFORE "mkdir a b"
  STDERR "a: is not a run folder of acus-replay" COMMAND acus-compare a b -o c)
acus_add_cli_case(acus-compare.truncated_images EXIT 3 NEEDS inputs LEAVES_NOTHING
  BEFORE "${two_runs}\nhead -c -1000 a/images.igs.mha > b/images.igs.mha"
  STDERR "b/images.igs.mha" COMMAND acus-compare a b -o c)

# A session beside its replay: what both have is compared, what one has is stated.
set(session_and_run "cp -r $INPUTS/reference_run run && cp -rL $INPUTS/session session && cp run/forces.csv session/")
acus_add_cli_case(acus-compare.session EXIT 0 NEEDS inputs BEFORE "${session_and_run}"
  STDOUT "^Not compared: images.igs.mha .only in B., metrics.json .only in B.$" "^The runs agree: "
  CREATES c/comparison.json c/comparison.html
  COMMAND acus-compare session run --tolerances tolerances/identical.json -o c)
acus_add_cli_case(acus-compare.complete EXIT 4 NEEDS inputs BEFORE "${session_and_run}"
  STDOUT "^FAIL +images.igs.mha +- +same +only in B"
  STDERR "the runs differ in 2 of [0-9]+ checks, first: images.igs.mha"
  COMMAND acus-compare session run --complete)
acus_add_cli_case(acus-compare.nothing_in_common EXIT 3 NEEDS inputs LEAVES_NOTHING
  BEFORE "${session_and_run} && rm run/forces.csv"
  STDERR "session and run: have nothing in common to compare. A has forces.csv, B has images.igs.mha"
  COMMAND acus-compare session run -o c)
