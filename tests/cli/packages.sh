#!/usr/bin/env bash
# The Debian packages: without a finding of lintian, and their programs run without the sources.
#   packages.sh SOURCE WORK; $INPUTS holds the patient (make_inputs.sh).
set -euo pipefail
source=$1 work=$2
rm -rf "$work"
mkdir -p "$work"
"$source/pipelines/packages" --no-build --no-library --quick >"$work/packages" || { cat "$work/packages" >&2; exit 1; }
# shellcheck disable=SC2046  # Their names have no spaces.
lintian --fail-on error,warning $(cat "$work/packages")

# Outside the sources, which are hidden below.
away=$(mktemp -d)
trap 'rm -rf "$away"' EXIT
while read -r package; do dpkg-deb -x "$package" "$away"; done <"$work/packages"
cp -rL "$INPUTS"/{ct.nrrd,labels.seg.nrrd,scenario.json,session,ct_from_reference.tfm} "$away"
for program in "$away"/usr/bin/acus*; do
  test -s "$away/usr/share/man/man1/$(basename "$program").1.gz" || { echo "$program has no manual page" >&2; exit 1; }
done
if grep -rlF -- "$source" "$away/usr"; then
  echo "these files of the packages name the folder that they were built from" >&2
  exit 1
fi
cat >"$away/try.sh" <<'TRY'
set -euo pipefail
mount -t tmpfs none "$1"
cd "$2"
export PATH=$2/usr/bin:/usr/bin:/bin
unset ACUS_CONFIGS ACUS_BIN
acus list scenarios | grep -q lumbar_puncture
acus-replay scenario.json session --ct ct.nrrd --labels labels.seg.nrrd --transform ct_from_reference.tfm -o run
test -s run/report.html
TRY
unshare --mount bash "$away/try.sh" "$source" "$away"
