#!/usr/bin/env python3
"""Makes calls of the system fail, one in each run, and looks at how the program ends.

Usage: refused_calls.py LIBRARY PER_KIND NAME COMMAND...

The command writes the folder o. Each kind of call (tests/faults/fail_calls.cpp) fails once at each of
its calls, or at PER_KIND of them, spread evenly, the first and the last among them. A run must end by
itself: with its message and code, and nothing left behind, or complete.
"""
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys

KINDS = ("open", "write", "fsync", "rename", "mkdir", "mmap", "socket", "dlopen", "memory")
TIME_S = 120
RECORDING = "session.json"


def run(library, command, **environment):
    shutil.rmtree("o", ignore_errors=True)
    environment = {**os.environ, "LD_PRELOAD": library, **environment}
    try:
        return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=TIME_S, check=False)
    except subprocess.TimeoutExpired:
        return None


def files_of(folder):
    return sorted(str(path.relative_to(folder)) for path in pathlib.Path(folder).rglob("*"))


def spread(count, most):
    if count <= most:
        return range(1, count + 1)
    return sorted({1 + round(i * (count - 1) / (most - 1)) for i in range(most)})


def problem_of(done, program, whole, before):
    if done is None:
        return f"did not end within {TIME_S} s"
    partial = [name for name in files_of(".") if ".partial" in name]
    if partial:
        return f"left {partial}"
    if done.returncode < 0:
        return f"ended by signal {-done.returncode}"
    whole = set(whole)
    if done.returncode == 0:
        missing = whole - set(files_of("o"))
        return f"exit code 0 without {sorted(missing)}" if missing else ""
    if done.returncode not in (1, 2, 3, 4):
        return f"exit code {done.returncode}"
    if not re.search(rf"^{program}: ", done.stderr, re.MULTILINE):
        return f"exit code {done.returncode} without a message: {done.stderr[-300:]!r}"
    if done.returncode == 1:
        return f"unforeseen: {done.stderr[-300:]!r}"
    left = set(files_of(".")) - before
    # A recording that has begun is kept, whatever happens then.
    if left and f"o/{RECORDING}" not in left:
        return f"left {sorted(left)}"
    return ""


def main(library, per_kind, name, *command):
    pathlib.Path("../calls").unlink(missing_ok=True)
    before = set(files_of("."))
    done = run(library, command, ACUS_CALLS="../calls")
    if done is None or done.returncode != 0:
        sys.exit(f"FAILED: {name} by itself: {done and done.stderr}")
    whole = files_of("o")
    counts = struct.unpack("=9Q", pathlib.Path("../calls").read_bytes())
    failed = 0
    for kind, count in zip(KINDS, counts):
        problems = refused = 0
        tried = list(spread(count, int(per_kind)))
        for number in tried:
            done = run(library, command, ACUS_FAIL=f"{kind}:{number}")
            problem = problem_of(done, pathlib.Path(command[0]).name, whole, before)
            refused += done is not None and done.returncode != 0
            if problem:
                print(f"FAILED: {name}, {kind} {number} of {count}: {problem}")
                problems += 1
        shutil.rmtree("o", ignore_errors=True)
        print(f"{name}: {kind}: {count} calls, {len(tried)} refused one at a time, {refused} ended the program")
        failed += problems
    return failed


if __name__ == "__main__":
    if len(sys.argv) < 5:
        sys.exit(__doc__)
    failures = main(*sys.argv[1:])
    print("every refusal was answered" if failures == 0 else f"{failures} were not")
    sys.exit(1 if failures else 0)
