#!/usr/bin/env bash
# Makes the manual pages and shows each; man tells what is wrong with one.
# Usage: man_pages.sh PACKAGING WORKFLOWS
set -eu
python3 -B "$1/man_pages.py" "$ACUS_BIN" "$2" 0.1.0 man
for page in man/*.gz; do
  MANWIDTH=80 man --warnings -l "$page" >/dev/null
done
