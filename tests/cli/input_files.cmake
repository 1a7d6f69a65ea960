# The front gate of input files, through the programs: what no reader may wait for, trust or crash on.
set(gate_scenario acus-replay $INPUTS/scenario.json $INPUTS/session --labels $INPUTS/labels.seg.nrrd)

# Pipes, devices and loops of links, in place of files of each kind.
acus_add_cli_case(input_files.pipe_as_ct EXIT 3 TIMEOUT 20 BEFORE "mkfifo ct.nrrd"
  STDERR "ct.nrrd: is a named pipe. a regular file" COMMAND acus-segment ct.nrrd -o out)
acus_add_cli_case(input_files.device_as_ct EXIT 3 TIMEOUT 20 BEFORE "ln -s /dev/zero ct.nrrd"
  STDERR "ct.nrrd: is a device" COMMAND acus-segment ct.nrrd -o out)
acus_add_cli_case(input_files.device_as_settings EXIT 3 TIMEOUT 20 NEEDS inputs
  BEFORE "ln -s /dev/zero c.json" STDERR "c.json: is a device"
  COMMAND acus-segment $INPUTS/ct.nrrd --config c.json -o out)
acus_add_cli_case(input_files.pipe_as_surface EXIT 3 TIMEOUT 20 BEFORE "mkfifo skin.stl"
  STDERR "skin.stl: is a named pipe" COMMAND acus-mesh --surface skin.stl -o out)
acus_add_cli_case(input_files.pipe_as_force_curve EXIT 3 TIMEOUT 20 BEFORE "mkfifo curve.csv"
  STDERR "curve.csv: is a named pipe" COMMAND acus-fit curve.csv -o out)
acus_add_cli_case(input_files.pipe_as_scenario EXIT 3 TIMEOUT 20 NEEDS inputs
  BEFORE "mkfifo s.json" STDERR "s.json: is a named pipe"
  COMMAND acus-replay s.json $INPUTS/session -o out)
acus_add_cli_case(input_files.pipe_as_session EXIT 3 TIMEOUT 20 NEEDS inputs
  BEFORE "mkfifo s.igs.mha" STDERR "s.igs.mha: is a named pipe"
  COMMAND acus-replay $INPUTS/scenario.json s.igs.mha -o out)
acus_add_cli_case(input_files.loop_as_scenario EXIT 3 LEAVES_NOTHING NEEDS inputs
  BEFORE "ln -s b.json a.json && ln -s a.json b.json"
  STDERR "a.json: cannot be read: Too many levels of symbolic links"
  COMMAND acus-replay a.json $INPUTS/session -o out)

# Headers. A field of 1,000 bytes overflows a buffer of the library that reads NRRD.
foreach(field space "space directions" "space dimension" kinds centers thicknesses type encoding
        "measurement frame" "data file" unknown)
  string(REPLACE " " "_" field_name ${field})
  acus_add_cli_case(input_files.long_nrrd_field.${field_name} EXIT 3 LEAVES_NOTHING NEEDS inputs
    BEFORE "(echo NRRD0004 && printf '${field}: %01000d\\n' 0 && tail -n +2 $INPUTS/ct.nrrd) > ct.nrrd"
    STDERR "ct.nrrd:2: a header field has 10[0-9][0-9] bytes. at most 500"
    COMMAND acus-segment ct.nrrd -o out)
endforeach()
acus_add_cli_case(input_files.long_nrrd_comment EXIT 0 NEEDS inputs CREATES out/skin.stl TIMEOUT 120
  BEFORE "(echo NRRD0004 && printf '# %05000d\\nkey:=%05000d\\n' 0 0 && tail -n +2 $INPUTS/ct.nrrd) > ct.nrrd"
  COMMAND acus-segment ct.nrrd -o out)
acus_add_cli_case(input_files.data_of_another_folder EXIT 3 LEAVES_NOTHING
  BEFORE "mkdir other && head -c 64 /dev/zero > other/ct.raw && mkdir here &&
    printf 'ObjectType = Image\\nNDims = 3\\nDimSize = 4 4 4\\nElementType = MET_UCHAR\\nElementDataFile = ../other/ct.raw\\n' > here/ct.mhd"
  STDERR "here/ct.mhd: names the data file ../other/ct.raw, which is outside"
  COMMAND acus-segment here/ct.mhd -o out)
acus_add_cli_case(input_files.nrrd_data_of_another_folder EXIT 3 LEAVES_NOTHING
  BEFORE "head -c 64 /dev/zero > ct.raw &&
    printf 'NRRD0004\\ntype: uchar\\ndimension: 3\\nsizes: 4 4 4\\nencoding: raw\\ndata file: %s/ct.raw\\n' \"$PWD\" > ct.nhdr"
  STDERR "ct.nhdr: names the data file /.*/ct.raw, which is outside"
  COMMAND acus-segment ct.nhdr -o out)

# Nesting.
set(deep "head -c 100000 /dev/zero | tr '\\0' '\\133'")
acus_add_cli_case(input_files.deep_scenario EXIT 3 LEAVES_NOTHING NEEDS inputs
  BEFORE "${deep} > s.json" STDERR "s.json: its JSON is nested more than 100 deep"
  COMMAND acus-replay s.json $INPUTS/session -o out)
acus_add_cli_case(input_files.deep_change EXIT 3 LEAVES_NOTHING NEEDS inputs
  STDERR "--set /name: its JSON is nested more than 100 deep"
  COMMAND bash -c "exec acus-replay $INPUTS/scenario.json $INPUTS/session --check --set /name=$(${deep})")

# Megabytes that declare gigabytes: refused before memory is taken (here 1 GB of address space), and
# read where the user says so.
set(bomb "printf 'NRRD0004\\ntype: short\\ndimension: 3\\nsizes: 1500 1500 1500\\nspace: left-posterior-superior\\nspace directions: (1,0,0) (0,1,0) (0,0,1)\\nspace origin: (0,0,0)\\nendian: little\\nencoding: gzip\\n\\n' > ct.nrrd &&
  head -c 7000000 /dev/zero >> ct.nrrd")
acus_add_cli_case(input_files.bomb EXIT 3 LEAVES_NOTHING TIMEOUT 20 BEFORE "${bomb}"
  STDERR "ct.nrrd: declares 6.8 GB.*--memory-gb 6.8"
  COMMAND bash -c "ulimit -v 2000000 && exec acus-segment ct.nrrd -o out")
acus_add_cli_case(input_files.bomb_mha EXIT 3 LEAVES_NOTHING TIMEOUT 20
  BEFORE "printf 'ObjectType = Image\\nNDims = 3\\nCompressedData = True\\nDimSize = 1500 1500 1500\\nElementType = MET_SHORT\\nElementDataFile = LOCAL\\n' > ct.mha && head -c 7000000 /dev/zero >> ct.mha"
  STDERR "ct.mha: declares 6.8 GB.*--memory-gb 6.8"
  COMMAND bash -c "ulimit -v 2000000 && exec acus-segment ct.mha -o out")
acus_add_cli_case(input_files.memory_is_the_users EXIT 3 LEAVES_NOTHING NEEDS inputs
  STDERR "declares 0.1 GB, but 0 GB are allowed for one input file .--memory-gb."
  COMMAND acus-segment $INPUTS/ct.nrrd --memory-gb 0.001 -o out)
acus_add_cli_case(input_files.memory_suffices EXIT 0 NEEDS inputs CREATES out/skin.stl TIMEOUT 120
  COMMAND acus-segment $INPUTS/ct.nrrd --memory-gb 1 -o out)
acus_add_cli_case(input_files.false_counts_of_a_mesh EXIT 3 LEAVES_NOTHING
  BEFORE "printf '<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\"><PolyData><Piece NumberOfPoints=\"900000000000\" NumberOfPolys=\"900000000000\"><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0</DataArray></Points><Polys><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 0 0</DataArray><DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">3</DataArray></Polys></Piece></PolyData></VTKFile>' > a.vtp"
  STDERR "a.vtp: cannot be used" NOT_STDERR "bad_alloc"
  COMMAND acus-mesh --surface a.vtp -o out)
