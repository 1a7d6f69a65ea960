#!/usr/bin/env bash
# Makes the images of docs/clinician_tutorial.md: every view of the window of a live session, of the
# synthetic liver patient, in a virtual X server. Needs ffmpeg, to make the files small. Half a minute.
# Usage: docs/figures/window.sh [BUILD_FOLDER]; writes docs/figures/window_*.png.
# Builds nothing: make acus-phantom and window_figures first.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
build=$(cd "${1:-$here/../../build}" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"$build/bin/acus-phantom" patient liver -o patient --quiet
"$here/../../pipelines/common/on_display.sh" "$build/tests/window_figures" patient .
for image in window_*.png; do
  ffmpeg -nostdin -loglevel error -y -i "$image" \
    -vf "split[a][b];[a]palettegen=max_colors=256[p];[b][p]paletteuse=dither=none" \
    -compression_level 100 "$here/$image"
done
