#!/usr/bin/env bash
# A cohort of small synthetic patients on one machine: one of them fails, the run is interrupted and
# continued, and gives the same bytes as one that is not; every record holds; two people start it; the
# disk is full; files of another machine appear late.
# Usage: cohort.sh SOURCE_FOLDER FOLDER
set -uo pipefail
source=$1 folder=$2
failures=0
fail() { echo "FAILED: $*"; failures=$((failures + 1)); }
refused() {  # CODE EXPECTED TEXT: the exit code, and what is in the message
  [[ $1 == "$2" ]] || fail "exit code $1, expected $2: $(cat err)"
  grep -q "$3" err || fail "no '$3': $(cat err)"
}
rm -rf "$folder" && mkdir -p "$folder/Miller_Ann" && cd "$folder" || exit 2
config=$source/testdata/tiny_lumbar.json
{
  printf 'participant_id\tsession_id\tkind\tpath\tseed\n'
  printf 'sub-01\t01\tphantom\tlumbar:%s\t1\n' "$config"
  printf 'sub-02\t01\tphantom\tlumbar:%s\t2\n' "$config"
  printf 'sub-03\t01\tct\tMiller_Ann/ct.nrrd\t\n'
} >cohort.tsv
printf 'participant_id\tage\nsub-01\t50\nsub-02\tn/a\nsub-03\t61\n' >participants.tsv
head -c 3000 /dev/zero >Miller_Ann/ct.nrrd
cohort() {
  "$source/pipelines/cohort" . "$@" --scenario "$source/testdata/small_scenario.json" --cores 2 \
    --set /effects/ultrasound=null --set /image_rate_hz=1
}

cohort --dry-run whole >dry || fail "--dry-run: $(cat dry)"
grep -q "CPU time [0-9.]* \(s\|min\|h\); about" dry || fail "no prediction: $(cat dry)"
[[ ! -e whole ]] || fail "--dry-run wrote"

# All that can be made is made; who fails is named, with the message of the program.
cohort whole participant 2>err
[[ $? == 4 ]] || fail "the failing patient does not show in the exit code"
cohort whole group 2>>err
grep -q "sub-03 ses-01: acus-segment: " err || fail "no message of sub-03: $(cat err)"
grep -q "^1 done\|^[0-9]* done, 1 failed" err || fail "no progress: $(cat err)"
cut -f 1,3 whole/group/failures.tsv | grep -q "^sub-03	segment$" || fail "sub-03 is not in failures.tsv"
[[ $(wc -l <whole/group/metrics.tsv) == 3 ]] || fail "metrics.tsv has not two runs"
grep -rIlE "Miller|$folder" whole --exclude-dir=work && fail "names of folders got out"

# Interrupted twice and continued: the same bytes; the jobs that were done are not run again.
for delay in 2.5 3; do
  timeout -s INT "$delay" setsid -w "$source/tests/cli/cohort_in_group.sh" "$source" parts 2>>err
done
cohort parts 2>err
ran=$(grep -c "" <(find parts/work/measured -name '*.json'))
[[ $ran == 8 ]] || fail "$ran jobs were measured, expected 8"
diff -r whole parts -x work -x times.html -x ro-crate-metadata.json || fail "other bytes after an interruption"
touch now
cohort parts 2>err
again=$(find parts/work/starts -type f -newer now)
[[ $again == parts/work/starts/sub-03_ses-01_segmentation.* ]] || fail "run again without need: $again"

# Every file is what its record says; a number's history ends at its sources; one file alone is made again.
"$source/pipelines/provenance" parts --check >out || fail "the crate: $(cat out)"
file=parts/sub-02/ses-01/registration/registration.json
"$source/pipelines/provenance" $file --repeat >out || fail "repeating: $(cat out)"
grep -q "acus-phantom patient lumbar --seed 2" out || fail "the history does not reach the phantom: $(cat out)"
"$source/pipelines/provenance" parts/group/metrics.tsv --cell 01 "greatest depth [mm]" >out ||
  fail "a number: $(cat out)"
grep -q "greatest depth \[mm\] = [0-9]" out || fail "no value: $(cat out)"
echo >>$file
"$source/pipelines/provenance" $file >/dev/null && fail "a changed file is not noticed"

# What cannot be read is one message: a record, the crate, a source that is not there any more.
say() {
  "$source/pipelines/provenance" "$@" >out 2>err
  code=$?
  grep -q Traceback err && fail "provenance $*: $(cat err)"
}
cp -r parts broken
echo '{"Command": []}' >broken/sub-01/ses-01/segmentation.json
say broken/sub-01/ses-01/segmentation
refused "$code" 3 "segmentation.json: the record has no Description"
head -c 99 /dev/urandom >broken/sub-01/ses-01/segmentation.json
say broken/sub-01/ses-01/replays/*/metrics.json
refused "$code" 3 "segmentation.json: no readable JSON"
rm broken/work/in/sub-02/ses-01/phantom.json
say broken/sub-02/ses-01/patient --repeat
refused "$code" 3 "phantom.json: No such file"
echo '[]' >broken/ro-crate-metadata.json
say broken --check
refused "$code" 3 "is no RO-Crate"

# Budgets: kept, exceeded, and wrong.
echo '{"format": "acus-budgets/1", "jobs": {"replay": {"cpu_s": 3600, "memory_mb": 9000}},
  "metrics": {"greatest depth [mm]": {"at_least": 1}}}' >wide.json
cohort parts group --participant-label 01 02 --budgets wide.json 2>err || fail "wide budgets: $(cat err)"
[[ $(cut -f 5 parts/group/budgets.tsv | grep -c true) == 3 ]] || fail "wide budgets: $(cat parts/group/budgets.tsv)"
echo '{"format": "acus-budgets/1", "jobs": {"replay": {"cpu_s": 0.001}}, "comparisons": {"share": 1},
  "metrics": {"greatest depth [mm]": {"at_most": 1, "share": 0.6}}}' >tight.json
cohort parts group --participant-label 01 02 --budgets tight.json 2>err
[[ $? == 4 ]] || fail "budgets that are exceeded do not show in the exit code"
for text in "budget replay cpu_s: .* limit 0.001. largest: sub-0" "budget greatest depth \[mm\] share: 0, limit 0.6" \
  "budget comparisons share: n/a"; do
  grep -q "$text" err || fail "no '$text': $(cat err)"
done
echo '{"format": "acus-budgets/1", "jobs": {"replay": {"cpu_s": "3"}}}' >wrong.json
cohort parts --budgets wrong.json 2>err
refused $? 3 "wrong.json: /jobs/replay/cpu_s: must be a number"

# Trends: of two outputs, and again with the table of the first call.
"$source/pipelines/trends" first=whole parts -o trends >/dev/null 2>err || fail "trends: $(cat err)"
"$source/pipelines/trends" trends/trends.tsv third=parts -o trends >/dev/null 2>err || fail "trends again: $(cat err)"
[[ $(cut -f 1 trends/trends.tsv | uniq | wc -l) == 4 ]] || fail "trends: $(cut -f 1 trends/trends.tsv | uniq)"
awk -F '\t' '$2 == "greatest depth [mm]" { print $6 }' trends/trends.tsv | uniq | wc -l | grep -qx 1 ||
  fail "the same replays have other medians"
grep -q "replay: CPU time \[s\]" trends/trends.html || fail "trends: no CPU time"
"$source/pipelines/trends" whole/sub-01 -o trends2 2>err
[[ $? == 3 && ! -e trends2 ]] || fail "trends of no output: $(cat err)"

# An outlier of six runs is named, and shown with its image.
PYTHONPATH=$source/pipelines/cohorts:$source/pipelines/common python3 -B - whole >out 2>&1 <<'PYTHON' || fail "outliers: $(cat out)"
import pathlib, sys
import report
rows = [{"run": f"sub-0{1 + i % 2}/ses-01/replays/smallscenario-insertion", "depth [mm]": 30 + (i % 3) + 40 * (i == 5)}
        for i in range(6)]
parts, table = report._metrics_part(pathlib.Path(sys.argv[1]).resolve(), rows, {"depth [mm]": "mm"})
text = "".join(parts)
assert table[0]["outliers"] == 1 and text.count("spreads from the median") == 1, table
assert 'src="../sub-02/ses-01/segmentation/preview_axial.png"' in text, text
PYTHON

# Labelled images, split by participant: each is in one split, and the files are there.
cohort labels --participant-label 01 02 --labels-in-image png --splits 0.5,0.5,0 2>err ||
  fail "labelled images: $(cat err)"
python3 - labels >out <<'PYTHON' || fail "labelled images: $(cat out)"
import json, pathlib, sys
output = pathlib.Path(sys.argv[1])
manifest = json.loads((output / "group/labelled.json").read_text())
people = sum(manifest["splits"].values(), [])
assert sorted(people) == ["sub-01", "sub-02"] and len(set(people)) == 2, manifest["splits"]
assert min(manifest["frames"]["train"], manifest["frames"]["validation"]) > 0, manifest["frames"]
for sequence in manifest["sequences"]:
    assert sequence["patient"] in manifest["splits"][sequence["split"]], sequence
    for frame in range(sequence["frames"]):
        assert (output / sequence["folder"] / (sequence["files"]["labels"] % frame)).stat().st_size > 0
PYTHON
cohort other --labels-in-image png --splits 0.5,0.2,0.2 2>err && fail "splits that do not add up are taken"
grep -q "splits 0.5,0.2,0.2: give the shares" err || fail "wrong splits: $(cat err)"

# Two people start the same cohort.
flock whole/work/lock sleep 3 &
sleep 0.3
cohort whole 2>err
[[ $? == 3 ]] || fail "two at a time: no exit code 3"
grep -q "another run works in this folder" err || fail "two at a time: $(cat err)"
wait

# A file that another machine has written appears late; one that never does is named.
name=sub-01_ses-01_registration
key=$(basename "$(ls whole/work/done/register/$name.*)")
rm "whole/work/done/register/$key" whole/sub-01/ses-01/registration.json
mv whole/sub-01/ses-01/patient/markers_ct.csv late
(sleep 2; mv late whole/sub-01/ses-01/patient/markers_ct.csv) &
ACUS_LATE_S=20 python3 -B "$source/pipelines/cohorts/job.py" "$PWD/whole/work/plan.json" "$key" 2>err ||
  fail "a late file: $(cat err)"
rm "whole/work/done/register/$key" whole/sub-01/ses-01/registration.json
mv whole/sub-01/ses-01/patient/markers_ct.csv late
ACUS_LATE_S=1 python3 -B "$source/pipelines/cohorts/job.py" "$PWD/whole/work/plan.json" "$key" 2>err &&
  fail "a missing file is not noticed"
mv late whole/sub-01/ses-01/patient/markers_ct.csv
grep -q "markers_ct.csv: not there, or not whole, after 1 s" err || fail "a missing file: $(cat err)"

# A full disk fails jobs with a message, and what there is room for later is made.
if unshare -rm true 2>/dev/null; then
  mkdir disk
  unshare -rm bash -c "mount -t tmpfs -o size=1500k tmpfs disk && '$source/pipelines/cohort' . disk/out \
    --participant-label 01 --set /effects/ultrasound=null --scenario '$source/testdata/small_scenario.json' \
    --cores 2 2>err; echo \$? >code; find disk/out -name '*partial*' -not -path '*/work/*' >left
    mount -o remount,size=100m disk; '$source/pipelines/cohort' . disk/out --participant-label 01 \
    --set /effects/ultrasound=null --set /image_rate_hz=1 --scenario '$source/testdata/small_scenario.json' \
    --cores 2 2>err2 && diff -r disk/out/sub-01 parts/sub-01" >disk.diff || fail "after a full disk: $(cat disk.diff err2)"
  [[ $(cat code) =~ ^[34]$ ]] || fail "a full disk: code $(cat code), $(cat err)"
  [[ ! -s left ]] || fail "left on a full disk: $(cat left)"
fi
[[ $failures == 0 ]] && echo "cohort: all as it should be"
