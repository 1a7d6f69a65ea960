#!/usr/bin/env bash
# Holds tradeoff.csv of a sweep over tissue against what every such file has: its columns, no setting
# that must not be used, and errors that fall as elements shrink.
# Usage: check_tradeoff.sh tradeoff.csv
set -euo pipefail
csv=$1
columns=knob,value,model,error,error_unit,reference,step_us_median,step_us_p999,preparation_s
columns+=,memory_mb,is_default,is_paper,unusable
[[ $(head -n 1 "$csv") == "$columns" ]] || { echo "other columns: $(head -n 1 "$csv")"; exit 1; }
unusable=$(awk -F, 'NR > 1 && $13 != ""' "$csv")
[[ -z $unusable ]] || { echo "unusable: $unusable"; exit 1; }
for unit in N %; do
  awk -F, -v unit="$unit" '
    $1 == "element_size_mm" && $5 == unit {
      if (count++ && $4 >= last) { print "error does not fall: " $0; exit 1 }
      last = $4
    }
    END { if (count < 3) exit 1 }' "$csv"
done
