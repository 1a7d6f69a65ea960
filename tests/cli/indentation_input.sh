#!/usr/bin/env bash
# Makes a.csv, b.csv and c.csv: 1 mm/s into 12, 13 and 14 mm of neo-Hookean tissue, held at 4 mm
# for 10 s, while the force falls to 0.5 with 1 s.
for i in 1 2 3; do
  awk -v thick="$((11 + i))" -v scale="0.$i" 'BEGIN {
    print "time_s,force_n,indentation_mm,tool_gap_mm"
    for (n = 0; n <= 150; ++n) {
      t = n / 10
      d = t < 0.5 ? 0 : t < 4.5 ? t - 0.5 : 4
      l = 1 - d / thick
      s = 1 / (l * l) - l
      q = q * exp(-0.1) + (s - before) * (1 - exp(-0.1)) / 0.1
      before = s
      printf "%.1f,%.5f,%.4f,%.4f\n", t, 0.01 + scale * (0.5 * s + 0.5 * q), d, thick - d
    }
  }' > "$(echo abc | cut -c$i).csv"
done
