#!/usr/bin/env bash
# Installs Acus into a folder, builds the example against it, and runs it on the small patient.
#   run.sh BUILD SOURCE WORK; $INPUTS holds the patient (tests/cli/make_inputs.sh).
set -euo pipefail
build=$1 source=$2 work=$(realpath -m "$3")
rm -rf "$work"
mkdir -p "$work"
for component in library presets Unspecified; do
  cmake --install "$build" --prefix "$work/acus" --component "$component"
done >"$work/install.log"
# The workflows find what they share.
for workflow in "$work"/acus/share/acus/pipelines/*; do
  [[ ! -x $workflow || -d $workflow ]] || "$workflow" --help >/dev/null
done
export ACUS_CONFIGS=$work/acus/share/acus/configs
if grep -rlE -- "-Werror|$source" "$work/acus/lib"*/cmake "$work/acus/lib"*/*/cmake 2>/dev/null; then
  echo "the installed package names the source tree, or makes warnings errors" >&2
  exit 1
fi
cmake -S "$source/tests/install" -B "$work/build" -G Ninja -DCMAKE_PREFIX_PATH="$work/acus" \
  -DCMAKE_BUILD_TYPE=Release >"$work/configure.log" 2>&1 || { cat "$work/configure.log" >&2; exit 1; }
cmake --build "$work/build" >"$work/build.log" 2>&1 || { cat "$work/build.log" >&2; exit 1; }
python3 - "$INPUTS/scenario.json" "$INPUTS" >"$work/scenario.json" <<'PYTHON'
import json, sys
# Scenarios may have comments; JSON as Python reads it has none.
lines = [line for line in open(sys.argv[1]) if not line.lstrip().startswith("//")]
scenario = json.loads("".join(lines))
folder = sys.argv[2]
scenario["patient"].update(ct=folder + "/ct.nrrd", labels=folder + "/labels.seg.nrrd",
                           ct_from_reference_file=folder + "/ct_from_reference.tfm")
scenario["patient"].pop("ct_from_reference", None)
json.dump(scenario, sys.stdout)
PYTHON
"$work/build/step_and_render" "$work/scenario.json" "$INPUTS/session" "$work/image.png" |
  tee "$work/output"
awk '/^largest force/ && $6 > 0.5 { found = 1 } END { exit !found }' "$work/output"
# A black image would be far smaller.
[[ $(stat -c %s "$work/image.png") -gt 10000 ]]
