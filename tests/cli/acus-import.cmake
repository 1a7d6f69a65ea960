acus_add_cli_case(acus-import.example EXIT 0 NEEDS inputs
  STDOUT "reference: " "needle: frame needle, [0-9]+ samples" "probe: frame probe"
  CREATES imported/session.json imported/needle.csv imported/probe.csv imported/provenance.json
  COMMAND acus-import $INPUTS/session -o imported)
acus_add_cli_case(acus-import.only_a_report EXIT 0 NEEDS inputs LEAVES_NOTHING
  STDOUT "needle: frame needle" COMMAND acus-import $INPUTS/session)
acus_add_cli_case(acus-import.csv_without_mapping EXIT 3 LEAVES_NOTHING
  BEFORE "echo Frame,Tx > a.csv" STDERR "acus-import --columns MAPPING"
  COMMAND acus-import a.csv -o imported)
acus_add_cli_case(acus-import.columns EXIT 0
  BEFORE "printf 'Frame,State,Q0,Qx,Qy,Qz,Tx,Ty,Tz\\n60,OK,1,0,0,0,1,2,3\\n61,Missing,,,,,,,\\n' > a.csv"
  STDOUT "reference: Tracker" "2 samples in 0.01667 s .60 Hz., seen in 50 %" "probe: none"
  CREATES imported/needle.csv
  COMMAND acus-import a.csv --columns columns/ndi_toolbox.json -o imported)
acus_add_cli_case(acus-import.no_times EXIT 3 LEAVES_NOTHING
  BEFORE "printf 'ObjectType = Image\\nNDims = 3\\nDimSize = 0 0 1\\nElementType = MET_UCHAR\\nSeq_Frame0000_ProbeToReferenceTransform = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\\nElementDataFile = LOCAL\\n' > a.igs.mha"
  STDERR "frame 0: has no Timestamp; 'acus-import --frame-rate-hz'"
  COMMAND acus-import a.igs.mha -o imported)
acus_add_cli_case(acus-import.wrong_rate EXIT 2 LEAVES_NOTHING NEEDS inputs
  STDERR "frame-rate-hz" COMMAND acus-import $INPUTS/session --frame-rate-hz 0 -o imported)
