#!/usr/bin/env python3
"""Runs the table of inputs after public reports and counts the right outcomes.

Usage: run_reports.py BIN CONFIGS SOURCE REPORTS WORK [NAME ...]

Exits with 0 if all outcomes are right but the open ones, with 77 (skipped) if the folder REPORTS is not there.
The table is reports_cases.json beside this file. A case:
  name      of the case
  input     file or folder in REPORTS, which the case is about
  command   for bash, in a folder of its own; $R is REPORTS, $PATIENT the arguments of a small patient
  exit      the exit code that is right
  says      regular expressions, each of which must match a line of the output
  never     regular expressions that no line may match
  values    [pattern with one group, expected, largest difference]
  open      true for an outcome that is known not to be right yet: it is counted as wrong, and only
            its getting right fails the run, so that this mark is taken away
"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys


def make_patient(source, work, environment):
    folder = work / "patient"
    if (folder / "ct_from_reference.tfm").exists():
        return folder
    shutil.rmtree(folder, ignore_errors=True)
    run = lambda *command: subprocess.run(command, env=environment, check=True,
                                          stdout=subprocess.DEVNULL)
    run("acus-phantom", "patient", "lumbar", "--config", str(source / "testdata/small_lumbar.json"),
        "--seed", "1", "-o", str(folder))
    run("acus-register", "--from", str(folder / "markers_mannequin.csv"), "--to",
        str(folder / "markers_ct.csv"), "-o", str(work / "landmark_fit"))
    shutil.copy(source / "testdata/small_scenario.json", folder / "scenario.json")
    shutil.copy(work / "landmark_fit/ct_from_reference.tfm", folder)
    return folder


def faults(case, environment, work):
    folder = work / case["name"]
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    done = subprocess.run(["bash", "-c", case["command"]], cwd=folder, env=environment, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=120,
                          errors="replace")
    found = []
    if done.returncode != case["exit"]:
        found.append(f"exit code {done.returncode}, not {case['exit']}")
    for pattern in case.get("says", []):
        if not re.search(pattern, done.stdout, re.MULTILINE):
            found.append(f"nothing matches {pattern}")
    for pattern in case.get("never", []):
        if re.search(pattern, done.stdout, re.MULTILINE):
            found.append(f"something matches {pattern}")
    for pattern, expected, within in case.get("values", []):
        match = re.search(pattern, done.stdout, re.MULTILINE)
        if match is None:
            found.append(f"no value matches {pattern}")
        elif abs(float(match.group(1)) - expected) > within:
            found.append(f"{match.group(1)} for {pattern}, not {expected} +- {within}")
    if case["exit"] != 0 and re.search("cut off or broken", done.stdout):
        found.append("says that a whole file is cut off or broken")
    return found, done.stdout


def main():
    bin_folder, configs, source, reports, work = (pathlib.Path(a).absolute()
                                                  for a in sys.argv[1:6])
    if "ACUS_TEST_DATA" in os.environ:
        reports = pathlib.Path(os.environ["ACUS_TEST_DATA"]).absolute() / "reports"
    if not reports.is_dir():
        print(f"skipped: there is no folder {reports}")
        return 77
    work.mkdir(parents=True, exist_ok=True)
    environment = dict(os.environ, PATH=f"{bin_folder}:{os.environ['PATH']}",
                       ACUS_CONFIGS=str(configs), R=str(reports))
    patient = make_patient(source, work, environment)
    environment["PATIENT"] = (f"--ct {patient}/ct.nrrd --labels {patient}/labels.seg.nrrd "
                              f"--transform {patient}/ct_from_reference.tfm")
    environment["SET_PATIENT"] = (f"--set /patient/ct={patient}/ct.nrrd "
                                  f"--set /patient/labels={patient}/labels.seg.nrrd --set "
                                  f"/patient/ct_from_reference_file={patient}/ct_from_reference.tfm")
    environment["SCENARIO"] = str(patient / "scenario.json")
    cases = json.loads((pathlib.Path(__file__).parent / "reports_cases.json").read_text())
    wanted = set(sys.argv[6:])
    right = total = unexpected = 0
    for case in cases:
        if wanted and case["name"] not in wanted:
            continue
        if not (reports / case["input"]).exists():
            print(f"MISSING {case['name']}: there is no {case['input']}")
            total += 1
            unexpected += 1
            continue
        total += 1
        found, output = faults(case, environment, work)
        right += not found
        unexpected += bool(found) != case.get("open", False)
        print(("right   " if not found else "open    " if case.get("open") else "WRONG   ") +
              case["name"])
        for fault in found:
            print("    " + fault)
        if found:
            print("    > " + "\n    > ".join(output.strip()[:1500].splitlines()[:12]))
    print(f"{right} of {total} outcomes are right")
    return 1 if unexpected else 0


if __name__ == "__main__":
    sys.exit(main())
