#!/usr/bin/env bash
# Makes `recording`: a tenth of a second of a needle at 100 Hz.
mkdir recording
cat >recording/session.json <<'JSON'
{"format": "acus-session/1", "name": "short", "streams": [{"tool": "needle", "file": "needle.csv"}]}
JSON
{
  echo time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,status
  for i in 0 1 2 3 4 5 6 7 8 9; do echo "0.0$i,$i,0,0,1,0,0,0,OK"; done
} >recording/needle.csv
