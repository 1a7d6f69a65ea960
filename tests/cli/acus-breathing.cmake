# A small breathing patient is among the inputs; the example of --help is run by run_examples.sh.
acus_add_cli_case(acus-breathing.registers EXIT 0 NEEDS inputs TIMEOUT 120
  STDOUT "surrogate" "within 10 mm of the sliding wall" "Bound on the error"
  CREATES m/motion.json m/fields.raw m/fields.nhdr m/phases.csv m/models.csv m/report.html
          m/difference.png m/bound.raw m/bound.nhdr m/bound.png m/provenance.json
  COMMAND acus-breathing $INPUTS/breathing_patient --spacing-mm 8 --resolution 32 --quiet
          --labels $INPUTS/liver_patient/labels.seg.nrrd -o m)
acus_add_cli_case(acus-breathing.fields EXIT 0 NEEDS inputs
  STDOUT "full_cycle" CREATES m/motion.json m/report.html
  BEFORE "cp -r $INPUTS/breathing_patient/truth f && rm f/deeper.nrrd"
  COMMAND acus-breathing --fields f --signal $INPUTS/breathing_patient/signal.csv
          --model full_cycle --resolution 32 --quiet -o m)
acus_add_cli_case(acus-breathing.single EXIT 0 NEEDS inputs
  STDOUT "sinusoid" CREATES m/motion.json m/report.html
  COMMAND acus-breathing --single $INPUTS/liver_patient/ct.nrrd --resolution 24 --quiet
          --labels $INPUTS/liver_patient/labels.seg.nrrd -o m)
acus_add_cli_case(acus-breathing.missing_phase EXIT 3 NEEDS inputs
  STDERR "phase_02" "missing"
  BEFORE "cp -r $INPUTS/breathing_patient p && rm p/phase_02.nrrd"
  COMMAND acus-breathing p --quiet -o m)
acus_add_cli_case(acus-breathing.gap_in_numbers EXIT 3 NEEDS inputs
  STDERR "phase_01" "phase_03" "missing"
  BEFORE "cp -r $INPUTS/breathing_patient p && rm p/phase_02.nrrd p/phases.csv p/deeper.nrrd"
  COMMAND acus-breathing p --quiet -o m)
acus_add_cli_case(acus-breathing.other_size EXIT 3 NEEDS inputs
  STDERR "same grid" "phase"
  BEFORE "cp -r $INPUTS/breathing_patient p && cp $INPUTS/ct.nrrd p/phase_01.nrrd"
  COMMAND acus-breathing p --quiet --no-sliding --spacing-mm 12 --resolution 16 -o m)
acus_add_cli_case(acus-breathing.fields_in_voxels EXIT 3 NEEDS inputs
  STDERR "not a displacement field"
  BEFORE "cp -r $INPUTS/breathing_patient/truth f && rm f/deeper.nrrd && cp $INPUTS/ct.nrrd f/phase_01.nrrd"
  COMMAND acus-breathing --fields f --quiet -o m)
acus_add_cli_case(acus-breathing.fields_on_their_ct EXIT 0 NEEDS inputs CREATES m/motion.json
  BEFORE "cp -r $INPUTS/breathing_patient/truth f && rm f/deeper.nrrd"
  COMMAND acus-breathing --fields f --ct $INPUTS/liver_patient/ct.nrrd --resolution 16 --quiet -o m)
acus_add_cli_case(acus-breathing.fields_in_another_space EXIT 3 NEEDS inputs
  STDERR "another space"
  BEFORE "cp -r $INPUTS/breathing_patient/truth f && rm f/deeper.nrrd && \
LC_ALL=C sed -i 's/^space origin: (/space origin: (9/' f/phase_0[0-3].nrrd"
  COMMAND acus-breathing --fields f --ct $INPUTS/liver_patient/ct.nrrd --resolution 16 --quiet -o m)
acus_add_cli_case(acus-breathing.ct_without_fields EXIT 2 NEEDS inputs LEAVES_NOTHING
  COMMAND acus-breathing $INPUTS/breathing_patient --ct $INPUTS/ct.nrrd -o m)
acus_add_cli_case(acus-breathing.field_cut_off EXIT 3 NEEDS inputs
  STDERR "phase_02" BEFORE "cp -r $INPUTS/breathing_patient/truth f && rm f/deeper.nrrd && \
truncate -s 700 f/phase_02.nrrd"
  COMMAND acus-breathing --fields f --quiet -o m)
acus_add_cli_case(acus-breathing.constant_signal EXIT 3 NEEDS inputs
  STDERR "s.csv" BEFORE "(echo time_s,level && seq 0 0.1 9 | sed s/\\$/,1/) > s.csv"
  COMMAND acus-breathing $INPUTS/breathing_patient --signal s.csv --quiet -o m)
acus_add_cli_case(acus-breathing.signal_with_gap EXIT 3 NEEDS inputs
  STDERR "s.csv"
  BEFORE "sed 100,180d $INPUTS/breathing_patient/signal.csv > s.csv"
  COMMAND acus-breathing $INPUTS/breathing_patient --signal s.csv --quiet -o m)
acus_add_cli_case(acus-breathing.no_phases EXIT 3 LEAVES_NOTHING
  STDERR "e" BEFORE "mkdir e" COMMAND acus-breathing e --quiet -o m)
acus_add_cli_case(acus-breathing.nothing_given EXIT 2 LEAVES_NOTHING
  COMMAND acus-breathing -o m)
acus_add_cli_case(acus-breathing.two_given EXIT 2 NEEDS inputs
  COMMAND acus-breathing $INPUTS/breathing_patient --single $INPUTS/ct.nrrd -o m)
