#!/usr/bin/env bash
# A cohort of real CTs: DICOM, NIfTI, labels of two other programs, a 4D CT, a recording by two scenarios, and a
# reference that it is compared with. The 4D CT is the real CT, warped.
# Usage: cohort_real.sh SOURCE_FOLDER FOLDER
set -uo pipefail
source=$1 folder=$2
data=${ACUS_TEST_DATA:-$source/../shared/data}
[[ -d $data/ct/totalseg && -d $data/ct/ircadb01_dicom ]] || { echo "skipped: test data ct is not here"; exit 0; }
data=$(realpath "$data")
failures=0
fail() { echo "FAILED: $*"; failures=$((failures + 1)); }
rm -rf "$folder" && mkdir -p "$folder/Miller_Ann" && cd "$folder" || exit 2
export PATH=$ACUS_BIN:$PATH

for name in example_ct example_seg_fast_force_split; do
  python3 -B "$source/tests/cli/coarse_nifti.py" "$data/ct/totalseg/$name.nii.gz" $name.nii.gz || exit 2
done
acus-phantom warp example_ct.nii.gz --phases 4 --landmarks 0 --quiet -o phases || exit 2
for i in {40..63}; do ln -s "$data/ct/ircadb01_dicom/image_$i" Miller_Ann; done
sed 's/"ct_slice": {}/"breathing": {"motion": "motion"}/' "$source/testdata/small_scenario.json" >breathing.json
{
  printf 'participant_id\tkind\tpath\tseed\n'
  printf 'sub-01\tct\texample_ct.nii.gz\t1\nsub-01\tlabels\texample_seg_fast_force_split.nii.gz\t\n'
  printf 'sub-01\tphases\tphases\t\nsub-01\tscenario\tbreathing.json\t\n'
  printf 'sub-01\tscenario\t%s/testdata/small_scenario.json\t\n' "$source"
  printf 'sub-02\tct\tMiller_Ann\t2\nsub-02\tlabels\t%s/ct/ircadb01_labels.vti\t\n' "$data"
  printf 'sub-02\tlabel_mapping\t%s/configs/label_maps/ircadb.json\t\n' "$source"
  printf 'sub-03\tct\t%s/ct/totalseg/example_ct_dicom\t3\n' "$data"
} >cohort.tsv
cohort() {
  "$source/pipelines/cohort" . "$@" --scenario "$source/testdata/small_scenario.json" --cores 2 --set /image_rate_hz=0.2
}
cohort out 2>err || fail "$(cat err)"
[[ $(grep -c "^sub-" out/group/metrics.tsv) == 4 ]] || fail "not four replays: $(cat out/group/metrics.tsv err)"
# Labels that were imported: the liver of both, a bladder of the one, a lesion of the other.
for found in 01:liver 01:bladder 02:liver 02:lesion; do
  awk -F , -v name="${found#*:}" '$2 == name && $3 > 5 { found = 1 } END { exit !found }' \
    "out/sub-${found%:*}/ses-01/segmentation/volumes.csv" || fail "no $found"
done
# The one scenario breathes as the 4D CT does, the other does not.
runs=out/sub-01/ses-01/replays
cmp -s $runs/{breathing,smallscenario}-insertion/forces.csv && fail "the patient does not breathe"
"$source/pipelines/provenance" $runs/breathing-insertion --repeat >history || fail "$(cat history)"
grep -q "acus-breathing work/in/sub-01/ses-01/phases" history || fail "the history lacks the 4D CT: $(cat history)"
"$source/pipelines/provenance" out --check >check || fail "$(cat check)"
grep -rIlE "Miller|$folder" out --exclude-dir=work && fail "names of folders got out"

# The same against itself, and against a reference in which one force table differs.
cohort again --participant-label 02 --reference out 2>err || fail "compared: $(cat err)"
grep -q "^against the reference: images: smallest SSIM" again/group/distributions.tsv || fail "no distribution of differences"
grep -q false again/group/comparisons.tsv && fail "the same cohort differs: $(cat again/group/comparisons.tsv)"
echo '{"format": "acus-budgets/1", "comparisons": {"share": 1}}' >budgets.json
cohort other --participant-label 02 --reference out --set /effects/needle_force/table=forces/fortmeier.json \
  --budgets budgets.json 2>err
[[ $? == 4 ]] || fail "other forces do not show in the exit code"
grep -q "budget comparisons share: 0, limit 1" err || fail "other forces: $(cat err)"
[[ $failures == 0 ]] && echo "cohort_real: all as it should be"
