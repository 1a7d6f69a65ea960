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

# Recordings at 20 Hz. A pointer of 100 mm rests at the markers, after 2 s on the table.
header=time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,status
awk -F, -v header="$header" 'BEGIN { print header; t = 0; rest(300, 300, 0) }
  function pose(x, y, z) { printf "%.2f,%.4f,%.4f,%.4f,1,0,0,0,OK\n", t, x, y, z - 100; t += 0.05 }
  function rest(x, y, z) { for (i = 0; i < 40; ++i) pose(x + 0.02 * sin(9 * i), y, z)
                           for (i = 1; i < 8; ++i) pose(x, y, z + 30 * i) }
  NR > 1 { rest($2, $3, $4) }' mannequin.csv > touches.csv
awk -v header="$header" 'BEGIN { print header
  for (i = 0; i < 200; ++i) printf "%.2f,%.4f,%.4f,%.4f,1,0,0,0,OK\n", 0.05 * i,
    100 + 0.1 * sin(17 * i), 0.1 * sin(29 * i), 900 + 0.1 * sin(41 * i) }' > still.csv
printf 'name,x_mm,y_mm,z_mm\nA,0,0,0\nB,102.1,0,0\n' > measured.csv
printf 'name,x_mm,y_mm,z_mm\nA,0,0,0\nB,100,0,0\n' > known.csv
# A handle that turns about x and y; the marker sits at (10, 20, 30) on it, not turned; the tracker
# stands at (0, 0, -500).
awk -v header="$header" 'BEGIN { print header > "handle.csv"; print header > "marker.csv"
  for (i = 0; i < 60; ++i) {
    a = 0.6 * sin(0.3 * i); if (i % 2) { cx = cos(a / 2); sx = sin(a / 2); cy = 1; sy = 0 }
    else { cx = 1; sx = 0; cy = cos(a / 2); sy = sin(a / 2) }
    x = 20 * sin(0.2 * i); y = 10 * cos(0.1 * i); z = 5 * sin(0.4 * i)
    printf "%.2f,%.9f,%.9f,%.9f,%.12f,%.12f,%.12f,0,OK\n", 0.05 * i, x, y, z, cx * cy, sx, sy > "handle.csv"
    if (i % 2) { mx = 10; my = 20 * cos(a) - 30 * sin(a); mz = 20 * sin(a) + 30 * cos(a) }
    else { mx = 10 * cos(a) + 30 * sin(a); my = 20; mz = -10 * sin(a) + 30 * cos(a) }
    printf "%.2f,%.9f,%.9f,%.9f,%.12f,%.12f,%.12f,0,OK\n", 0.05 * i, x + mx, y + my, z + mz + 500,
      cx * cy, sx, sy > "marker.csv"
  } }'
# One motion by two trackers, the clock of the second 64.8 ms ahead.
awk -v header="$header" 'BEGIN { split("0 0.0648", ahead, " ")
  for (k = 1; k <= 2; ++k) { file = "log" k ".csv"; print header > file
    for (i = 0; i < 300; ++i) { t = i / 20; p = 2 * t + 0.05 * t * t
      printf "%.4f,%.5f,%.5f,3,1,0,0,0,OK\n", t + ahead[k], 40 * sin(p), 20 * cos(0.7 * p) > file } } }'
# Two facets 100 mm apart on a mannequin that moves; CT is turned by a quarter about z.
printf 'facet,name,x_mm,y_mm,z_mm\n' > facets.csv
printf 'facet,name,x_mm,y_mm,z_mm\n' > facets_ct.csv
for facet in front side; do
  shift_mm=$([[ $facet == front ]] && echo 0 || echo 100)
  for point in 'a 0 0 0' 'b 30 0 0' 'c 30 40 0' 'd 0 40 5'; do
    echo "$facet $point $shift_mm" | awk '{ print $1 "," $2 "," $3 "," $4 "," $5 >> "facets.csv"
      print $1 "," $2 "," (-$4 + 7) "," ($3 + $6 + 8) "," ($5 + 9) >> "facets_ct.csv" }'
  done
done
awk 'BEGIN { print "time_s,facet,x_mm,y_mm,z_mm,qw,qx,qy,qz,status"
  for (i = 0; i < 20; ++i) {
    printf "%.2f,front,%.6f,0,800,1,0,0,0,OK\n", 0.05 * i, 3 * i
    printf "%.2f,side,%.6f,0,800,1,0,0,0,OK\n", 0.05 * i, 3 * i + 100
  } }' > facet_poses.csv
# A bumpy closed skin as .obj, points swept over its front from where the mannequin sees them (moved by
# 5, -3, 4 mm), and the skin of a mannequin that is 3 % fatter.
awk 'function place(i, j, wide) {
    la = 3.14159265 * (i / 24 - 0.5); lo = 6.2831853 * j / 36; c = cos(la)
    b = 1 + 0.08 * cos(2 * lo + 1) * c + 0.06 * sin(3 * la + lo) * c + 0.05 * cos(3 * lo - 2 * la) * c
    x = 75 * b * c * cos(lo) * wide; y = 50 * b * c * sin(lo) * wide; z = 100 * b * sin(la)
  }
  BEGIN {
    print "name,x_mm,y_mm,z_mm" > "sweep.csv"
    for (i = 0; i <= 24; ++i) for (j = 0; j < 36; ++j) {
      place(i, j, 1.03); print "v", x, y, z > "mannequin.obj"
      place(i, j, 1); print "v", x, y, z > "skin.obj"
      if (y > -10 && i > 3 && i < 21) printf ",%.4f,%.4f,%.4f\n", x - 5, y + 3, z - 4 > "sweep.csv"
    }
    for (i = 0; i < 24; ++i) for (j = 0; j < 36; ++j) {
      a = 36 * i + j + 1; d = 36 * i + (j + 1) % 36 + 1
      face = "f " a " " d " " (d + 36) "\nf " a " " (d + 36) " " (a + 36)
      print face > "skin.obj"; print face > "mannequin.obj"
    }
  }'
# The CT of that body, as text NRRD: 5 mm voxels; soft tissue within an ellipsoid, bone in its middle.
for what in ct labels; do
  [[ $what == ct ]] && type=short || type=uchar
  printf 'NRRD0004\ntype: %s\ndimension: 3\nsizes: 38 28 48\nspace: left-posterior-superior\nspace directions: (5,0,0) (0,5,0) (0,0,5)\nspace origin: (-92.5,-67.5,-117.5)\nencoding: text\n\n' "$type" > body_$what.nrrd
  awk -v what=$what 'BEGIN { for (k = 0; k < 48; ++k) for (j = 0; j < 28; ++j) { row = ""
    for (i = 0; i < 38; ++i) {
      x = -92.5 + 5 * i; y = -67.5 + 5 * j; z = -117.5 + 5 * k
      inside = (x / 75) ^ 2 + (y / 50) ^ 2 + (z / 100) ^ 2 < 1; bone = x * x + y * y < 144 && z * z < 4900
      row = row (what == "ct" ? (bone ? 700 : inside ? 40 : -1000) : (bone ? 5 : inside ? 4 : 0)) " "
    } print row } }' >> body_$what.nrrd
done
printf '1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n' > start.txt
printf '1 0 0 0 0 1 0 900 0 0 1 0 0 0 0 1\n' > far.txt
# Images of three N of wires, 5 mm apart, from a probe that is moved: 0.08 mm a pixel, whose first
# pixel is at (11, 50, -4) in the frame of the probe's marker; and a stylus's tip in these images.
cat > wires.csv <<'CSV'
pattern,wire,front_x_mm,front_y_mm,front_z_mm,back_x_mm,back_y_mm,back_z_mm
1,a1,20,0,10,20,40,10
1,b1,40,0,10,25,40,10
1,c1,45,0,10,45,40,10
2,a2,20,0,5,20,40,5
2,b2,25,0,5,45,40,5
2,c2,50,0,5,50,40,5
3,a3,20,0,0,20,40,0
3,b3,45,0,0,25,40,0
3,c3,50,0,0,50,40,0
CSV
awk -F, 'NR > 1 { name[NR] = $2; front[NR] = $3; back[NR] = $6; z[NR] = $5; last = NR }
  END { pose = "x_mm,y_mm,z_mm,qw,qx,qy,qz"
    print "time_s,wire,u_px,v_px," pose > "wire_points.csv"
    print "time_s,u_px,v_px,tip_x_mm,tip_y_mm,tip_z_mm," pose > "tips.csv"
    print "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,status" > "probe.csv"
    for (i = 0; i < 20; ++i) {
      x = 57 + 2 * sin(7 * i); y = 8 + 24 * i / 19; d = 22 + 3 * sin(3 * i)
      turn = sprintf("%.9f,%.9f,%.9f,0,0,0.707106781187,-0.707106781187", x + 11, y - 4, d + 50)
      print 0.5 * i "," turn ",OK" > "probe.csv"
      for (w = 2; w <= last; ++w) printf "%.1f,%s,%.6f,%.6f,%s\n", 0.5 * i, name[w],
        (x - front[w] - (back[w] - front[w]) * y / 40) / 0.08, (d - z[w]) / 0.08, turn > "wire_points.csv"
      u = 300 + 250 * sin(5 * i); v = 240 + 220 * cos(4 * i)
      printf "%.1f,%.6f,%.6f,%.6f,%.6f,%.6f,%s\n", 0.5 * i, u, v, x - 0.08 * u, y, d - 0.08 * v,
        turn > "tips.csv"
    } }' wires.csv
