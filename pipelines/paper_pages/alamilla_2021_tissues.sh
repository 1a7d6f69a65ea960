# shellcheck shell=bash disable=SC2154 # Names of pipelines/papers.
# Table II of Alamilla-2021: a needle at constant speed through every tissue of the table, from the back of the shoulder
# through bursa, tendon and cartilage into the head of the humerus. Expects common.sh.

# through_all_tissues PATIENT: layers.svg, and facts of the cutting force in each tissue.
through_all_tissues() {
  local speed_mm_per_s=15 press_mm=3
  # CT mm; 10 mm before the skin, and the middle of the humeral head.
  constant_stroke through $((60 * speed_mm_per_s)) -36.4 -44.8 43.5 5 0 20
  acus-replay "scenarios/$paper.json" through --labels "$1/labels.seg.nrrd" --transform identity --no-sequence --quiet \
    -o run_through --overwrite "${no_images[@]}" --set /effects/tissue=null >run_through.txt
  # The same with a wall four times as stiff.
  sed 's/"cutting_stiffness_n_per_mm": 0.25/"cutting_stiffness_n_per_mm": 1/' "$root/configs/forces/alamilla.json" >stiff_wall.json
  acus-replay "scenarios/$paper.json" through --labels "$1/labels.seg.nrrd" --transform identity --no-sequence --quiet \
    -o run_stiff_wall --overwrite "${no_images[@]}" --set /effects/tissue=null \
    --set "/effects/needle_force/table=$PWD/stiff_wall.json" >run_stiff_wall.txt
  fact stiff_wall_bursa_n "$(awk -F, '$3 == "bursa" && $6 > m { m = $6 } END { print m }' run_stiff_wall/forces.csv)"
  awk -F, 'NR > 1 { print $2 "," $6 }' run_through/forces.csv >layers.csv
  plot layers.svg "Through all tissues of table II" "depth [mm]" "cutting force [N]" cutting_force=layers.csv
  fact speed_mm_per_s $speed_mm_per_s
  fact wall_n_per_mm "$(sed -n 's/.*"cutting_stiffness_n_per_mm": \([0-9.]*\).*/\1/p' "$root/configs/forces/alamilla.json")"
  awk -F, -v press="$press_mm" 'NR == 1 { for (i = 1; i <= NF; ++i) at[$i] = i; next }
    { t = $at["tissue"]; n = $at["cutting_n"]; d = $at["depth_mm"] }
    t == "bone" { if (!("bone" in from)) { from["bone"] = 1; met = $1 }
      if (($1 - met) * '"$speed_mm_per_s"' <= press && $at["bone_n"] > bone) bone = $at["bone_n"]; next }
    t != last { before[t] = force; from[t] = d; most[t] = n; last = t }
    { if (d - from[t] > way[t]) way[t] = d - from[t]; if (n > most[t]) most[t] = n; force = n }
    END { split("muscle bursa tendon cartilage", name, " ")
      for (i = 1; i <= 4; ++i) { t = name[i]; printf "%s_mm,%.1f\n%s_n,%.4f\n%s_before_n,%.4f\n", t, way[t], t, most[t], t, before[t] }
      printf "bone_n,%.4f\nbone_press_mm,%s\n", bone, press }' run_through/forces.csv >>facts.csv
}
