#!/usr/bin/env bash
# Every kind of page: made from the small patient, in the one style, and opened in a browser if chromium is there.
# Usage: pages.sh SOURCE_FOLDER FOLDER
set -euo pipefail
source=$1 folder=$2
export PATH="$ACUS_BIN:$PATH"
rm -rf "$folder"
mkdir -p "$folder"
cd "$folder"
quietly() { "$@" >>made.txt 2>&1; }
patient=(--ct "$INPUTS/ct.nrrd" --labels "$INPUTS/labels.seg.nrrd" --transform "$INPUTS/ct_from_reference.tfm")
few=(--set /patient/corridor="$INPUTS/corridor_ct.csv" --set /image_rate_hz=1 --no-film --no-sequence --quiet)

quietly acus-replay "$INPUTS/scenario.json" "$INPUTS/session" "${patient[@]}" "${few[@]}" --trainee A7 \
  --exercise "$source/configs/exercises/lumbar_puncture.json" -o report
quietly acus-training report -o progress
quietly acus-compare report report -o comparison
quietly acus-segment "$INPUTS/ct.nrrd" --quiet -o segmentation
quietly acus-study report "$INPUTS/study.json" --trials "$INPUTS/trainees" -o study || [[ -s study/study.html ]]
quietly acus-tradeoff scene "$INPUTS/scenario.json" "$INPUTS/session" "${patient[@]}" --seconds 1 \
  --knob step_rate_hz=500,2000 --repetitions 1 -o tradeoff
cp -rL "$INPUTS" suite
quietly acus-regression run suite/suite -o regression || [[ -s regression/regression.html ]]
# Pages of workflows: their parts, with a title and a table of their own.
python3 -B - "$source" <<'PYTHON'
import pathlib, sys
sys.path[:0] = [f"{sys.argv[1]}/pipelines/cohorts", f"{sys.argv[1]}/pipelines/common"]
import pages, trends
points = [("1", [{"quantity": "force", "median": 1.0, "q1": 0.9, "q3": 1.1, "min": 0.8, "max": 1.2, "outside": 0}])]
table = pages.table(["run", "value"], [["one", 1.5]])
pathlib.Path("cohort.html").write_text(pages.page(
    "Cohort", ["<p>2 participants</p>", "<h2>Failures</h2>", table, "<h2>Metrics</h2>",
               pages.strip_plot([1.0, 2.0, 9.0], "mm", {2: 3.0})], ["1 participant failed."]), encoding="utf-8")
pathlib.Path("trends.html").write_text(trends.page_of(points), encoding="utf-8")
PYTHON
(
  export root=$source paper=test
  # shellcheck source=/dev/null
  source "$source/pipelines/paper_pages/common.sh"
  page "A paper"
  heading "Results"
  page_ends
)
mv page.html paper.html
python3 -B "$source/tests/cli/check_pages.py" "$source/pipelines/common/page.css" report/report.html \
  progress/progress.html comparison/comparison.html segmentation/report.html study/study.html \
  tradeoff/tradeoff.html regression/regression.html cohort.html trends.html paper.html
