#!/usr/bin/env bash
# Runs a command on an X display of its own, without a screen, and ends with the command's exit code.
# In place of xvfb-run, which now and then ends with its own exit code when it removes its folder.
set -euo pipefail

coproc xvfb { exec Xvfb -displayfd 1 -screen 0 1280x800x24 -noreset -nolisten tcp 2>/dev/null; }
server=$xvfb_PID
trap 'kill "$server" 2>/dev/null || true' EXIT
read -r number <&"${xvfb[0]}" || { echo "on_display.sh: Xvfb does not start: is package xvfb there?" >&2; exit 3; }
DISPLAY=":$number" "$@"
