#!/usr/bin/env python3
"""Runs programs on variants of the files that they accept, made from the descriptions of the formats.

Usage: run.py BIN CONFIGS WORK [--only TEXT] [--every N] [--list]

TEXT is a part of KIND.NAME, such as "dicom." or "rtstruct_hole"; --every N runs each N-th variant, all that
were once mistaken, and none of those that wait for the clock (sessions of 3 s); --list prints right outcomes, too.

Each variant states the exit codes that are right, and what the output must say where it is 0. A variant that
may be read or refused has both codes: a wrong result with exit code 0 is a fault all the same. Exits with 0 if
all outcomes are right. The number of variants of each kind is printed in the end.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys

SOURCE = pathlib.Path(__file__).absolute().parents[3]
sys.path.append(str(SOURCE / "tests/data"))
import cameras
import exports
import frames
import images
import labels
import live
import measure
import mistaken
import ordinary
import shapes
import run_reports
import tables

def faults(case, output, code):
    found = []
    if code not in case["exit"]:
        found.append(f"exit code {code}, not {' or '.join(map(str, case['exit']))}")
    for pattern in case.get("says", []):
        if code in case["exit"] and (code != 0 or case["exit"] == [0]) and not re.search(pattern, output, re.M):
            found.append(f"nothing matches {pattern}")
    for pattern in case.get("never", []):
        if re.search(pattern, output, re.M):
            found.append(f"something matches {pattern}")
    for pattern, expected, within in case.get("values", []):
        if code != 0:
            break
        match = re.search(pattern, output, re.M)
        if match is None:
            found.append(f"no value matches {pattern}")
        elif not abs(float(match.group(1)) - expected) <= within:
            found.append(f"{match.group(1)} for {pattern}, not {expected:g} +- {within:g}")
    if code != 0 and not case.get("may_be_cut") and re.search("cut off", output):
        found.append("says that a whole file is cut off")
    return found


def main():
    bin_folder, configs, work = (pathlib.Path(a).absolute() for a in sys.argv[1:4])
    only = sys.argv[sys.argv.index("--only") + 1] if "--only" in sys.argv else ""
    shutil.rmtree(work, ignore_errors=True)
    inputs = work / "inputs"
    inputs.mkdir(parents=True)
    environment = dict(os.environ, PATH=f"{bin_folder}:{os.environ['PATH']}", ACUS_CONFIGS=str(configs),
                       SESSION=str(inputs / "session_plain"))
    images.nifti(inputs / "patient.nii.gz")
    environment["CT"] = str(inputs / "patient.nii.gz")
    if only.split(".")[0] in ("", "cameras"):
        sample = work / "camera_sample"
        subprocess.run(["acus-camera", "sample", "--count", "1", "-o", sample], env=environment, check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        environment["CAMERA_SAMPLE"] = str(sample)
    if only.split(".")[0] in ("", "streams", "transforms", "igtl", "mistaken"):
        patient = run_reports.make_patient(SOURCE, work, environment)
        environment.update(PATIENT=str(patient), SCENARIO=str(patient / "scenario.json"))
    kinds = {}
    every = int(sys.argv[sys.argv.index("--every") + 1]) if "--every" in sys.argv else 1
    right = total = seen = 0
    for make in MAKERS:
        for case in make(inputs):
            if only not in case["kind"] + "." + case["name"]:
                continue
            seen += 1
            kinds[case["kind"]] = kinds.get(case["kind"], 0) + 1
            if (seen % every and not case.get("always")) or (every > 1 and case.get("waits")):
                continue
            total += 1
            folder = work / "runs" / re.sub(r"\W", "_", case["name"])
            folder.mkdir(parents=True)
            done = subprocess.run(["bash", "-c", case["command"]], cwd=folder, env=environment, text=True,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=60, errors="replace")
            output = done.stdout
            if done.returncode == 0 and case.get("measure"):
                what, made, *names = case["measure"]
                output += getattr(measure, what)(folder / made, *names)
            found = faults(case, output, done.returncode)
            right += not found
            if found or "--list" in sys.argv:
                print(f"{'WRONG' if found else 'right'} {case['kind']}.{case['name']} ({done.returncode})")
                print("".join(f"    {fault}\n" for fault in found) + "    > " +
                      "\n    > ".join(output.strip()[-900:].splitlines()[-7:]))
    print("\n".join(f"{kind:12} {count:4} variants" for kind, count in sorted(kinds.items())))
    print(f"{right} of {total} variants are right")
    return 0 if right == total else 1


MAKERS = [tables.curve_cases, tables.unit_cases, tables.force_cases, images.nifti_cases, images.nrrd_cases,
          images.meta_cases, images.dicom_cases, shapes.surface_cases, shapes.unit_cases, frames.landmark_cases,
          frames.transform_cases, frames.tracker_cases, frames.session_cases, labels.structure_cases,
          labels.segmentation_cases, labels.map_cases, cameras.cases, live.cases,
          exports.machine_cases, exports.landmark_cases, exports.tracker_cases, exports.volume_cases,
          exports.surface_cases, mistaken.cases, ordinary.cases]

if __name__ == "__main__":
    sys.exit(main())
