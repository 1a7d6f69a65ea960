#!/usr/bin/env python3
"""running, success or failed: the state of a Slurm job. Usage: slurm-status.py JOB

The controller may be away for some time, as when it is started again: a job is running until it
says otherwise.
"""
import os
import subprocess
import sys
import time

RUNNING = ("PENDING", "RUNNING", "CONFIGURING", "COMPLETING", "SUSPENDED", "REQUEUED", "REQUEUE_HOLD",
           "RESIZING", "SIGNALING", "STAGE_OUT")
PATIENCE_S = float(os.environ.get("ACUS_SLURM_PATIENCE_S", 300))


def state_of(job):
    deadline = time.monotonic() + PATIENCE_S
    while True:
        asked = subprocess.run(["scontrol", "--oneliner", "show", "job", job], check=False,
                               capture_output=True, text=True)
        for word in asked.stdout.split():
            if word.startswith("JobState="):
                return word.partition("=")[2]
        if "Invalid job id" in asked.stderr:
            return "UNKNOWN"  # Long gone, or lost: Snakemake looks at the outputs.
        if time.monotonic() > deadline:
            return "UNKNOWN"
        time.sleep(2)


STATE = state_of(sys.argv[1].split(";")[0])
print("success" if STATE == "COMPLETED" else "running" if STATE in RUNNING else "failed")
