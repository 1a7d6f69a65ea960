#!/usr/bin/python3
"""Runs a command and writes the largest memory that it had, in MB: peak.py FILE COMMAND...

With AT_MOST="MB SECONDS" in the environment a command that takes more of either is ended; the exit code is 75, and FILE
says which.
"""
import os
import pathlib
import resource
import subprocess
import sys
import time

ENDED = 75


def memory_mb(process):
    """The largest so far, of a process that runs."""
    status = pathlib.Path(f"/proc/{process.pid}/status").read_text(encoding="ascii")
    return sum(int(line.split()[1]) / 1024 for line in status.splitlines() if line.startswith("VmHWM"))


def run(command, most_mb, most_s):
    """Its exit code, and its largest memory in MB or why it was ended."""
    began = time.monotonic()
    with subprocess.Popen(command) as process:
        while process.poll() is None:
            over = [f"more than {most_mb:g} MB"] if memory_mb(process) > most_mb else []
            over += [f"more than {most_s:g} s"] if time.monotonic() - began > most_s else []
            if over:
                process.kill()
                return ENDED, over[0]
            time.sleep(0.05)
    return process.returncode, f"{resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024:.0f}"


if __name__ == "__main__":
    limits = [float(limit) for limit in os.environ.get("AT_MOST", "inf inf").split()]
    code, what = run(sys.argv[2:], *limits)
    pathlib.Path(sys.argv[1]).write_text(f"{what}\n", encoding="utf-8")
    sys.exit(code)
