set(fit_inputs "bash ${CMAKE_CURRENT_LIST_DIR}/fit_inputs.sh")
acus_add_cli_case(acus-fit.csv EXIT 0 BEFORE "${fit_inputs}"
  STDOUT "^curve +puncture \\[N\\] .*friction \\[N/mm\\]"
         "^a +(2\\.9[0-9]|3\\.0[0-9])[0-9] .*10\\.0[0-9] .* 0\\.(030|029)[0-9]"
  CREATES fit/fit.json fit/fit.svg fit/a_over_time.svg fit/provenance.json
  COMMAND acus-fit a.csv -o fit)
acus_add_cli_case(acus-fit.folder EXIT 0 BEFORE "${fit_inputs}"
  STDOUT "^recording +(2\\.9|3\\.0)"
  CREATES fit/fit.json fit/recording_over_time.svg
  COMMAND acus-fit recording -o fit)
acus_add_cli_case(acus-fit.table EXIT 0 BEFORE "${fit_inputs}"
  STDOUT "\"source\": \"acus-fit" "\"cutting_n\": 0\\.[67]" "\"share\": 0\\.[0-9]+"
  COMMAND bash -c "acus-fit a.csv recording --tissue liver -o fit >/dev/null && cat fit/forces.json")
acus_add_cli_case(acus-fit.same_bits EXIT 0 BEFORE "${fit_inputs}"
  COMMAND bash -c "acus-fit a.csv --threads 1 -o one >/dev/null && acus-fit a.csv --threads 2 -o two >/dev/null && cmp one/fit.json two/fit.json && cmp one/fit.svg two/fit.svg")
acus_add_cli_case(acus-fit.no_puncture EXIT 0 CREATES fit/fit.json
  BEFORE "${fit_inputs}\nawk -F, 'NR > 1 {$3 = 0.01 * (NR % 3)} {print $1 \",\" $2 \",\" $3}' a.csv > flat.csv"
  STDOUT "^flat +no answer: no puncture"
  STDERR "warning: all else is fitted, but these models have no answer" "flat.csv: puncture: no puncture"
  COMMAND acus-fit flat.csv -o fit)
acus_add_cli_case(acus-fit.one_of_two EXIT 0 CREATES fit/fit.json
  BEFORE "${fit_inputs}\nhead -n 250 a.csv > short.csv"
  STDOUT "^short +no answer: " STDERR "warning: .*these models have no answer" "short.csv: puncture: "
  COMMAND acus-fit a.csv short.csv -o fit)
acus_add_cli_case(acus-fit.nothing_at_all EXIT 4 LEAVES_NOTHING
  BEFORE "${fit_inputs}\nawk -F, 'NR > 1 {$2 = 80 - $2} NR <= 1500 {print $1 \",\" $2 \",\" $3}' a.csv > back.csv"
  STDERR "no model has an answer for any curve, nothing is written"
         "back.csv: puncture: the drive does not advance"
  COMMAND acus-fit back.csv -o fit)
acus_add_cli_case(acus-fit.reversed_sign EXIT 0 CREATES fit/fit.json
  BEFORE "${fit_inputs}\nawk -F, 'NR > 1 {$3 = -$3} {print $1 \",\" $2 \",\" $3}' a.csv > pull.csv"
  STDERR "warning: all else is fitted" "pull.csv: puncture: .*is its sign reversed" "pull.csv: mechanical: .*is its sign reversed"
         "measured.json is not written: no recording has a mechanical model"
  COMMAND acus-fit pull.csv -o fit)
acus_add_cli_case(acus-fit.measured EXIT 0 BEFORE "${fit_inputs}"
  CREATES fit/measured.json
  STDOUT "\"format\": \"acus-measured-force/1\"" "\"buildup_in_mm\"" "\"name\": \"a\""
  COMMAND bash -c "acus-fit a.csv recording -o fit >/dev/null && cat fit/measured.json")
acus_add_cli_case(acus-fit.predict EXIT 0
  BEFORE "${fit_inputs}\nbash ${CMAKE_CURRENT_LIST_DIR}/fit_four.sh\n: > empty.csv"
  STDOUT "share of samples within the 95 % bounds" "^a +0\\.[0-9]+ "
  STDERR "warning: the others are predicted, but not these:" "empty.csv"
  CREATES prediction/prediction.json prediction/a_predicted.svg prediction/provenance.json
  COMMAND acus-fit empty.csv a.csv --predict fit -o prediction)
acus_add_cli_case(acus-fit.predict_from_too_few EXIT 3 LEAVES_NOTHING
  BEFORE "${fit_inputs}\n$ACUS_BIN/acus-fit a.csv recording --models mechanical -o fit >/dev/null"
  STDERR "measured.json: /prediction: there are no bounds: bounds for other recordings need 4"
         "fit four or more recordings together"
  COMMAND acus-fit a.csv --predict fit -o prediction)
acus_add_cli_case(acus-fit.predict_from_another_file EXIT 3 LEAVES_NOTHING
  BEFORE "${fit_inputs}\nmkdir other" STDERR "other/measured.json"
  COMMAND acus-fit a.csv --predict other -o prediction)
acus_add_cli_case(acus-fit.predict_and_models EXIT 2 LEAVES_NOTHING BEFORE "${fit_inputs}"
  STDERR "excludes"
  COMMAND acus-fit a.csv --predict a.csv --models none -o prediction)
set(tension_input "bash ${CMAKE_CURRENT_LIST_DIR}/tension_input.sh")
acus_add_cli_case(acus-fit.hyperelastic EXIT 0 BEFORE "${tension_input}"
  STDOUT "^strip +fung +mu_kpa (40|39)[0-9](\\.[0-9])?, b (2|2\\.0[0-9]+|1\\.9[0-9]+) +0\\.[01][0-9] +best"
  CREATES fit/fit.json fit/strip_tension.svg
  COMMAND acus-fit strip.csv --models hyperelastic -o fit)
acus_add_cli_case(acus-fit.hyperelastic_without_dimensions EXIT 3 LEAVES_NOTHING
  BEFORE "${tension_input}\nsed -i '1s/.*/# a strip/' strip.csv"
  STDERR "strip.csv:1: has no length_mm=" COMMAND acus-fit strip.csv --models hyperelastic -o fit)
acus_add_cli_case(acus-fit.hyperelastic_and_another EXIT 3 LEAVES_NOTHING BEFORE "${tension_input}"
  STDERR "hyperelastic is for tension tests.*give it alone"
  COMMAND acus-fit strip.csv --models hyperelastic,gaussians -o fit)
set(modes_input "bash ${CMAKE_CURRENT_LIST_DIR}/modes_input.sh")
acus_add_cli_case(acus-fit.modes EXIT 0 BEFORE "${modes_input}"
  STDOUT "^cube +ogden, 1 exponent +0\\.0 +0\\.0 +0\\.0 +0\\.0 +best"
  CREATES fit/fit.json fit/cube_modes.svg
  COMMAND acus-fit cube.csv --models modes -o fit)
acus_add_cli_case(acus-fit.modes_in_percent EXIT 3 LEAVES_NOTHING
  BEFORE "${modes_input}\nsed -i 's/^shear,0.10/shear,10/' cube.csv"
  STDERR "cube.csv:[0-9]+: a shear of 10; at most 5 is allowed. Is it in percent"
  COMMAND acus-fit cube.csv --models modes -o fit)
set(indentation_input "bash ${CMAKE_CURRENT_LIST_DIR}/indentation_input.sh")
acus_add_cli_case(acus-fit.indentation EXIT 0 BEFORE "${indentation_input}"
  STDOUT "^a +(neo_hookean|yeoh|fung) +0\\.[01][0-9]+ " CREATES fit/fit.json fit/b_indentation.svg
  COMMAND acus-fit a.csv b.csv --models indentation -o fit)
acus_add_cli_case(acus-fit.indentation_predicts_another EXIT 0
  BEFORE "${indentation_input}\n$ACUS_BIN/acus-fit a.csv b.csv --models indentation -o fit >/dev/null"
  STDOUT "^c +(neo_hookean|yeoh|fung) +0\\.[0-9]+ .* [0-2]\\.[0-9]+ +[0-2]\\.[0-9]+"
  CREATES prediction/prediction.json prediction/c_indentation.svg
  COMMAND acus-fit c.csv --predict fit -o prediction)
acus_add_cli_case(acus-fit.indentation_with_other_columns EXIT 3 LEAVES_NOTHING
  BEFORE "${indentation_input}\nsed -i '1s/indentation_mm/depth_mm/' a.csv"
  STDERR "a.csv:1: is 'time_s,force_n,depth_mm.*the columns must be time_s,force_n,indentation_mm"
  COMMAND acus-fit a.csv --models indentation -o fit)
acus_add_cli_case(acus-fit.indentation_and_tissue EXIT 3 LEAVES_NOTHING BEFORE "${indentation_input}"
  STDERR "indentation is for indentations.*give it alone"
  COMMAND acus-fit a.csv --models indentation --tissue liver -o fit)
acus_add_cli_case(acus-fit.missing_file EXIT 2 LEAVES_NOTHING
  STDERR "none.csv" COMMAND acus-fit none.csv -o fit)
acus_add_cli_case(acus-fit.wrong_diameter EXIT 2 LEAVES_NOTHING BEFORE "${fit_inputs}"
  STDERR "diameter" COMMAND acus-fit a.csv --diameter-mm 0.1 -o fit)
acus_add_cli_case(acus-fit.unknown_tissue EXIT 3 LEAVES_NOTHING BEFORE "${fit_inputs}"
  STDERR "no tissue is named 'livr'; did you mean 'liver'"
  COMMAND acus-fit a.csv --tissue livr -o fit)
acus_add_cli_case(acus-fit.not_finite EXIT 3 LEAVES_NOTHING
  BEFORE "${fit_inputs}\nsed -i '100s/,[^,]*$/,inf/' a.csv"
  STDERR "a.csv:100: force_n is .*inf" COMMAND acus-fit a.csv -o fit)
acus_add_cli_case(acus-fit.missing_value EXIT 0
  BEFORE "${fit_inputs}\nsed -i '100s/,[^,]*$/,nan/' a.csv"
  STDOUT "a.csv: 1 row with empty cells omitted" COMMAND acus-fit a.csv -o fit)
acus_add_cli_case(acus-fit.time_goes_back EXIT 3 LEAVES_NOTHING
  BEFORE "${fit_inputs}\nsed -i '100s/^[^,]*/0.2/' a.csv"
  STDERR "a.csv:100: time_s is 0.2 after 0.97; time must not go back"
  COMMAND acus-fit a.csv -o fit)
acus_add_cli_case(acus-fit.wrong_column EXIT 3 LEAVES_NOTHING
  BEFORE "${fit_inputs}\nsed -i '1s/depth_mm/depth_v/' a.csv"
  STDERR "a.csv:1: no column 'depth_mm'.*rename 'depth_v'"
  COMMAND acus-fit a.csv -o fit)
acus_add_cli_case(acus-fit.truncated EXIT 3 LEAVES_NOTHING
  BEFORE "${fit_inputs}\nhead -n 99 a.csv > cut.csv\nprintf 0.98,0 >> cut.csv"
  STDERR "cut.csv:100: has 2 cells.*is the file cut off" COMMAND acus-fit cut.csv -o fit)
acus_add_cli_case(acus-fit.half_a_folder EXIT 3 LEAVES_NOTHING
  BEFORE "${fit_inputs}\nrm recording/time_force.csv"
  STDERR "time_force.csv" COMMAND acus-fit recording -o fit)
acus_add_cli_case(acus-fit.output_exists EXIT 3 LEAVES_NOTHING
  BEFORE "${fit_inputs}\nmkdir fit\ntouch fit/mine.txt"
  STDERR "fit" COMMAND acus-fit a.csv -o fit)
acus_add_cli_case(acus-fit.two_of_a_name EXIT 3 LEAVES_NOTHING
  BEFORE "${fit_inputs}\nmkdir b\ncp a.csv b/a.csv"
  STDERR "b/a.csv: another curve is named 'a' too" COMMAND acus-fit a.csv b/a.csv -o fit)
acus_add_cli_case(acus-fit.models EXIT 0 BEFORE "${fit_inputs}"
  STDOUT "RMS of what the models leave, N" "^a +0\\.[0-9]+ +0\\.[0-9]+"
  CREATES fit/fit.json fit/a_models.svg fit/a_replay.svg
  COMMAND acus-fit a.csv --models gaussians,mechanical -o fit)
acus_add_cli_case(acus-fit.several EXIT 0
  BEFORE "${fit_inputs}\ncp a.csv b.csv\ncp a.csv c.csv"
  STDOUT "\"leave_one_out_predictions\"" "\"knots_in\""
  COMMAND bash -c "acus-fit a.csv b.csv c.csv --models mechanical -o fit >/dev/null && cat fit/fit.json")
acus_add_cli_case(acus-fit.one_speed EXIT 0 BEFORE "${fit_inputs}"
  STDOUT "the needle moves at one speed only"
  COMMAND bash -c "acus-fit a.csv --models lugre -o fit >/dev/null && cat fit/fit.json")
acus_add_cli_case(acus-fit.hu_table EXIT 0
  BEFORE "${fit_inputs}\nawk -F, 'NR == 1 {print $0 \",hu\"} NR > 1 {print $0 \",\" 50 + $2}' a.csv > hu.csv"
  STDOUT "\"n_s_per_mm\""
  COMMAND bash -c "acus-fit hu.csv --models hu-table -o fit >/dev/null && cat fit/fit.json")
acus_add_cli_case(acus-fit.wrong_hu EXIT 3 LEAVES_NOTHING
  BEFORE "${fit_inputs}\nawk -F, 'NR == 1 {print $0 \",hu\"} NR > 1 {print $0 \",1e9\"}' a.csv > hu.csv"
  STDERR "hu.csv:2: hu is 1e" COMMAND acus-fit hu.csv --models hu-table -o fit)
acus_add_cli_case(acus-fit.unknown_model EXIT 2 LEAVES_NOTHING BEFORE "${fit_inputs}"
  STDERR "gausians" COMMAND acus-fit a.csv --models gausians -o fit)
acus_add_cli_case(acus-fit.metres EXIT 3 LEAVES_NOTHING
  BEFORE "${fit_inputs}\nawk -F, 'NR == 1 {print} NR > 1 {print $1 \",\" $2 / 1000 \",\" $3}' a.csv > metres.csv"
  STDERR "metres.csv: the depth changes by 0.05 in all.*it seems to be in metres"
  COMMAND acus-fit metres.csv -o fit)
acus_add_cli_case(acus-fit.one_sample EXIT 3 LEAVES_NOTHING
  BEFORE "${fit_inputs}\nhead -n 2 a.csv > one.csv"
  STDERR "one.csv: has 1 usable samples; at least 20 are needed" COMMAND acus-fit one.csv -o fit)
acus_add_cli_case(acus-fit.empty EXIT 3 LEAVES_NOTHING BEFORE "touch empty.csv"
  STDERR "empty.csv" COMMAND acus-fit empty.csv -o fit)
