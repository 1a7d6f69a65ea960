# shellcheck shell=bash disable=SC2154 # Names of pipelines/papers.
# Parts of pipelines/papers: rows of a page, plots, patients and replays. Sourced, not run.
# Expects: $root, $output, the programs in PATH. Each page runs in its folder, $output/NAME.

fail() {
  echo "pipelines/papers: $1" >&2
  exit "${2:-2}"
}

say() { echo "== $paper: $*" >&2; }

# cpu_count: seconds that the machine's cores have been busy, then those of this page and its programs, then the time.
cpu_count() {
  times >times.txt # Not in a subshell, which has times of its own.
  awk -v now="$(date +%s.%N)" 'FILENAME != "/proc/stat" { for (i = 1; i <= 2; ++i) { split($i, t, /[ms]/); own += 60 * t[1] + t[2] } next }
    $1 == "cpu" { printf "%.2f %.2f %s\n", ($2 + $3 + $4 + $7 + $8 + $9) / '"$(getconf CLK_TCK)"', own, now }' times.txt /proc/stat
}
# load_facts: whether it is a quick run, and which share of the machine other programs used since the page began.
load_facts() {
  cpu_count >cpu_end.txt
  fact quick "${quick:-0}"
  fact cores "$(nproc)"
  fact others_percent "$(awk -v cores="$(nproc)" 'NR == 1 { busy = $1; own = $2; at = $3; next }
    { others = $1 - busy - ($2 - own); printf "%.0f", others <= 0 ? 0 : 100 * others / (cores * ($3 - at)) }' cpu_begin.txt cpu_end.txt)"
}

# page TITLE: begins page.html.
page() {
  cpu_count >cpu_begin.txt
  cat >page.html <<HTML
<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>$1</title><style>$(cat "$root/pipelines/common/page.css")</style></head><body><h1>$1</h1>
<p>$(acus-replay --version | head -n 1); $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1), $(nproc) cores. Times are CPU times.
All numbers are of synthetic patients whose truth is known; pipelines/papers made this page.</p>
HTML
}

heading() { echo "<h2>$1</h2>" >>page.html; }
# fact KEY VALUE: what was measured or set, for the sentences of NAME.toml.
facts_file=facts.csv
fact() { printf '%s,"%s"\n' "$1" "$2" >>"$facts_file"; }
rows() { /usr/bin/python3 -B "$root/pipelines/paper_pages/rows.py" "$root/pipelines/paper_pages/$paper.toml" facts.csv "$@"; }
# table NAME: its rows, filled with the facts.
table() { rows "$1" --csv numbers.csv >>page.html || fail "$paper: no table '$1'; see the message above" 4; }
# caption KEY
caption() { rows --caption "$1" || fail "$paper: no caption '$1'; see the message above" 4; }
note() { echo "<p>$(caption "$1")</p>" >>page.html; }
# figure FILE KEY: an image beside the page, with the caption of that key.
figure() {
  local text
  [[ -s $1 ]] || fail "$paper: $1 was not made" 4
  text=$(caption "$2")
  echo "<figure><img src=\"$1\" alt=\"$text\"><figcaption>$text</figcaption></figure>" >>page.html
}
# runs_of RUN STAGE: how often it ran.
runs_of() { awk -v stage="$2" 'index($0, stage "  ") == 1 && / (step|image) / && !seen { print $(NF - 4); seen = 1 }' "$1.txt"; }
# image_size_facts RUN: pixels of an image beside the probe, from its preset (a still has margins), and of the view in 3D.
image_size_facts() {
  /usr/bin/python3 -B - "$1" "$root/configs" >>facts.csv <<'PYTHON'
import json, pathlib, re, sys
run, configs = map(pathlib.Path, sys.argv[1:])
def read(path):
    return json.loads(re.sub(r"^\s*//.*$", "", path.read_text(encoding="utf-8"), flags=re.M))
scenario = read(run / "run.json")["scenario"]
probe, sizes = read(configs / scenario["probe"]), read(configs / "schema/acus-probe.schema.json")["properties"]
for side in ("width_px", "height_px"):
    print(f"{side},{probe.get(f'image_{side}', sizes[f'image_{side}']['default'])}")
    if scenario["effects"].get("view_3d"):
        print(f"view_{side},{scenario['effects']['view_3d'][side]}")
PYTHON
}
# plan RUN: the effect plan of a run.
plan() {
  { echo "<pre>"; sed -n '/^stage .*rate/,/^stage .*writes/p' "$1.txt" | sed '$d; s/&/\&amp;/g; s/</\&lt;/g'; echo "</pre>"; } >>page.html
}
page_ends() { echo "</body></html>" >>page.html; }

# patient KIND NAME [acus-phantom option...]: a patient with truth, and its registration.
patient() {
  local kind=$1 name=$2 # And its registration_NAME.txt.
  shift 2
  acus-phantom patient "$kind" "$@" -o "$name" --overwrite --quiet
  acus-register --quiet --from "$name/markers_mannequin.csv" --to "$name/markers_ct.csv" \
    --target "$name/target_ct.csv" -o "registration_$name" --overwrite >"registration_$name.txt" 2>&1
}

# coarse KIND FACTOR FILE: the preset of a patient on voxels that many times as long.
coarse() {
  awk -v factor="$2" '/"grid":/ {
      split($0, part, /"spacing_mm": \[|\], "size": \[|\]\}/)
      split(part[2], s, ", "); split(part[3], n, ", ")
      printf "%s\"spacing_mm\": [%g, %g, %g], \"size\": [%d, %d, %d]},\n", part[1], factor * s[1],
             factor * s[2], factor * s[3], n[1] / factor, n[2] / factor, n[3] / factor
      next
    } { print }' "$root/configs/phantoms/$1.json" >"$3"
}

# withdrawn_before_turning FILE: a patient whose hand leaves the skin before it turns the needle, as it must where the
# direction is locked, and presses on the bone that it meets.
withdrawn_before_turning() {
  sed -i 's/{"to": "depth", "depth_mm": 14, "aim": "bone"/{"to": "start", "aim": "bone"/; s/"name": "lumbar_puncture",/&\n    "bone_press_mm": 1.5,/' "$1"
  grep -q '"bone_press_mm"' "$1" || fail "$1 is no patient with a lumbar puncture"
}

# resized KIND "X Y Z" FILE: the preset of a patient on so many voxels along each axis.
resized() {
  awk -v voxels="$2" 'BEGIN { split(voxels, n, " ") } /"grid":/ {
      split($0, part, /"spacing_mm": \[|\], "size": \[|\]\}/); split(part[2], s, ", "); split(part[3], m, ", ")
      printf "%s\"spacing_mm\": [%.6f, %.6f, %.6f], \"size\": [%d, %d, %d]},\n", part[1], s[1] * m[1] / n[1], s[2] * m[2] / n[2],
             s[3] * m[3] / n[3], n[1], n[2], n[3]
      next
    } { print }' "$root/configs/phantoms/$1.json" >"$3"
}

# replay RUN PATIENT SESSION [acus-replay argument...]: with the paper's preset; --explain in RUN.txt, its memory in
# RUN.mb.
replay() {
  local run=$1 name=$2 session=$3
  shift 3
  /usr/bin/python3 -B "$root/pipelines/paper_pages/peak.py" "$run.mb" \
    acus-replay "scenarios/$paper.json" "$session" --labels "$name/labels.seg.nrrd" \
    --transform "registration_$name/ct_from_reference.tfm" --no-sequence --quiet --explain \
    -o "$run" --overwrite "$@" >"$run.txt"
}
no_images=(--set /effects/ultrasound=null --set /effects/ct_slice=null --set /effects/fluoroscopy=null
  --set /effects/view_3d=null)

# time_of RUN STAGE: microseconds of CPU time for each run of a stage.
time_of() {
  awk -v stage="$2" 'index($0, stage "  ") == 1 && / (step|image) / && !seen { print $(NF - 1); seen = 1 }' "$1.txt"
}
# awake_us RUN STAGE: the same, of the runs in which it did not sleep.
awake_us() {
  awk -v stage="$2" 'index($0, stage "  ") == 1 && / (step|image) / && !seen {
    print 1000 * $(NF - 2) / ($(NF - 4) * (1 - 0.01 * $(NF - 3)) + 1e-9); seen = 1 }' "$1.txt"
}
# step_us RUN: of all stages of the force loop together.
step_us() { awk '/^stage .*writes/ { exit } / step +in / { us += $(NF - 1) } END { printf "%.3g", us }' "$1.txt"; }
# metric RUN NAME: value with its unit, as acus-replay prints it.
metric() { sed -n "s/^ *$2: //p" "$1.txt" | head -n 1; }
number() { metric "$1" "$2" | awk '{ print $1 }'; }
# stage_ms RUN STAGE: CPU time of an image.
stage_ms() { awk -v us="$(time_of "$1" "$2")" 'BEGIN { print us / 1000 }'; }

# shortened FROM TO SECONDS: the first seconds of a session.
shortened() {
  mkdir -p "$2"
  cp "$1/session.json" "$2"
  local file
  for file in "$1"/*.csv; do awk -F, -v end="$3" 'NR == 1 || $1 <= end' "$file" >"$2/$(basename "$file")"; done
}

# session_of FOLDER TOOL: a session of one tool, its rows from standard input.
session_of() {
  mkdir -p "$1"
  printf '{"format": "acus-session/1", "name": "%s", "reference_frame": "Reference", "streams": [{"file": "%s.csv", "tool": "%s"}]}\n' \
    "$1" "$2" "$2" >"$1/session.json"
  { echo "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,status"; cat; } >"$1/$2.csv"
}

# constant_stroke FOLDER MM_PER_MIN X Y Z X Y Z: a needle from 10 mm before one point to the other, in CT space.
constant_stroke() {
  awk -v speed="$2" -v from="$3 $4 $5" -v to="$6 $7 $8" 'BEGIN { split(from, a, " "); split(to, b, " ")
      for (i = 1; i <= 3; ++i) { d[i] = b[i] - a[i]; l += d[i] ^ 2 }
      l = sqrt(l); for (i = 1; i <= 3; ++i) d[i] /= l
      w = sqrt((1 + d[3]) / 2); qx = -d[2] / (2 * w); qy = d[1] / (2 * w)
      for (k = 0; ; ++k) { s = -10 + speed / 60 * k / 1000; if (s > l) break
        printf "%.3f,%.7f,%.7f,%.7f,%.12f,%.12f,%.12f,0,OK\n", k / 1000, a[1] + s * d[1], a[2] + s * d[2], a[3] + s * d[3], w, qx, qy } }' |
    session_of "$1" needle
}

# plot FILE.svg TITLE X Y NAME=FILE.csv...: lines through the first two columns of CSVs without header; an empty line begins another.
plot() {
  local file=$1 title=$2 x=$3 y=$4
  shift 4
  awk -F, -v title="$title" -v xname="$x" -v yname="$y" -v series="$*" '
    # 1, 2 or 5 times a power of ten: at most six ticks.
    function tick(range, step) { step = 10 ^ int(log(range) / log(10) - 3); while (range / step > 6) step *= range / step > 30 ? 10 : range / step > 12 ? 5 : 2; return step }
    function label(v, step) { return v * v < 1e-12 * step * step ? 0 : v }
    function first(low, step, n) { n = int(low / step - 1e-9); return (n < low / step - 1e-9 ? n + 1 : n) * step }
    BEGIN {
      split("#1f6fb4 #d1495b #2e8b57 #b07d12 #6a4c93", colour, " ")
      n = split(series, s, " ")
      xl = yl = 1e30; xh = yh = -1e30
      for (i = 1; i <= n; ++i) {
        name[i] = file[i] = s[i]; sub(/=.*/, "", name[i]); sub(/.*=/, "", file[i]); gsub(/_/, " ", name[i])
        while ((getline line < file[i]) > 0) {
          if (line == "") { gap[i, count[i]] = 1; continue }
          split(line, v, ","); k = ++count[i]; px[i, k] = v[1] + 0; py[i, k] = v[2] + 0
          if (v[1] + 0 < xl) xl = v[1] + 0; if (v[1] + 0 > xh) xh = v[1] + 0
          if (v[2] + 0 < yl) yl = v[2] + 0; if (v[2] + 0 > yh) yh = v[2] + 0
        }
      }
      if (xh <= xl) xh = xl + 1; if (yh <= yl) yh = yl + 1
      W = 760; H = 400; L = 70; B = 50; T = 40; R = 15
      printf "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" height=\"%d\" font-family=\"sans-serif\" font-size=\"13\"><rect width=\"100%%\" height=\"100%%\" fill=\"white\"/>\n", W, H
      printf "<text x=\"%d\" y=\"22\" font-size=\"15\">%s</text><text x=\"%d\" y=\"%d\">%s</text><text transform=\"translate(16,%d) rotate(-90)\">%s</text>\n", L, title, W / 2, H - 10, xname, H / 2 + 30, yname
      step = tick(xh - xl)
      for (at = first(xl, step); at <= xh + 1e-9 * step; at += step) {
        X = L + (W - L - R) * (at - xl) / (xh - xl)
        printf "<line x1=\"%.1f\" y1=\"%d\" x2=\"%.1f\" y2=\"%d\" stroke=\"#ddd\"/><text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">%.6g</text>", X, T, X, H - B, X, H - B + 18, label(at, step)
      }
      step = tick(yh - yl)
      for (at = first(yl, step); at <= yh + 1e-9 * step; at += step) {
        Y = H - B - (H - B - T) * (at - yl) / (yh - yl)
        printf "<line x1=\"%d\" y1=\"%.1f\" x2=\"%d\" y2=\"%.1f\" stroke=\"#ddd\"/><text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">%.6g</text>\n", L, Y, W - R, Y, L - 6, Y + 4, label(at, step)
      }
      for (i = 1; i <= n; ++i) {
        printf "<polyline fill=\"none\" stroke=\"%s\" stroke-width=\"1.4\" points=\"", colour[i]
        stride = int(count[i] / 4000) + 1
        for (k = 1; k <= count[i]; k += stride) {
          printf "%.1f,%.1f ", L + (W - L - R) * (px[i, k] - xl) / (xh - xl), H - B - (H - B - T) * (py[i, k] - yl) / (yh - yl)
          if (gap[i, k]) printf "\"/><polyline fill=\"none\" stroke=\"%s\" stroke-width=\"1.4\" points=\"", colour[i]
        }
        printf "\"/><text x=\"%d\" y=\"%d\" fill=\"%s\">%s</text>\n", L + 12, T + 4 + 17 * i, colour[i], name[i]
      }
      print "</svg>"
    }' >"$file"
}
# column RUN/forces.csv NAME: time and that column, as CSV without header.
column() { awk -F, -v name="$2" 'NR == 1 { for (i = 1; i <= NF; ++i) if ($i == name) c = i; next } { print $1 "," $c }' "$1"; }
