"""The command line of pipelines/provenance: how a file or number of a cohort came about."""
import argparse
import os
import pathlib
import shlex
import subprocess
import sys
import tempfile

import crate
import job as jobs
import plan as plans
import user
from files import UserError, read_json, read_tsv, sha256_of

EPILOG = """\
Exit code 0, or 4 if a file is not what its record says, or a repetition gives other bytes.

EXAMPLE
  pipelines/provenance derivatives/acus/sub-001/ses-01/registration/registration.json
  pipelines/provenance derivatives/acus/sub-001/ses-01/registration/registration.json --repeat
  pipelines/provenance derivatives/acus/group/metrics.tsv --cell sub-001 "greatest depth [mm]"
"""


def parser():
    p = argparse.ArgumentParser(
        prog="pipelines/provenance", epilog=EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Prints how a file of a cohort came about: program, build, command, inputs by SHA-256, "
                    "back to the sources.")
    p.add_argument("file", help="file or folder of a cohort's output; with --job or --check, the output folder")
    p.add_argument("--repeat", action="store_true",
                   help="run exactly that command again, alone, in a temporary folder, and compare all bytes")
    p.add_argument("--cell", nargs=2, metavar=("PARTICIPANT", "COLUMN"),
                   help="a number of group/metrics.tsv")
    p.add_argument("--job", default="", metavar="NAME", help="run a job that failed again, as the report names it")
    p.add_argument("--check", action="store_true", help="check the RO-Crate of the output folder and all hashes")
    return p


def root_of(path):
    """The output folder of the cohort that a file belongs to."""
    for folder in [path, *path.parents]:
        if (folder / "dataset_description.json").is_file() and (folder / "work").is_dir():
            return folder
    raise UserError(f"{path}: not in the output of pipelines/cohort (no folder above has "
                    "dataset_description.json and work)")


def read_record(path):
    """The record of a derivative; None of a JSON file that is none."""
    record = read_json(path)
    if not isinstance(record, dict) or "Command" not in record:
        return None
    missing = [key for key in ("Description", "GeneratedBy", "Inputs", "InputsOfProgram", "Outputs")
               if key not in record]
    if missing:
        raise UserError(f"{path}: the record has no {missing[0]}; delete it, and pipelines/cohort makes it again")
    return record


def record_of(root, name):
    """(path of the record, record) of a derivative's file, or of the derivative itself."""
    for folder in [pathlib.Path(name), *pathlib.Path(name).parents]:
        path = root / (str(folder) + ".json")
        if str(folder) != "." and path.is_file():
            record = read_record(path)
            if record:
                return str(folder) + ".json", record
    return None, None


def print_chain(root, name, record, depth, seen):
    pad = "  " * depth
    maker = record["GeneratedBy"][0]
    print(f"{pad}{name.removesuffix('.json')}: {record['Description']}")
    print(f"{pad}  by {maker['Name']} {maker['Version']}, SHA-256 {maker['Sha256'][:16]}")
    print(f"{pad}  $ {shlex.join(record['Command'])}")
    for one in record["Inputs"]:
        print(f"{pad}  from {one['path']}  {one['sha256'][:16]}")
    for file, sha256 in sorted(record["InputsOfProgram"].items()):
        if file not in {os.path.basename(one["path"]) for one in record["Inputs"]}:
            print(f"{pad}  read {file}  {sha256[:16]}")
    for parent in sorted({one["made_by"] for one in record["Inputs"] if one["made_by"]}):
        if parent in seen:
            print(f"{pad}  {parent.removesuffix('.json')}: see above")
            continue
        seen.add(parent)
        before = read_record(root / parent)
        if before is None:
            raise UserError(f"{root / parent}: is no record of a cohort; {name} was made from what it describes")
        print_chain(root, parent, before, depth + 1, seen)


def run_alone(root, argv, inputs):
    """Runs a command in a temporary folder that has only its inputs: (folder, exit code)."""
    folder = tempfile.TemporaryDirectory(prefix="acus-repeat-")
    for name in inputs:
        place = pathlib.Path(folder.name, name)
        place.parent.mkdir(parents=True, exist_ok=True)
        if not place.exists():
            place.symlink_to((root / name).resolve() if name.startswith("work/in") else root / name)
    pathlib.Path(folder.name, argv[argv.index("-o") + 1]).parent.mkdir(parents=True, exist_ok=True)
    program = plans.find_program(plans.program_folder(), argv[0])
    done = subprocess.run([program, *argv[1:]], cwd=folder.name, check=False, stdout=subprocess.DEVNULL,
                          env={**os.environ, "OPENBLAS_NUM_THREADS": "1"})
    return folder, done.returncode


def repeat(root, record):
    argv = record["Command"]
    changed = [one["path"] for one in record["Inputs"] if sha256_of(root / one["path"]) != one["sha256"]]
    if changed:
        print(f"{changed[0]}: has changed since; the bytes below may differ for that reason")
    program = plans.find_program(plans.program_folder(), argv[0])
    if sha256_of(program) != record["GeneratedBy"][0]["Sha256"]:
        print(f"{argv[0]}: another build than {record['GeneratedBy'][0]['Version']}, which made it")
    folder, code = run_alone(root, argv, [one["path"] for one in record["Inputs"]])
    with folder:
        differ = []
        for made in record["Outputs"]:
            again = pathlib.Path(folder.name, made["path"])
            if not again.is_file() or sha256_of(again) != made["sha256"]:
                differ.append(made["path"])
    if differ:
        print(f"exit code {code}; {len(differ)} of {len(record['Outputs'])} files differ: {', '.join(differ[:5])}")
        return 4
    print(f"repeated: {len(record['Outputs'])} files with the same bytes")
    return 0


def repeat_job(root, name):
    plan = read_json(root / "work/plan.json")
    if name not in plan["jobs"]:
        raise UserError(f"--job {name}: no such job in {root}/work/plan.json")
    job = plan["jobs"][name]
    os.chdir(root)
    jobs.link_sources(job)
    argv = jobs.expanded(job["argv"])
    inputs = {p for word in argv[1:] for p in (word, word.partition("=")[2]) if p and os.path.exists(p)}
    print(shlex.join(argv))
    folder, code = run_alone(root, argv, sorted(inputs - {job["output"]}))
    folder.cleanup()
    print(f"exit code {code}")
    return 0 if code == 0 else 4


def cell(root, path, subject, column):
    header, rows = read_tsv(path)
    if column not in header:
        raise UserError(f"{path}: no column '{column}'; there is {', '.join(header)}")
    found = [r for r in rows if r["participant_id"].removeprefix("sub-") == subject.removeprefix("sub-")]
    if not found:
        raise UserError(f"{path}: no row of {subject}")
    for row in found:
        print(f"{row['participant_id']} {row['session_id']} {column} = {row[column]}: "
              f"metric '{column.partition(' [')[0]}' of {row['run']}/metrics.json")
    return found[0]["run"] + "/metrics.json"


def run(arguments):
    path = pathlib.Path(arguments.file).resolve()
    if not path.exists():
        raise UserError(f"{arguments.file}: no such file or folder")
    root = root_of(path)
    if arguments.check:
        problems = crate.problems_of(root)
        print("\n".join(problems[:50]) or f"{root}: the crate is complete, all files are unchanged")
        return 4 if problems else 0
    if arguments.job:
        return repeat_job(root, arguments.job)
    name = str(path.relative_to(root))
    if arguments.cell:
        name = cell(root, path, *arguments.cell)
    place, record = record_of(root, name)
    if record is None:
        raise UserError(f"{arguments.file}: no record says how it was made; tables of group/ are read with "
                        "--cell")
    code = 0
    for made in record["Outputs"]:
        if made["path"] == name:
            same = sha256_of(root / name) == made["sha256"]
            print(f"{name}  SHA-256 {made['sha256']}{'' if same else '  CHANGED since it was made'}")
            code = 0 if same else 4
    print_chain(root, place, record, 0, {place})
    return repeat(root, record) if arguments.repeat else code


def main(words):
    return user.call("pipelines/provenance", run, parser().parse_intermixed_args(words))
