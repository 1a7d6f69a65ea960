# Leaves the file code_ran where it is loaded.
set(marker ${CMAKE_BINARY_DIR}/tests/stand_ins/marker/libacus_marker.so)
# What holds for each program, without a line of its own in any other file.
foreach(program ${ACUS_PROGRAMS})
  # All libraries that it needs lie in the working directory, too; none of those is loaded.
  acus_add_cli_case(${program}.loads_nothing_of_the_working_directory EXIT 0 LEAVES_NOTHING
    BEFORE "tee $(ldd $ACUS_BIN/${program} | awk '$2 == \"=>\" {print $1}') <${marker} >/dev/null
            test -s libc.so.6"
    STDOUT "^${program} "
    COMMAND ${program} --version)
  acus_add_cli_case(${program}.help EXIT 0 LEAVES_NOTHING
    STDOUT "^Usage: .*${program}" "EXAMPLE" "^ +${program} [A-Za-z0-9./_-]" "--threads" "--seed" "--quiet"
    COMMAND ${program} --help)
  acus_add_cli_case(${program}.version EXIT 0 LEAVES_NOTHING
    STDOUT "^${program} [0-9]+\\.[0-9]+\\.[0-9]+( \\([-A-Za-z0-9._/+]+\\))?$"
    COMMAND ${program} --version)
  acus_add_cli_case(${program}.mistyped_option EXIT 2 LEAVES_NOTHING
    STDERR "--overwite" "[Dd]id you mean --overwrite\\?" "--help"
    COMMAND ${program} --overwite)
  acus_add_cli_case(${program}.no_arguments EXIT 2 LEAVES_NOTHING
    STDERR "^${program}: " "'${program} --help'"
    COMMAND ${program})
  acus_add_cli_case(${program}.bad_threads EXIT 2 LEAVES_NOTHING
    STDERR "threads.*0"
    COMMAND ${program} --threads 0)
endforeach()
