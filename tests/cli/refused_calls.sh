#!/usr/bin/env bash
# Calls of the system fail, one in each run, in a segmentation, a replay and a live session.
# Usage: refused_calls.sh LIBRARY SCRIPT PER_KIND
set -euo pipefail
library=$1 script=$2 per_kind=$3
export PATH="$ACUS_BIN:$PATH" OPENBLAS_NUM_THREADS=1
mkdir -p patient
cp -rL "$INPUTS"/{ct.nrrd,labels.seg.nrrd,scenario.json,session,ct_from_reference.tfm} patient
cd patient
patient=(--ct ct.nrrd --labels labels.seg.nrrd --transform ct_from_reference.tfm)
python3 -B "$script" "$library" "$per_kind" segmentation acus-segment ct.nrrd -o o
python3 -B "$script" "$library" "$per_kind" replay acus-replay scenario.json session "${patient[@]}" --no-times -o o
python3 -B "$script" "$library" "$per_kind" "live session" acus-live scenario.json --devices devices/virtual.json \
  --hand session --headless --duration 0.5 --set /patient/ct=ct.nrrd --set /patient/labels=labels.seg.nrrd \
  --set /patient/ct_from_reference_file=ct_from_reference.tfm -o o
