#!/usr/bin/env bash
# Makes cube.csv: tension, compression and shear of Ogden's law with mu 1.5 kPa and exponent -12.
awk 'BEGIN {
  print "mode,stretch_or_shear,stress_kpa"
  for (i = -10; i <= 10; ++i) {
    l = 1 + i / 100
    printf "axial,%.2f,%.6f\n", l, 3 / -12 * (l ^ -13 - l ^ 5)
    s = i / 100 + sqrt(1 + i * i / 10000)
    printf "shear,%.2f,%.6f\n", i / 50, 3 / -12 * (s ^ -12 - s ^ 12) / (s + 1 / s)
  }
}' > cube.csv
