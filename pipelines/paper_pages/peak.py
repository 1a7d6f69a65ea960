#!/usr/bin/python3
"""Runs a command and writes the largest memory that it had, in MB: peak.py FILE COMMAND..."""
import pathlib
import resource
import subprocess
import sys

code = subprocess.run(sys.argv[2:], check=False).returncode
pathlib.Path(sys.argv[1]).write_text(f"{resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024:.0f}\n", encoding="utf-8")
sys.exit(code)
