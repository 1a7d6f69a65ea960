#!/usr/bin/env bash
# Makes, in the current folder, what the cases of acus-register read.
# Six markers on a mannequin, and the same in CT: turned by a quarter about z, moved, and localised
# to a few tenths of a millimetre.
cat > mannequin.csv <<'CSV'
name,x_mm,y_mm,z_mm
A,80,0,0
B,-80,0,10
C,0,60,-20
D,0,-60,0
E,40,30,70
F,-40,-30,-70
CSV
cat > ct.csv <<'CSV'
name,x_mm,y_mm,z_mm
A,10.2,280,300.1
B,9.9,120.1,310
C,-50,200.2,280
D,70.1,199.8,300
E,-20,240.1,369.9
F,40.1,160,230
CSV
printf 'name,x_mm,y_mm,z_mm\ncanal,10,200,300\n' > target.csv
# A pointer whose tip, at (1, 2, 150) in its own frame, rests at (10, 20, 30).
mkdir poses
number=0
for rotation in '1 0 0 0 1 0 0 0 1' '0.6 0 0.8 0 1 0 -0.8 0 0.6' '1 0 0 0 0.6 -0.8 0 0.8 0.6' \
    '1 0 0 0 0.6 0.8 0 -0.8 0.6' '0.6 0 -0.8 0 1 0 0.8 0 0.6'; do
  number=$((number + 1))
  echo "$rotation" | awk '{
    for (i = 0; i < 3; ++i) {
      x = $(3 * i + 1); y = $(3 * i + 2); z = $(3 * i + 3)
      print x, y, z, 10 * (i + 1) - (x + 2 * y + 150 * z)
    }
    print "0 0 0 1"
  }' > poses/$number.txt
done
