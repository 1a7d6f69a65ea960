# The presets of the four papers: they load, explain and replay; effect plan and numbers held.
# tests/cli/papers/NAME.txt: metrics of the run and their values.
foreach(paper augmented_2010 vidal_2008 alamilla_2021 fortmeier_2016)
  add_test(NAME cli.papers.${paper}
    COMMAND ${ACUS_BASH} ${CMAKE_CURRENT_LIST_DIR}/run_paper.sh ${CMAKE_SOURCE_DIR}
            ${ACUS_CLI_FOLDER}/papers.${paper} ${paper})
  set_tests_properties(cli.papers.${paper} PROPERTIES LABELS cli TIMEOUT 300
    ENVIRONMENT "ACUS_BIN=${CMAKE_BINARY_DIR}/bin")
endforeach()
add_test(NAME cli.papers.no_such_paper
  COMMAND ${CMAKE_SOURCE_DIR}/pipelines/papers vidal_2009)
set_tests_properties(cli.papers.no_such_paper PROPERTIES LABELS cli WILL_FAIL TRUE)
