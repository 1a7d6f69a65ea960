# shellcheck shell=bash disable=SC2154 # Names of pipelines/papers.
# Figure 5 of Vidal-2008: strokes of the virtual needle at the constant speed of the paper's tensile tests, one in each
# of `repetitions` synthetic patients. Expects common.sh.

speed_mm_per_min=500 from_mm=3 edge_before_mm=3 edge_after_mm=3 # Behind the organ's surface: the plateau begins; where the peak is sought.

# entry_and_target CORRIDOR: their six coordinates.
entry_and_target() { awk -F, '$1 == "entry" { e = $2 " " $3 " " $4 } $1 == "target" { t = $2 " " $3 " " $4 } END { print e, t }' "$1"; }

# by_depth ORGAN: the force in steps of 1 mm from where the tip enters the organ, from forces.csv.
by_depth() {
  awk -F, -v organ="$1" 'NR == 1 { next }
    $3 == organ && !entered { from = $2; entered = 1 }
    { depth[NR] = $2; force[NR] = $4; time[NR] = $1; inside[NR] = $3 == organ }
    END { for (i = 3; i <= NR; ++i) { b = int(depth[i] - from + 100) - 100
            if (b < -10 || b >= 20 || (b >= 0 && !inside[i])) continue
            s[b] += force[i]; ++n[b]; if (!(b in first)) first[b] = i; last[b] = i }
          for (b = -10; b < 20; ++b) if (n[b] > 1) { i = first[b]; j = last[b]
            print b + 0.5 "," s[b] / n[b] "," 60 * (depth[j] - depth[i]) / (time[j] - time[i]) } }'
}

# strokes ORGAN KIND
strokes() {
  local organ=$1 kind=$2 seed
  coarse "$kind" 3 "$organ.json"
  rm -f "${organ}"_[0-9]*.csv
  for seed in $(seq "$repetitions"); do
    say "$organ, stroke $seed of $repetitions"
    acus-phantom patient "$kind" -o patient_n --overwrite --quiet --config "$organ.json" --seed "$seed"
    # shellcheck disable=SC2046 # Six words.
    constant_stroke "stroke_$organ" "$speed_mm_per_min" $(entry_and_target patient_n/corridor_ct.csv)
    acus-replay "scenarios/$paper.json" "stroke_$organ" --ct patient_n/ct.nrrd --labels patient_n/labels.seg.nrrd \
      --transform identity --no-sequence --quiet -o run_n --overwrite "${no_images[@]}" --set /effects/probe_force=null >run_n.txt
    by_depth "$organ" <run_n/forces.csv >"${organ}_$seed.csv"
    [[ -s ${organ}_$seed.csv ]] || fail "$paper: stroke $seed does not reach the $organ" 4
  done
  cat "${organ}"_[0-9]*.csv | awk -F, -v organ="$organ" '
    { s[$1] += $2; ++n[$1]; if (!($1 in low) || $2 < low[$1]) low[$1] = $2; if (!($1 in high) || $2 > high[$1]) high[$1] = $2 }
    END { for (b = -9.5; b < 20; ++b) if (n[b]) { print b "," s[b] / n[b] > organ ".mean.csv"
          print b "," low[b] > organ ".low.csv"; print b "," high[b] > organ ".high.csv" } }'
  # The line through the plateau of the mean, by least squares.
  awk -F, -v from="$from_mm" -v organ="$organ" '$1 >= from { ++n; x += $1; y += $2; xx += $1 ^ 2; xy += $1 * $2; a = n == 1 ? $1 : a; b = $1 }
    END { m = (n * xy - x * y) / (n * xx - x * x); c = (y - m * x) / n
      print a "," c + m * a; print b "," c + m * b; print organ "_slope_n_per_mm," m > "/dev/stderr" }' "$organ.mean.csv" \
    >"$organ.line.csv" 2>>facts.csv
  plot "figure_5_$organ.svg" "$repetitions strokes into the $organ at $speed_mm_per_min mm/min" "depth behind the organ's surface [mm]" \
    "resistance [N]" "mean=$organ.mean.csv" "lowest=$organ.low.csv" "highest=$organ.high.csv" "plateau=$organ.line.csv"
}

# Mean and range of the plateau, of the peak before it, and the speed that was measured.
figure_5_facts() {
  local organ
  fact repetitions "$repetitions"
  fact from_mm "$from_mm"
  fact edge_before_mm "$edge_before_mm"
  fact edge_after_mm "$edge_after_mm"
  for organ in kidney liver; do
    for file in "${organ}"_[0-9]*.csv; do
      awk -F, -v from="$from_mm" -v before="$edge_before_mm" -v after="$edge_after_mm" '$1 >= from { s += $2; ++n }
        $1 >= -before && $1 <= after && $2 > peak { peak = $2 } END { print s / n "," peak }' "$file"
    done | awk -F, -v organ="$organ" '{ s += $1; p += $2; if (NR == 1 || $1 < l) l = $1; if ($1 > h) h = $1 }
      END { printf "%s_mean_n,%.4f\n%s_low_n,%.4f\n%s_high_n,%.4f\n%s_peak_n,%.4f\n", organ, s / NR, organ, l, organ, h, organ, p / NR }' >>facts.csv
  done
  cat kidney_[0-9]*.csv liver_[0-9]*.csv | awk -F, '{ s += $3; if (NR == 1 || $3 < l) l = $3; if ($3 > h) h = $3 }
    END { printf "speed_mm_per_min,%.0f\nslowest_mm_per_min,%.1f\nfastest_mm_per_min,%.1f\n", s / NR, l, h }' >>facts.csv
}
