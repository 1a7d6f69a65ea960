# Cohorts, by pipelines/cohort and pipelines/provenance.
find_program(ACUS_SNAKEMAKE snakemake)
if(ACUS_SNAKEMAKE)
  acus_add_cli_case(cohort EXIT 0 TIMEOUT 600 STDOUT "^cohort: all as it should be$"
    COMMAND bash ${CMAKE_CURRENT_LIST_DIR}/cohort.sh ${CMAKE_SOURCE_DIR} ${ACUS_CLI_FOLDER}/cohort.work)
endif()
