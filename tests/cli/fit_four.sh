#!/usr/bin/env bash
# Makes s1.csv to s4.csv, each a.csv with other forces, and their fit.
for k in 1 2 3 4; do
  awk -F, -v k=$k 'NR == 1 {print} NR > 1 {print $1 "," $2 "," $3 * (1 + 0.03 * k)}' a.csv > s$k.csv
done
"$ACUS_BIN/acus-fit" s1.csv s2.csv s3.csv s4.csv --models mechanical -o fit > /dev/null
