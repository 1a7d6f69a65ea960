#!/usr/bin/env bash
# Two servers on one port: the second says so and ends.
exec 3< <(exec acus-devices hand --port 0 --seconds 30)
first=$!
read -r -u 3 _ _ _ port
acus-devices hand --port "$port" --seconds 1
code=$?
kill "$first"
exit "$code"
