#!/usr/bin/env bash
# The cohort of cohort.sh, in the process group of this script. Usage: cohort_in_group.sh SOURCE OUTPUT
exec "$1/pipelines/cohort" . "$2" --scenario "$1/testdata/small_scenario.json" --cores 2 \
  --set /effects/ultrasound=null --set /image_rate_hz=1
