#!/usr/bin/env bash
# Makes a.csv: a puncture with known parameters (a1 0.1, a2 0.02 from 4 mm, at 10 mm after contact
# 3 N; then 1 N + 0.02 N/mm; friction 0.03 N/mm), 100 Hz, a small repeatable disturbance. And
# recording/, the same as two files without headers.
awk 'BEGIN {
  print "time_s,depth_mm,force_n"
  for (i = 0; i <= 2700; ++i) {
    t = i / 100
    d = t < 1 ? 0 : t < 11 ? 5 * (t - 1) : t < 16 ? 50 : t < 26 ? 50 - 5 * (t - 16) : 0
    x = d - 4
    if (t < 11) f = x <= 0 ? 0 : x <= 10 ? 0.1 * x + 0.02 * x * x : 1 + 0.02 * (x - 10)
    else if (t < 16) f = 1.72 * (0.6 + 0.4 * exp(-(t - 11)))
    else f = x > 0 ? -0.03 * x * (1 - exp(-(50 - d) / 0.4)) + 1.03 * exp(-(50 - d) / 0.4) : 0
    s = (s * 1103 + 12345) % 65536
    printf "%.2f,%.4f,%.5f\n", t, d, f + 0.1 + 0.02 * (s / 32768 - 1)
  }
}' > a.csv
mkdir -p recording
tail -n +2 a.csv | cut -d, -f1,2 > recording/time_displacement.csv
tail -n +2 a.csv | cut -d, -f1,3 > recording/time_force.csv
