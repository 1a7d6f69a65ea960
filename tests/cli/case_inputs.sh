#!/usr/bin/env bash
# Two cases of an exercise in the working directory: e1.json and e2.json, whose scenarios s1.json and
# s2.json name the small patient; and c.json, a curriculum of both.
# Usage: case_inputs.sh CONFIGS
set -euo pipefail
patient="{\"ct\": \"$INPUTS/ct.nrrd\", \"labels\": \"$INPUTS/labels.seg.nrrd\", \
\"corridor\": \"$INPUTS/corridor_ct.csv\", \"ct_from_reference_file\": \"$INPUTS/ct_from_reference.tfm\"}"
for n in 1 2; do
  sed "s#\"patient\": {}#\"patient\": $patient#" "$1/scenarios/lumbar_puncture.json" >s$n.json
  sed -e "s#\"name\": *\"Lumbar[^\"]*\"#\"name\": \"Case $n\"#" \
    -e "s#\"scenario\": *\"[^\"]*\"#\"scenario\": \"s$n.json\"#" "$1/exercises/lumbar_puncture.json" >e$n.json
done
# The second one is nearly impossible.
sed -i 's#"at_most": 120#"at_most": 1#; s#"at_least": 70#"at_least": 100#' e2.json
echo '{"format": "acus-curriculum/1", "name": "Cases", "steps": [{"cases": "d/cases.csv", "order": "staircase"}]}' >c.json
