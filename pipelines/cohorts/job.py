#!/usr/bin/env python3
"""Runs one job of a plan: one program, into one folder, with a record of how it was made.

Usage: job.py PLAN JOB; PLAN is that of the job's patient.

Files, all below the folder of the plan's output:
  DERIVATIVE.json           the record: program, build, command, inputs and outputs by SHA-256. It
                            holds no time, host or absolute path: the same job gives the same bytes.
  work/done/RULE/JOB.KEY    says that the job is done; the key is that of all that it depends on
  work/measured/JOB.json    start, duration, CPU time, memory, host
  work/failed/JOB.json      exit code, message, and the command that repeats it
"""
import csv
import fcntl
import glob
import json
import os
import pathlib
import re
import resource
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import time

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "common"))

from files import UserError, sha256_of, write_json, write_whole  # noqa: E402

LATE_S = float(os.environ.get("ACUS_LATE_S", 60))  # For files that another machine has written.


def marker(job):
    return pathlib.Path("work/done") / job["rule"] / f"{job['id']}.{job['key']}"


def point(file, name):
    """'x,y,z' of a named point of a CSV of landmarks."""
    with open(file, newline="", encoding="utf-8") as stream:
        for row in csv.reader(stream):
            if row and row[0] == name:
                return ",".join(row[1:4])
    raise UserError(f"{file}: has no point named {name}")


def title(file):
    """What is punctured, from where, and why that was chosen, by the truth.json of a scene."""
    with open(file, encoding="utf-8") as stream:
        insertion = json.load(stream)["insertion"]
    text = f"{insertion['title']}, {insertion['length_mm']:.0f} mm deep"
    text += f", {insertion['window']}" if insertion["window"] else ""
    text += f". In the image: {insertion['image']['text']}" if insertion["image"] else ""
    return text + (f". Chosen: {insertion['reason']}" if insertion["reason"] else "")


def expanded(argv):
    """The command as it is run: patterns of files, points of CSV files (@point:FILE:NAME) and the title of a scene
    (@title:FILE)."""
    words = []
    for word in argv:
        match = re.search(r"@point:(.*):(\w+)$", word)
        titled = re.search(r"@title:(.*)$", word)
        if match:
            words.append(word[:match.start()] + point(match[1], match[2]))
        elif titled:
            words.append(word[:titled.start()] + json.dumps(title(titled[1])))
        elif "*" in word:
            found = sorted(glob.glob(word))
            if not found:
                raise UserError(f"{word}: no such file")
            words.extend(found)
        else:
            words.append(word)
    return words


def record_path(job):
    return pathlib.Path(job["output"] + ".json")


def is_made(job):
    """Whether the derivative is there as its record says, though its marker is not: an engine that
    starts a job of a cluster again deletes the markers of what that job had finished."""
    path = record_path(job)
    if not path.exists():
        return False
    record = json.loads(path.read_text(encoding="utf-8"))
    return record.get("Key") == job["key"] and all(
        os.path.exists(o["path"]) and os.path.getsize(o["path"]) == o["bytes"] for o in record["Outputs"])


def wait_for_parents(plan, job):
    """The records of the parents, once all files that they list are there at their sizes."""
    deadline = time.monotonic() + LATE_S
    records = {}
    for name in job["parents"]:
        path = record_path(plan["jobs"][name])
        while True:
            missing = path
            if path.exists():
                record = json.loads(path.read_text(encoding="utf-8"))
                late = [o["path"] for o in record["Outputs"] if not os.path.exists(o["path"]) or
                        os.path.getsize(o["path"]) != o["bytes"]]
                if not late:
                    records[str(path)] = record
                    break
                missing = late[0]
            if time.monotonic() > deadline:
                raise UserError(f"{missing}: not there, or not whole, after {LATE_S:.0f} s; it was "
                                f"made by {name}. Delete {path} and start again to make it again")
            time.sleep(0.2)
    return records


def read_with(path):
    """A file that a command names, and what programs read beside it: of labels, which parts are unsure."""
    quality = os.path.join(os.path.dirname(path), "quality.json")
    return [path, quality] if os.path.basename(path) == "labels.seg.nrrd" else [path]


def inputs_of(job, argv, records):
    """What the command names and reads, by hash; that of a parent with its record."""
    made = {o["path"]: (o["sha256"], path) for path, r in records.items() for o in r["Outputs"]}
    folders = {path.removesuffix(".json"): path for path in records}
    found = {}
    for word in argv[1:]:
        for path in {p for part in (word, word.partition("=")[2]) for p in read_with(part)}:
            if not path or path == job["output"] or not os.path.exists(path):
                continue
            parent = next((r for f, r in folders.items() if path == f or path.startswith(f + "/")),
                          None)
            sha256 = made[path][0] if path in made else sha256_of(path)
            found[path] = {"path": path, "sha256": sha256, "made_by": parent}
    for path in job["links"]:
        if path not in found:
            found[path] = {"path": path, "sha256": sha256_of(path), "made_by": None}
    return [found[path] for path in sorted(found)]


def outputs_of(job):
    folder = pathlib.Path(job["output"])
    return [{"path": str(p), "sha256": sha256_of(p), "bytes": p.stat().st_size}
            for p in sorted(folder.rglob("*")) if p.is_file()]


def link_sources(job):
    """Names without folders for what is outside of the cohort: they carry participant ids only."""
    for name, target in job["links"].items():
        if name == target:
            continue
        if not os.path.exists(target):
            raise UserError(f"{name}: its source does not exist; see the path of {job['participant']} "
                            f"{job['session']} in cohort.tsv of the input")
        path = pathlib.Path(name)
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.is_symlink() and os.readlink(path) == target:
            continue
        partial = path.with_name(f".partial-{os.getpid()}-{path.name}")
        os.symlink(target, partial)
        os.replace(partial, path)


def message_of(log):
    """What the program says of its error: its last message with all of its lines, or the last line."""
    lines = [line for line in log.splitlines() if line.strip()]
    begins = [i for i, line in enumerate(lines) if re.match(r"acus-\w+: (?!warning)", line)]
    return "\n".join(lines[begins[-1]:] if begins else lines[-1:] or ["no message"])[:2000]


def remove_partial(job):
    """What a program that was killed has left beside its output; nobody else makes that now."""
    folder, name = os.path.split(job["output"])
    for left in glob.glob(f"{glob.escape(folder) or '.'}/.partial-*-{glob.escape(name)}"):
        shutil.rmtree(left, ignore_errors=True)


def run_program(plan, job, argv, lock):
    """Runs it to its end; returns (exit code, its messages, what it took). It holds the lock with this process: if
    only this process is killed, the next waits for the end of the program."""
    starts = pathlib.Path("work/starts") / f"{job['id']}.{job['key']}"
    starts.parent.mkdir(parents=True, exist_ok=True)
    with open(starts, "a", encoding="utf-8") as stream:
        stream.write(f"{time.time():.3f} {socket.gethostname()}\n")
    log = pathlib.Path("work/logs") / f"{job['id']}.log"
    log.parent.mkdir(parents=True, exist_ok=True)
    begin = time.time()
    with open(log, "w", encoding="utf-8") as stream:
        process = subprocess.Popen([plan["bin"] + "/" + argv[0], *argv[1:]], stdin=subprocess.DEVNULL,
                                   stdout=stream, stderr=subprocess.STDOUT, pass_fds=[lock],
                                   env={**os.environ, **plan["environment"]})
        signal.signal(signal.SIGTERM, lambda *_: process.terminate())
        signal.signal(signal.SIGINT, lambda *_: process.terminate())
        code = process.wait()
    seconds = time.time() - begin
    text = log.read_text(encoding="utf-8", errors="replace")
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    measured = {
        "key": job["key"], "rule": job["rule"], "start_s": begin, "seconds": seconds,
        "cpu_s": used.ru_utime + used.ru_stime, "memory_mb": used.ru_maxrss / 1024,
        "host": socket.gethostname(), "features": job["features"],
        "predicted_s": job["seconds"], "predicted_mb": job["memory_mb"]}
    return code, text, measured


def record_of(job, argv, inputs):
    """The sidecar of a derivative."""
    read = {}
    own = pathlib.Path(job["output"]) / "provenance.json"
    if own.exists():
        document = json.loads(own.read_text(encoding="utf-8"))
        read, version = document["input_sha256"], document["version"]
    else:
        version = ""
    return {"Description": job["title"], "Rule": job["rule"], "Key": job["key"],
            "GeneratedBy": [{"Name": argv[0], "Version": version, "Sha256": job["program_sha256"]}],
            "Command": argv, "Inputs": inputs, "InputsOfProgram": read,
            "Outputs": outputs_of(job)}


def fail(plan, job, argv, code, text):
    """Folders of sources may carry names of patients: messages have the names of the links."""
    for name, target in job["links"].items():
        text = text.replace(target, name)
    text = text.replace(plan["output"] + "/", "")
    write_json(f"work/failed/{job['id']}.json", {
        "key": job["key"], "rule": job["rule"], "participant": job["participant"],
        "session": job["session"], "exit_code": code, "message": text,
        "command": shlex.join(argv)})
    print(f"{job['id']}: {text}", file=sys.stderr)
    return 1


def run(plan, job, lock):
    """0 if the job is done: now, or by someone else before."""
    argv = job["argv"]
    try:
        records = wait_for_parents(plan, job)
        link_sources(job)
        argv = expanded(argv)
        inputs = inputs_of(job, argv, records)
        remove_partial(job)
        code, text, measured = run_program(plan, job, argv, lock)
        if code < 0:
            return fail(plan, job, argv, code, f"ended by signal {-code} ({signal.Signals(-code).name})")
        if code != 0 and code not in job["allow"]:
            return fail(plan, job, argv, code, message_of(text))
        if code != 0 and not os.path.isdir(job["output"]):
            # What a program may refuse without harm: an empty folder with its message.
            os.makedirs(job["output"])
            write_whole(f"{job['output']}/refused.txt", message_of(text) + "\n")
        write_json(f"work/measured/{job['id']}.json", measured)
        write_json(record_path(job), record_of(job, argv, inputs))
        pathlib.Path(f"work/failed/{job['id']}.json").unlink(missing_ok=True)
        write_whole(marker(job), "")
    except UserError as error:
        return fail(plan, job, argv, 3, str(error))
    except OSError as error:
        return fail(plan, job, argv, 3, f"{error.filename or job['output']}: {error.strerror}")
    return 0


def main(plan_path, name):
    plan = json.loads(pathlib.Path(plan_path).read_text(encoding="utf-8"))
    job = plan["jobs"][name.rpartition(".")[0]]
    os.chdir(plan["output"])
    lock = pathlib.Path("work/locks") / job["id"]
    lock.parent.mkdir(parents=True, exist_ok=True)
    with open(lock, "w", encoding="utf-8") as stream:
        # A job of an engine that was killed may still run: it is waited for, and not run again.
        fcntl.flock(stream, fcntl.LOCK_EX)
        if marker(job).exists() or is_made(job):
            write_whole(marker(job), "")
            return 0
        if os.path.exists(job["output"] + "/refused.txt"):
            shutil.rmtree(job["output"])
        return run(plan, job, stream.fileno())


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2]))
