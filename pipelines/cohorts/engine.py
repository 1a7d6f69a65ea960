"""Runs a plan through Snakemake: here, or on a cluster by a profile."""
import fcntl
import json
import os
import pathlib
import signal
import socket
import subprocess
import sys
import time

from files import UserError, write_json

HERE = pathlib.Path(__file__).resolve().parent


def marker(output, job):
    return output / "work/done" / job["rule"] / f"{job['id']}.{job['key']}"


class Lock:
    """One engine for one output folder; freed by the system when its processes have ended."""

    def __init__(self, output):
        path = output / "work/lock"
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self.stream = open(path, "a+", encoding="utf-8")
        except OSError as error:
            raise UserError(f"{error.filename}: cannot be written: {error.strerror}; give another "
                            "output folder") from error
        try:
            fcntl.flock(self.stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self.stream.seek(0)
            raise UserError(f"{output}: another run works in this folder ({self.stream.read().strip()}); "
                            "wait for its end, or give another output folder") from None
        self.stream.truncate(0)
        self.stream.write(f"on {socket.gethostname()}, process {os.getpid()}, since "
                          f"{time.strftime('%Y-%m-%d %H:%M:%S %Z')}\n")
        self.stream.flush()


def to_do(output, plan):
    """Jobs that are not done with what they depend on now. A derivative that was deleted is made
    again; so is what comes after it."""
    todo = []
    for name, job in plan.jobs.items():
        done = marker(output, job)
        missing = not (output / (job["output"] + ".json")).exists() or not (
            output / job["output"]).is_dir()
        if done.exists() and missing:
            done.unlink()
        if not done.exists():
            todo.append(name)
    return todo


def free_memory_mb():
    with open("/proc/meminfo", encoding="utf-8") as stream:
        for line in stream:
            if line.startswith("MemAvailable"):
                return int(line.split()[1]) // 1024
    return 4000


def run(output, plan, todo, *, cores, memory_mb, profile="", quiet=False, retries=0, options=(), titles=False):
    """Runs what is to do; 0 if all of it succeeded. Failures are in work/failed."""
    if not todo:
        return 0
    plan_path = output / "work/plan.json"
    write_json(plan_path, plan.to_json())
    for patient, document in plan.by_patient(todo).items():
        write_json(output / f"work/plans/{patient}.json", document)
    config = output / "work/config.json"
    write_json(config, {"plan": str(plan_path), "todo": todo})
    largest = max(plan.jobs[name]["memory_mb"] for name in todo)
    command = ["snakemake", "--snakefile", str(HERE / "Snakefile"), "--configfile", str(config),
               "--directory", str(output / "work"), "--keep-going", "--nolock",
               # Whether a job is done is said by its marker; jobs of a cluster are never taken up again.
               "--ignore-incomplete", "--rerun-incomplete",
               "--rerun-triggers", "mtime", "--scheduler", "greedy", "--drop-metadata",
               "--keep-incomplete", "--retries", str(retries), "--log-handler-script",
               str(HERE / "progress.py")]
    if profile:
        command += ["--profile", profile]
    else:
        command += ["--cores", str(cores), "--resources", f"mem_mb={max(memory_mb, largest)}"]
    command += options
    write_json(output / "work/progress.json", {
        "todo": {name: plan.jobs[name]["seconds"] for name in todo}, "quiet": quiet,
        "parents": {name: plan.jobs[name]["parents"] for name in todo},
        "titles": {name: [plan.jobs[name]["title"], " ".join(plan.jobs[name]["argv"])]
                   for name in todo if titles}})
    environment = {**os.environ, "PYTHONPATH": f"{HERE}{os.pathsep}{HERE.parent / 'common'}", "PYTHONDONTWRITEBYTECODE": "1",
                   "ACUS_PROGRESS": str(output / "work/progress.json")}
    with open(output / "work/snakemake.log", "w", encoding="utf-8") as log:
        to = os.dup(sys.stderr.fileno())
        environment["ACUS_PROGRESS_TO"] = str(to)
        process = subprocess.Popen(command, stdout=log, stderr=log, env=environment, pass_fds=[to])
        os.close(to)
        try:
            return process.wait()
        except KeyboardInterrupt:
            process.send_signal(signal.SIGINT)
            process.wait()
            print("Interrupted. The same command goes on where it was.", file=sys.stderr)
            raise


def failures(output, plan):
    """What failed with what the plan says now: [{participant, session, rule, message, command}]."""
    found = []
    for path in sorted((output / "work/failed").glob("*.json")):
        document = json.loads(path.read_text(encoding="utf-8"))
        job = plan.jobs.get(path.stem)
        if job and job["key"] == document["key"] and not marker(output, job).exists():
            found.append({**document, "job": path.stem})
    return found
