set(register_inputs "bash ${CMAKE_CURRENT_LIST_DIR}/register_inputs.sh")
acus_add_cli_case(acus-register.example EXIT 0 BEFORE "${register_inputs}"
  STDOUT "^A +0\\.[0-9]+" "FRE 0\\.[0-9]+ mm over 6 points" "^canal +0\\.[0-9]+"
  CREATES registered/ct_from_reference.tfm registered/registration.json
          registered/residuals.svg registered/provenance.json
  COMMAND acus-register --from mannequin.csv --to ct.csv --target target.csv -o registered)
acus_add_cli_case(acus-register.pivot_example EXIT 0 BEFORE "${register_inputs}"
  STDOUT "tip in the tool's frame +1\\.000 +2\\.000 +150\\.000 mm" "10\\.000 +20\\.000 +30\\.000"
  CREATES pointer/registration.json pointer/residuals.svg pointer/provenance.json
  COMMAND acus-register pivot poses -o pointer)
acus_add_cli_case(acus-register.outlier EXIT 0
  BEFORE "${register_inputs}\nsed -i s/70.1,199.8/78.1,199.8/ ct.csv"
  STDERR "warning: point 'D' does not fit the others"
  COMMAND acus-register --from mannequin.csv --to ct.csv -o registered)
acus_add_cli_case(acus-register.leave_out EXIT 0
  BEFORE "${register_inputs}\nsed -i s/70.1,199.8/78.1,199.8/ ct.csv"
  STDOUT "over 5 points"
  COMMAND acus-register --from mannequin.csv --to ct.csv --leave-out D -o registered)
acus_add_cli_case(acus-register.one_file EXIT 2 BEFORE "${register_inputs}" LEAVES_NOTHING
  STDERR "--from and --to is required"
  COMMAND acus-register --from mannequin.csv -o registered)
acus_add_cli_case(acus-register.missing_file EXIT 2 BEFORE "${register_inputs}" LEAVES_NOTHING
  STDERR "none.csv" COMMAND acus-register --from none.csv --to ct.csv -o registered)
acus_add_cli_case(acus-register.not_a_number EXIT 3 LEAVES_NOTHING
  BEFORE "${register_inputs}\nsed -i s/70.1,199.8/nan,199.8/ ct.csv"
  STDERR "ct.csv:5: x_mm is 'nan'"
  COMMAND acus-register --from mannequin.csv --to ct.csv -o registered)
acus_add_cli_case(acus-register.truncated EXIT 3 LEAVES_NOTHING
  BEFORE "${register_inputs}\nhead -c 60 ct.csv > cut.csv"
  STDERR "cut.csv:[0-9]+: has [0-9] cells.*cut off"
  COMMAND acus-register --from mannequin.csv --to cut.csv -o registered)
acus_add_cli_case(acus-register.on_a_line EXIT 3 LEAVES_NOTHING
  BEFORE "printf 'name,x_mm,y_mm,z_mm\\nA,0,0,0\\nB,1,1,1\\nC,5,5,5\\n' > line.csv"
  STDERR "on a line" COMMAND acus-register --from line.csv --to line.csv -o registered)
acus_add_cli_case(acus-register.pivot_without_turning EXIT 4 LEAVES_NOTHING
  BEFORE "${register_inputs}\ncp poses/1.txt poses/2.txt\nrm poses/[345].txt\ncp poses/1.txt poses/3.txt"
  STDERR "the pointer turned by only" COMMAND acus-register pivot poses -o pointer)
