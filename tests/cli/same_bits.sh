#!/usr/bin/env bash
# Runs one command with one thread and with four: every file must be the same, byte for byte.
# Usage: same_bits.sh FOLDER program argument...   (the output folder is added as -o)
set -euo pipefail
folder=$1
shift
export PATH="$ACUS_BIN:$PATH"
rm -rf "$folder"
cp -rs "$INPUTS" "$folder"
cd "$folder"
"$@" --threads 1 -o one >/dev/null
"$@" --threads 4 -o four >/dev/null
"$@" --threads 4 -o again >/dev/null
# The command line and the time that it took are told in these, and differ as they should.
for other in four again; do
  diff --recursive --brief --exclude provenance.json --exclude run.json --exclude report.html \
    --exclude condensation.json one "$other" || {
    echo "FAILED: one thread and $other differ"
    exit 1
  }
done
[[ $(find one -type f | wc -l) -gt 1 ]] || { echo "FAILED: nothing was written"; exit 1; }
