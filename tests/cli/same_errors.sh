#!/usr/bin/env bash
# Two sweeps gave the same errors, to the last digit; times may differ.
# Usage: same_errors.sh A/tradeoff.csv B/tradeoff.csv
set -euo pipefail
errors() {
  awk -F, 'NR == 1 { for (i = 1; i <= NF; ++i)
             if ($i ~ /^(knob|setting|repetitions|is_.*|unusable)$/ || $i ~ /^force_.*_n/ || $i ~ /^image_(rms|psnr|ssim)/)
               keep[++n] = i }
           { line = ""; for (k = 1; k <= n; ++k) line = line $(keep[k]) ","; print line }' "$1"
}
[[ $(errors "$1" | head -1 | tr ',' '\n' | wc -l) -ge 15 ]] || { echo "FAILED: columns are missing in $1"; exit 1; }
diff <(errors "$1") <(errors "$2") || { echo "FAILED: the errors differ"; exit 1; }
