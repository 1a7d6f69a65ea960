#!/usr/bin/env bash
# Runs every EXAMPLE command of a program's help, as it stands, in a folder with the small patient.
# Usage: run_examples.sh PROGRAM FOLDER
set -euo pipefail
program=$1 folder=$2
export PATH="$ACUS_BIN:$PATH"

rm -rf "$folder"
cp -rs "$INPUTS" "$folder"
cd "$folder"

# Lines that begin with a program below EXAMPLE; a backslash at the end continues.
examples=$("$program" --help | sed -n '/EXAMPLE/,$p' | sed -e ':a' -e '/\\$/N; s/\\\n */ /; ta' |
  sed -nE "s/^ *(\$ )?(acus(-[a-z]+)? .*)/\2/p")
if [[ -z $examples ]]; then
  echo "FAILED: the help of $program has no EXAMPLE"
  exit 1
fi
while IFS= read -r example; do
  echo "\$ $example"
  bash -euo pipefail -c "$example" </dev/null || {
    echo "FAILED with exit code $?: $example"
    exit 1
  }
done <<<"$examples"
partial=$(find . -name '*.partial*')
[[ -z $partial ]] || { echo "FAILED: left behind: $partial"; exit 1; }
