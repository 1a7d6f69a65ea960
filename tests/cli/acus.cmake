# One name for all, packages and the web site.
acus_add_cli_case(acus.lists_kinds EXIT 0 LEAVES_NOTHING STDOUT "^needles +[1-9]" "^scenarios +[1-9]"
  COMMAND acus list)
acus_add_cli_case(acus.lists_presets EXIT 0 LEAVES_NOTHING
  STDOUT "^needles/spinal_22g.json +22G spinal" COMMAND acus list needles)
acus_add_cli_case(acus.lists_names EXIT 0 LEAVES_NOTHING STDOUT "^needles/spinal_22g.json$"
  COMMAND acus list needles --names)
acus_add_cli_case(acus.mistyped_kind EXIT 3 LEAVES_NOTHING STDERR "Did you mean needles\\?"
  COMMAND acus list needels)
acus_add_cli_case(acus.mistyped_command EXIT 2 LEAVES_NOTHING STDERR "Did you mean replay\\?"
  COMMAND acus relpay)
acus_add_cli_case(acus.runs_programs EXIT 0 LEAVES_NOTHING STDOUT "^acus-replay [0-9]"
  COMMAND acus replay --version)
acus_add_cli_case(acus.passes_exit_codes_on EXIT 2 LEAVES_NOTHING STDERR "^acus-replay: "
  COMMAND acus replay --overwite)
acus_add_cli_case(acus.runs_workflows EXIT 0 LEAVES_NOTHING STDOUT "^Usage: pipelines/demo"
  COMMAND acus demo --help)
list(LENGTH ACUS_PROGRAMS programs)
math(EXPR programs_but_one "${programs} - 1")
acus_add_cli_case(acus.doctor EXIT 0 LEAVES_NOTHING
  STDOUT "^ok +programs +${programs} of ${programs}, [0-9]+\\.[0-9]+" "^ok +presets +[0-9]+ in " "^(ok|note) +1 kHz clock"
  COMMAND acus doctor)
acus_add_cli_case(acus.doctor_misses_a_program EXIT 3
  BEFORE "mkdir bin && ln -s $ACUS_BIN/acus* bin && rm bin/acus-rf"
  STDOUT "^missing +acus-rf +not in " "^missing +programs +${programs_but_one} of ${programs}"
  COMMAND bash -c "ACUS_BIN=$PWD/bin bin/acus doctor")
acus_add_cli_case(acus.doctor_without_presets EXIT 3 LEAVES_NOTHING STDOUT "^missing +presets"
  COMMAND bash -c "ACUS_CONFIGS=nowhere acus doctor")
acus_add_cli_case(acus.doctor_speed EXIT 0 LEAVES_NOTHING TIMEOUT 300
  STDOUT "lumbar_puncture +[0-9.]+ ms of CPU time for each step" "lumbar_puncture +[0-9.]+ ms of CPU time for each image"
  COMMAND acus doctor --speed)

set(packaging ${CMAKE_SOURCE_DIR}/pipelines/packaging)
acus_add_cli_case(acus.man_pages EXIT 0 TIMEOUT 120 CREATES man/acus-replay.1.gz man/acus-demo.1.gz
  NOT_STDERR "."
  COMMAND bash ${CMAKE_CURRENT_LIST_DIR}/man_pages.sh ${packaging} ${CMAKE_SOURCE_DIR}/pipelines)
acus_add_cli_case(acus.completion EXIT 0 TIMEOUT 120
  STDOUT "^subcommands: .*hand-eye" "^options: --overwrite$" "^commands: replay$" "^presets: .*needles/spinal_22g.json"
         "^choices: .*half_cycle" "^through acus: --overwrite$" "^kinds: needles$"
         "^zsh, subcommands: .*hand-eye" "^zsh, options: --overwrite$" "^zsh, commands: replay$"
         "^zsh, presets: .*needles/spinal_22g.json" "^zsh, choices: .*half_cycle" "^zsh, through acus: --overwrite$"
         "^zsh, kinds: needles$"
  COMMAND bash ${CMAKE_CURRENT_LIST_DIR}/completion.sh ${packaging} ${CMAKE_SOURCE_DIR}/pipelines)
acus_add_cli_case(acus.site EXIT 0 TIMEOUT 120 CREATES site/index.html site/models/tissue.html
  site/reference/commands/acus-replay.html site/katex/katex.min.js site/search/index.js
  COMMAND bash ${CMAKE_SOURCE_DIR}/pipelines/site --no-library -o site)
acus_add_cli_case(acus.site_keeps_other_folders EXIT 2 LEAVES_NOTHING BEFORE "mkdir site && echo 1 > site/mine"
  STDERR "choose another folder"
  COMMAND bash ${CMAKE_SOURCE_DIR}/pipelines/site --no-library -o site)
