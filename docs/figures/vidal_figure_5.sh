#!/usr/bin/env bash
# Repeats Vidal-2008 fig. 5: measured force of a liver puncture, its plateau and the sum of eight
# Gaussians over it. The recording is the synthetic patient's, made by acus-phantom.
# Usage: docs/figures/vidal_figure_5.sh [BUILD_FOLDER]; writes docs/figures/vidal_figure_5.svg.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
bin=$(cd "${1:-$here/../../build}" && pwd)/bin
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"$bin/acus-phantom" patient liver -o patient >/dev/null
"$bin/acus-fit" patient/force_curves/liver_capsule_4.csv --models gaussians -o fit
cp fit/liver_capsule_4_models.svg "$here/vidal_figure_5.svg"
