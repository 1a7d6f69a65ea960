# Sweeps over programs in odd surroundings: little memory, full disks, signals.

# With little memory, each program ends by itself: with its result, or with a message.
set(trust_limits ${CMAKE_CURRENT_LIST_DIR}/little_memory.sh)
acus_add_cli_case(trust.little_memory EXIT 0 NEEDS inputs TIMEOUT 600 STDOUT "^all ended$"
  COMMAND bash ${trust_limits})

# A disk that fills at any point.
acus_add_cli_case(trust.full_disk EXIT 0 NEEDS inputs TIMEOUT 900 STDOUT "^every program noticed$|^skipped"
  COMMAND bash ${CMAKE_CURRENT_LIST_DIR}/full_disk.sh)

# Ctrl-C and SIGTERM at any time.
acus_add_cli_case(trust.interrupts EXIT 0 NEEDS inputs TIMEOUT 600 STDOUT "^all ended in time$"
  COMMAND bash ${CMAKE_CURRENT_LIST_DIR}/interrupts.sh)
