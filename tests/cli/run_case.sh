#!/usr/bin/env bash
# Runs one command in a fresh folder and checks exit code, messages and files.
# Options are described at acus_add_cli_case in CMakeLists.txt.
set -uo pipefail

folder='' exit_codes='' before='' leaves_nothing=no
in_stdout=() in_stderr=() not_in_stderr=() creates=()
while [[ $# -gt 0 && $1 != -- ]]; do
  case $1 in
    --leaves-nothing) leaves_nothing=yes; shift; continue ;;
    --folder) folder=$2 ;;
    --exit) exit_codes=$2 ;;
    --before) before=$2 ;;
    --stdout) in_stdout+=("$2") ;;
    --stderr) in_stderr+=("$2") ;;
    --not-stderr) not_in_stderr+=("$2") ;;
    --creates) creates+=("$2") ;;
    *) echo "run_case.sh: unknown option $1"; exit 2 ;;
  esac
  shift 2
done
shift
export PATH="$ACUS_BIN:$PATH"
# A finding of a sanitizer must not pass for an exit code of the program.
export ASAN_OPTIONS="exitcode=99:${ASAN_OPTIONS:-}" TSAN_OPTIONS="exitcode=99:${TSAN_OPTIONS:-}"
program=$(basename "$1")
set -- "${@//\$INPUTS/$INPUTS}"

# What lies here, and the contents; many files to a call, as the programs' libraries are hundreds.
listing() {
  find . -mindepth 1 -printf '%y %p %l\n' | sort
  find . -type f -exec sha256sum {} + | sort -k 2
}

rm -rf "$folder" "$folder.stdout" "$folder.stderr"
mkdir -p "$folder"
cd "$folder" || exit 2
if [[ -n $before ]]; then
  bash -euo pipefail -c "$before" || { echo "FAILED: BEFORE did not run"; exit 2; }
fi
[[ $leaves_nothing == yes ]] && was=$(listing)

"$@" >"$folder.stdout" 2>"$folder.stderr" </dev/null
code=$?

failures=0
fail() { echo "FAILED: $*"; failures=$((failures + 1)); }

[[ $code =~ ^($exit_codes)$ ]] || fail "exit code $code, expected $exit_codes"
for regex in "${in_stdout[@]}"; do
  grep -qE -- "$regex" "$folder.stdout" || fail "no line of stdout matches: $regex"
done
for regex in "${in_stderr[@]}"; do
  grep -qE -- "$regex" "$folder.stderr" || fail "no line of stderr matches: $regex"
done
[[ $code == 0 ]] && not_in_stderr+=('[Ww]arning' '[Ee]rror' 'ERROR' 'WARNING')
for regex in "${not_in_stderr[@]}"; do
  # What the case asks for, it gets: an expected warning is no surprise.
  for wanted in "${in_stderr[@]}"; do [[ $wanted =~ $regex ]] && continue 2; done
  grep -qE -- "$regex" "$folder.stderr" && fail "a line of stderr matches: $regex"
done
if [[ $code != 0 && $program == acus-* ]]; then
  messages=$(grep -vE "^$program: warning: " "$folder.stderr" | grep -cE "^$program: ")
  [[ $messages == 1 ]] || fail "$messages messages that begin with '$program: ', expected 1"
fi
for file in "${creates[@]}"; do
  if [[ -d $file ]]; then
    [[ -n $(ls -A "$file") ]] || fail "folder is empty: $file"
  else
    [[ -s $file ]] || fail "missing or empty: $file"
  fi
done
partial=$(find . -name '*.partial*')
[[ -z $partial ]] || fail "left behind: $partial"
if [[ $leaves_nothing == yes ]]; then
  now=$(listing)
  [[ $now == "$was" ]] || fail "the folder changed:"$'\n'"$(diff <(echo "$was") <(echo "$now"))"
fi

if [[ $failures != 0 ]]; then
  echo "command: $*"
  echo "folder:  $folder"
  echo "--- stdout"; head -c 4000 "$folder.stdout"
  echo "--- stderr"; head -c 4000 "$folder.stderr"
  exit 1
fi
