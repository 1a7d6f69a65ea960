#!/usr/bin/env bash
# Makes, in the current folder, what the cases of acus-register image read: a slanted bone as a
# surface, a scenario and a probe, and a frame drawn from the same geometry: grey, a bright line at
# the bone's surface, and a dark shadow below it.
cat > bone.obj <<'OBJ'
v -8 15 -25
v 8 19 -25
v 8 27 -25
v -8 27 -25
v -8 15 25
v 8 19 25
v 8 27 25
v -8 27 25
f 1 3 2
f 1 4 3
f 5 6 7
f 5 7 8
f 1 2 6
f 1 6 5
f 4 7 3
f 4 8 7
f 1 8 4
f 1 5 8
f 2 3 7
f 2 7 6
OBJ
cat > surfaces.json <<'JSON'
{"format": "acus-surface-scene/1", "surfaces": [{"file": "bone.obj", "tissue": "bone"}]}
JSON
cat > probe.json <<'JSON'
{"format": "acus-probe/1", "name": "small", "kind": "linear", "frequency_mhz": 7.5,
 "width_mm": 40, "depth_mm": 40, "focus_mm": 20, "gain_db": 10, "tgc_db_per_cm": 5,
 "dynamic_range_db": 100, "image_width_px": 160, "image_height_px": 160}
JSON
cat > scene.json <<'JSON'
{"format": "acus-scenario/1", "patient": {"surfaces": "surfaces.json"}, "probe": "probe.json",
 "effects": {"ultrasound": {"model": "aperture", "aperture": {"volume": "labels"}}}}
JSON
awk 'BEGIN {
  print "P2 160 160 255"
  for (r = 0; r < 160; ++r) {
    row = ""
    for (c = 0; c < 160; ++c) {
      state = (state * 1103 + 12345) % 65536
      x = (c - 79.5) / 4; surface = 17 + x / 4; y = r / 4
      grey = 110
      if (x > -8 && x < 8 && y > surface) grey = y < surface + 0.8 ? 220 : 25
      row = row (grey + state % 12) " "
    }
    print row
  }
}' > frame.pgm
# Off by 2 mm along and 1.5 mm across the image.
printf '1 0 0 2 0 1 0 -1.5 0 0 1 0 0 0 0 1\n' > start.txt
printf '1 0 0 2 0 1 0 900 0 0 1 0 0 0 0 1\n' > far.txt
