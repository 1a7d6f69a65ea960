#!/usr/bin/env bash
# Makes, in the current folder, a patient of two surfaces: a block of muscle and, in it, one of bone.
set -euo pipefail
box() { # NAME LOW HIGH, mm: a closed box.
  awk -v low="$2" -v high="$3" 'BEGIN {
    for (n = 0; n < 8; ++n) print "v", n % 2 ? high : low, int(n / 2) % 2 ? high : low, (n > 3 ? high : low)
    print "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6"
  }' >"$1.obj"
}
box muscle -199.7 200.3
box bone -20 20
cat >surfaces.json <<'JSON'
{"format": "acus-surface-scene/1", "spacing_mm": 2,
 "surfaces": [{"file": "muscle.obj", "tissue": "muscle"}, {"file": "bone.obj", "tissue": "bone"}]}
JSON
# images NAME [OPTION...]: what the replay of the small session shows of it, and its forces.
images() {
  local name=$1
  shift
  "$ACUS_BIN/acus-replay" scenarios/alamilla_2021.json "$INPUTS/session" --transform "$INPUTS/ct_from_reference.tfm" \
    --set /effects/view_3d=null --set /image_rate_hz=2 --set /patient/surfaces=surfaces.json "$@" -o "$name" >/dev/null
}
if [[ ${1:-} == compare ]]; then # Images differ by where labels come from, forces do not.
  images voxels
  images triangles --set /effects/ultrasound/alamilla_2021/labels_from=triangles
  cmp triangles/forces.csv voxels/forces.csv
  if cmp -s triangles/images.igs.mha voxels/images.igs.mha; then
    echo "the images do not differ" >&2
    exit 1
  fi
fi
