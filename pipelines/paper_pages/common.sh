# shellcheck shell=bash disable=SC2154 # Names of pipelines/papers.
# Parts of pipelines/papers: rows of a page, plots, patients and replays. Sourced, not run.
# Expects: $root, $output, the programs in PATH. Each page runs in its folder, $output/NAME.

fail() {
  echo "pipelines/papers: $1" >&2
  exit "${2:-2}"
}

say() { echo "== $paper: $*" >&2; }

# page TITLE: begins page.html.
page() {
  cat >page.html <<HTML
<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>$1</title><style>
body { font: 15px/1.45 sans-serif; max-width: 76em; margin: 2em auto; padding: 0 1em; color: #222; }
table { border-collapse: collapse; } td, th { border: 1px solid #bbb; padding: .3em .6em; vertical-align: top; text-align: left; }
img { max-width: 100%; } figure { margin: 1.5em 0; } figcaption { color: #555; } pre { background: #f4f4f4; padding: .6em; overflow-x: auto; }
</style></head><body><h1>$1</h1>
<p>$(acus-replay --version | head -n 1); $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1), $(nproc) cores. Times are CPU times.
All numbers are of synthetic patients whose truth is known; pipelines/papers made this page.</p>
HTML
}

heading() { echo "<h2>$1</h2>" >>page.html; }
note() { echo "<p>$1</p>" >>page.html; }
table_begins() {
  echo "<table><tr><th>quantity</th><th>the paper</th><th>Acus</th><th>on what</th><th>where they differ, and why</th></tr>" >>page.html
}
# row QUANTITY PAPER OURS ON WHY
row() {
  printf '<tr><td>%s</td><td>%s</td><td><b>%s</b></td><td>%s</td><td>%s</td></tr>\n' "$@" >>page.html
  printf '%s,"%s","%s"\n' "$1" "$2" "$3" >>numbers.csv
}
table_ends() { echo "</table>" >>page.html; }
# figure FILE CAPTION: an image beside the page.
figure() {
  [[ -s $1 ]] || fail "$paper: $1 was not made" 4
  echo "<figure><img src=\"$1\" alt=\"$2\"><figcaption>$2</figcaption></figure>" >>page.html
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

# replay RUN PATIENT SESSION [acus-replay argument...]: with the paper's preset; --explain in RUN.txt.
replay() {
  local run=$1 name=$2 session=$3
  shift 3
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
# per_s MS...: how often a second, of times in ms.
per_s() { awk -v ms="$*" 'BEGIN { n = split(ms, t, " "); for (i = 1; i <= n; ++i) s += t[i]; printf "%.3g", 1000 / s }'; }

# shortened FROM TO SECONDS: the first seconds of a session.
shortened() {
  mkdir -p "$2"
  cp "$1/session.json" "$2"
  local file
  for file in "$1"/*.csv; do awk -F, -v end="$3" 'NR == 1 || $1 <= end' "$file" >"$2/$(basename "$file")"; done
}

# plot FILE.svg TITLE X Y NAME=FILE.csv...: lines through the first two columns of CSVs without header.
plot() {
  local file=$1 title=$2 x=$3 y=$4
  shift 4
  awk -F, -v title="$title" -v xname="$x" -v yname="$y" -v series="$*" 'BEGIN {
      split("#1f6fb4 #d1495b #2e8b57 #b07d12 #6a4c93", colour, " ")
      n = split(series, s, " ")
      xl = yl = 1e30; xh = yh = -1e30
      for (i = 1; i <= n; ++i) {
        name[i] = file[i] = s[i]; sub(/=.*/, "", name[i]); sub(/.*=/, "", file[i]); gsub(/_/, " ", name[i])
        while ((getline line < file[i]) > 0) {
          split(line, v, ","); k = ++count[i]; px[i, k] = v[1] + 0; py[i, k] = v[2] + 0
          if (v[1] + 0 < xl) xl = v[1] + 0; if (v[1] + 0 > xh) xh = v[1] + 0
          if (v[2] + 0 < yl) yl = v[2] + 0; if (v[2] + 0 > yh) yh = v[2] + 0
        }
      }
      if (xh <= xl) xh = xl + 1; if (yh <= yl) yh = yl + 1
      W = 760; H = 400; L = 70; B = 50; T = 40; R = 15
      printf "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" height=\"%d\" font-family=\"sans-serif\" font-size=\"13\"><rect width=\"100%%\" height=\"100%%\" fill=\"white\"/>\n", W, H
      printf "<text x=\"%d\" y=\"22\" font-size=\"15\">%s</text><text x=\"%d\" y=\"%d\">%s</text><text transform=\"translate(16,%d) rotate(-90)\">%s</text>\n", L, title, W / 2, H - 10, xname, H / 2 + 30, yname
      for (i = 0; i <= 5; ++i) {
        xv = xl + (xh - xl) * i / 5; yv = yl + (yh - yl) * i / 5
        X = L + (W - L - R) * i / 5; Y = H - B - (H - B - T) * i / 5
        printf "<line x1=\"%.1f\" y1=\"%d\" x2=\"%.1f\" y2=\"%d\" stroke=\"#ddd\"/><text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">%.3g</text>", X, T, X, H - B, X, H - B + 18, xv
        printf "<line x1=\"%d\" y1=\"%.1f\" x2=\"%d\" y2=\"%.1f\" stroke=\"#ddd\"/><text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">%.3g</text>\n", L, Y, W - R, Y, L - 6, Y + 4, yv
      }
      for (i = 1; i <= n; ++i) {
        printf "<polyline fill=\"none\" stroke=\"%s\" stroke-width=\"1.4\" points=\"", colour[i]
        stride = int(count[i] / 4000) + 1
        for (k = 1; k <= count[i]; k += stride) printf "%.1f,%.1f ", L + (W - L - R) * (px[i, k] - xl) / (xh - xl), H - B - (H - B - T) * (py[i, k] - yl) / (yh - yl)
        printf "\"/><text x=\"%d\" y=\"%d\" fill=\"%s\">%s</text>\n", L + 12, T + 4 + 17 * i, colour[i], name[i]
      }
      print "</svg>"
    }' >"$file"
}
# column RUN/forces.csv NAME: time and that column, as CSV without header.
column() { awk -F, -v name="$2" 'NR == 1 { for (i = 1; i <= NF; ++i) if ($i == name) c = i; next } { print $1 "," $c }' "$1"; }
