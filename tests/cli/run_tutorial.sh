#!/usr/bin/env bash
# Runs the commands of docs/tutorial.md, in order, as they stand.
# Usage: run_tutorial.sh SOURCE_FOLDER FOLDER
set -euo pipefail
source=$1 folder=$2
export PATH="$ACUS_BIN:$PATH"
rm -rf "$folder"
mkdir -p "$folder"
cd "$folder"
# Blocks of code, without that which builds.
# shellcheck disable=SC2016
commands=$(sed -n '/^```$/,/^```$/p' "$source/docs/tutorial.md" | grep -v '^```$' |
  grep -vE '^(pipelines/build|export PATH)')
[[ $commands == *acus-phantom* && $commands == *acus-compare* ]] || { echo "FAILED: no commands found"; exit 1; }
bash -euxo pipefail -c "$commands"
for file in patient/ct.nrrd segmentation/preview_axial.png segmentation/volumes.csv mesh/mesh.vtu \
  mesh/quality.json fit/fit.svg registration/ct_from_reference.tfm run/report.html run/forces.csv \
  run/images.igs.mha comparison/worst_frame.png; do
  [[ -s $file ]] || { echo "FAILED: the tutorial promises $file"; exit 1; }
done
