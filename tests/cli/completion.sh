#!/usr/bin/env bash
# What Tab offers, by the file that is installed. Usage: completion.sh PACKAGING WORKFLOWS
set -eu
export PATH="$ACUS_BIN:$PATH"
python3 -B "$1/completions.py" "$ACUS_BIN" "$2" made
compopt() { :; }  # Only there while a key is pressed.
# shellcheck source=/dev/null
source made/bash-completion/completions/acus

# offer TITLE word...: what completes the last word.
offer() {
  local title=$1
  shift
  COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)) COMPREPLY=()
  _acus
  echo "$title: ${COMPREPLY[*]}"
}
offer subcommands acus-camera ''
offer options acus-replay --overw
offer commands acus rep
offer presets acus-replay needles/sp
offer choices acus-breathing --model ''
offer "through acus" acus replay --overw
offer kinds acus list need
zsh -f "$(dirname "$0")/completion.zsh" "$PWD/made/zsh/vendor-completions" | sed 's/^/zsh, /'
