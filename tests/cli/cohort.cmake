# Cohorts, by pipelines/cohort, pipelines/provenance and pipelines/trends.
find_program(ACUS_SNAKEMAKE snakemake)
if(ACUS_SNAKEMAKE)
  acus_add_cli_case(cohort EXIT 0 TIMEOUT 600 STDOUT "^cohort: all as it should be$"
    COMMAND bash ${CMAKE_CURRENT_LIST_DIR}/cohort.sh ${CMAKE_SOURCE_DIR} ${ACUS_CLI_FOLDER}/cohort.work)
  acus_add_cli_case(cohort_real EXIT 0 TIMEOUT 600 STDOUT "^cohort_real: all as it should be$|^skipped"
    COMMAND bash ${CMAKE_CURRENT_LIST_DIR}/cohort_real.sh ${CMAKE_SOURCE_DIR} ${ACUS_CLI_FOLDER}/cohort_real.work)
endif()
