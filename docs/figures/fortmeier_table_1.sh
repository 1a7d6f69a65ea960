#!/usr/bin/env bash
# Repeats table 1 of Fortmeier-2016 (tip deflection against the number of needle nodes) with the rod
# of lib/acus/physics/needle and with a chain of rigid bodies, and what each costs. A minute.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
cmake -S . -B build -G Ninja -DACUS_BENCHMARKS=ON >/dev/null
ninja -C build bench_rod >/dev/null
build/tests/bench_rod --tables
