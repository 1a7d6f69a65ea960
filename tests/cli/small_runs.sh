# Sourced: `runs`, commands that the sweeps try, on the small patient in the working directory. Each
# writes the folder o.
# shellcheck shell=bash disable=SC2034
patient=(--ct ct.nrrd --labels labels.seg.nrrd --transform ct_from_reference.tfm)
runs=(
  "acus-segment ct.nrrd -o o"
  "acus-replay scenario.json session ${patient[*]} -o o"
)
