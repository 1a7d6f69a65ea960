"""The command line of pipelines/cohort."""
import argparse
import os
import pathlib
import shutil
import subprocess
import sys
import time

import budgets
import crate
import engine
import labelled
import plan as plans
import report
import user
from files import UserError, read_json, read_tsv, write_json, write_tsv, write_whole
from sources import read_sources
from wording import counted, duration

EPILOG = """\
INPUT has participants.tsv and either the files of each participant as
sub-LABEL/ses-LABEL/KIND/NAME, or a table cohort.tsv with the columns participant_id, session_id,
kind, path, seed and series that names them wherever they are. Kinds: phantom, ct, labels,
label_mapping, atlas, phases, force_curves, markers_ct, markers_mannequin, target, corridor, recording, scenario.

Exit code 0 if all participants succeeded, 4 if some failed or a budget is exceeded: the report names
them, with the message and the command that repeats the job. Interrupted, the same command goes on where it was.

EXAMPLE
  pipelines/cohort study study/derivatives/acus
"""


def parser():
    p = argparse.ArgumentParser(
        prog="pipelines/cohort", epilog=EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter,
        description="From a table of patients to prepared scenarios, replays, comparisons and one "
                    "report. What is up to date is not made again.")
    p.add_argument("input", help="folder with the sources of the cohort")
    p.add_argument("output", help="folder of the derivatives")
    p.add_argument("level", nargs="?", choices=["participant", "group"],
                   help="only the jobs of participants, or only the report; default: both")
    p.add_argument("--participant-label", nargs="+", default=[], metavar="LABEL",
                   help="only these participants, with or without sub-")
    p.add_argument("--session-label", nargs="+", default=[], metavar="LABEL", help="only these sessions")
    p.add_argument("--scenario", action="append", default=[], metavar="FILE",
                   help="scenario to replay, a file or preset; may be given several times. Default: "
                        "scenarios/lumbar_puncture.json, or those of the sources")
    p.add_argument("--set", action="append", default=[], metavar="/POINTER=VALUE",
                   help="change a value of all scenarios")
    p.add_argument("--mesh", action="store_true", help="also make tetrahedral meshes")
    p.add_argument("--film", action="store_true", help="also make film.mp4 of each replay")
    p.add_argument("--no-sequence", action="store_true", help="write no images.igs.mha")
    p.add_argument("--labels-in-image", default="none", choices=["none", "png", "nifti", "hdf5"],
                   help="also write the labelled images of each replay, and group/labelled.json with "
                        "their splits")
    p.add_argument("--splits", default="0.7,0.15,0.15", metavar="SHARES",
                   help="of participants in train, validation and test; default: %(default)s")
    p.add_argument("--split-seed", type=int, default=0, metavar="N",
                   help="another seed, other participants in each split")
    p.add_argument("--reference", default="", metavar="FOLDER",
                   help="output of an earlier run of the same cohort: each replay is compared with it")
    p.add_argument("--tolerances", default="tolerances/default.json", metavar="FILE",
                   help="for the comparisons; default: %(default)s")
    p.add_argument("--budgets", default="", metavar="FILE",
                   help="what jobs may take and how accurate replays must be (acus-budgets/1); exit code 4 "
                        "if a budget is exceeded")
    p.add_argument("--segmentation", default="", metavar="FILE", help="settings of acus-segment")
    p.add_argument("--cores", type=int, default=os.cpu_count(), help="default: all, %(default)s")
    p.add_argument("--memory-gb", type=float, default=0.0, help="default: what is free")
    p.add_argument("--profile", default="", metavar="NAME",
                   help="of Snakemake; slurm: the one that is shipped. OUTPUT must be seen by all nodes")
    p.add_argument("--jobs", type=int, default=0, help="jobs at a time in a cluster")
    p.add_argument("--patients-per-job", type=int, default=1,
                   help="of a cluster: several small patients in one job")
    p.add_argument("--retries", type=int, default=0,
                   help="how often a job that failed is started again, with more memory each time")
    p.add_argument("--dry-run", action="store_true", help="say what there is to do, and how long it takes")
    p.add_argument("--quiet", action="store_true", help="no progress, only errors")
    return p


def check(arguments):
    if arguments.cores < 1:
        raise UserError(f"--cores {arguments.cores}: must be 1 or more")
    if arguments.memory_gb < 0:
        raise UserError(f"--memory-gb {arguments.memory_gb:g}: must not be negative")
    if arguments.patients_per_job < 1:
        raise UserError(f"--patients-per-job {arguments.patients_per_job}: must be 1 or more")
    if arguments.reference and not pathlib.Path(arguments.reference).is_dir():
        raise UserError(f"--reference {arguments.reference}: no such folder")
    labelled.shares_of(arguments.splits)
    if shutil.which("snakemake") is None:
        raise UserError("Snakemake is missing; pipelines/setup installs it")


def chosen(people, arguments):
    labels = {"sub-" + label.removeprefix("sub-") for label in arguments.participant_label}
    for label in sorted(labels - people.keys()):
        raise UserError(f"--participant-label {label}: no such participant in {arguments.input}")
    sessions = {"ses-" + label.removeprefix("ses-") for label in arguments.session_label}
    return {subject: {s: f for s, f in found.items() if not sessions or s in sessions}
            for subject, found in people.items() if not labels or subject in labels}


def absolute(name):
    """A file of the user by its whole path; a preset stays as it is."""
    return str(pathlib.Path(name).resolve()) if pathlib.Path(name).exists() else name


def options_of(arguments):
    replay = ["--no-times"]
    replay += [] if arguments.film else ["--no-film"]
    replay += ["--no-sequence"] if arguments.no_sequence else []
    if arguments.labels_in_image != "none":
        replay += ["--labels-in-image", arguments.labels_in_image]
    segment = ["--config", absolute(arguments.segmentation)] if arguments.segmentation else []
    options = plans.Options(set=arguments.set, mesh=arguments.mesh, replay_options=replay,
                            reference=arguments.reference, segment_options=segment,
                            tolerances=absolute(arguments.tolerances))
    if arguments.scenario:
        options.scenarios = [absolute(s) for s in arguments.scenario]
    return options


def profile_of(arguments):
    if not arguments.profile:
        return "", []
    shipped = pathlib.Path(__file__).parent / "profiles" / arguments.profile
    # In one job of the cluster one program runs after the other: it asks for the largest, not the sum.
    options = ["--group-components", f"patient={arguments.patients_per_job}",
               "--resources", "slots=1", "--set-resource-scopes", "slots=local"]
    if arguments.jobs:
        options += ["--jobs", str(arguments.jobs)]
    return str(shipped if shipped.is_dir() else arguments.profile), options


def describe(output, source, plan):
    """dataset_description.json and participants.tsv of the derivatives."""
    version = subprocess.run([plans.find_program(plan.bin, "acus-replay"), "--version"], capture_output=True, text=True,
                             check=False).stdout.strip()
    write_json(output / "dataset_description.json", {
        "Name": "Acus derivatives", "BIDSVersion": "1.8.0", "DatasetType": "derivative",
        "GeneratedBy": [{"Name": "Acus", "Version": version, "Description": "pipelines/cohort"}]})
    write_whole(output / ".bidsignore", "work/\nro-crate-metadata.json\ngroup/\n")
    table = pathlib.Path(source) / "participants.tsv"
    if table.exists():
        header, rows = read_tsv(table)
    else:
        header, rows = ["participant_id"], [
            {"participant_id": s} for s in sorted({j["participant"] for j in plan.jobs.values()})]
    write_tsv(output / "participants.tsv", header, rows)


def prediction(plan, todo, cores, memory_mb):
    """What is to do, in words; {'cpu_s', 'wall_s'}."""
    jobs = [plan.jobs[name] for name in todo]
    cpu = sum(j["seconds"] for j in jobs)
    longest = max((j["seconds"] for j in jobs), default=0.0)
    fit = [min(cores, max(1, memory_mb // j["memory_mb"])) for j in jobs]
    wall = max(longest, sum(j["seconds"] / n for j, n in zip(jobs, fit)))
    lines = [f"{counted(len(jobs), 'job')} of {counted(len({j['participant'] for j in jobs}), 'participant')}; "
             f"done: {len(plan.jobs) - len(jobs)}."]
    for rule in plans.RULES:
        of_rule = [j for j in jobs if j["rule"] == rule]
        if of_rule:
            lines.append(f"  {rule:<10}{counted(len(of_rule), 'job'):>10}, CPU time "
                         f"{duration(sum(j['seconds'] for j in of_rule))}, up to {max(j['memory_mb'] for j in of_rule)} MB each")
    lines.append(f"CPU time {duration(cpu)}; about {duration(wall)} on {counted(cores, 'core')}")
    return "\n".join(lines), {"cpu_s": cpu, "wall_s": wall, "cores": cores}


def run_participants(arguments, output, plan, problems):
    memory_mb = int(arguments.memory_gb * 1000) or engine.free_memory_mb()
    todo = engine.to_do(output, plan)
    text, predicted = prediction(plan, todo, arguments.cores, memory_mb)
    if not arguments.quiet:
        print(text, file=sys.stderr)
    profile, options = profile_of(arguments)
    begin = time.time()
    code = engine.run(output, plan, todo, cores=arguments.cores, memory_mb=memory_mb, profile=profile,
                      quiet=arguments.quiet, retries=arguments.retries, options=options)
    if todo:
        write_json(output / "work/last_run.json", {
            **predicted, "jobs": len(todo), "start_s": begin, "took_s": time.time() - begin,
            "left": len(engine.to_do(output, plan))})
    return code


def summary(output, plan, failed, problems, arguments):
    people = {j["participant"] for j in plan.jobs.values()} | {p["participant"] for p in problems}
    bad = {f["participant"] for f in failed} | {p["participant"] for p in problems}
    for one in failed + problems:
        print(f"pipelines/cohort: {one['participant']} {one['session']}: {one['message']}", file=sys.stderr)
        if "command" in one:
            print(f"  repeat: pipelines/provenance {output} --job {one['job']}", file=sys.stderr)
    if bad:
        print(f"pipelines/cohort: {len(bad)} of {counted(len(people), 'participant')} failed", file=sys.stderr)
        return 4
    left = engine.to_do(output, plan)
    if left and arguments.level != "group":
        print(f"pipelines/cohort: not run: {counted(len(left), 'job')}; see {output}/work/snakemake.log",
              file=sys.stderr)
        return 4
    return 0


def exceeded(checks):
    bad = [c for c in checks if c["passed"] == "false"]
    for one in bad:
        print(f"pipelines/cohort: {budgets.text_of(one)}", file=sys.stderr)
    return 4 if bad else 0


def run(arguments):
    check(arguments)
    output = pathlib.Path(arguments.output).resolve()
    limits = budgets.read(arguments.budgets) if arguments.budgets else None
    people = chosen(read_sources(arguments.input), arguments)
    cache_path = output / "work/hashes.json"
    cache = read_json(cache_path) if cache_path.exists() else {}
    plan, problems = plans.make_plan(people, output, options_of(arguments), cache)
    if arguments.dry_run:
        memory_mb = int(arguments.memory_gb * 1000) or engine.free_memory_mb()
        print(prediction(plan, engine.to_do(output, plan), arguments.cores, memory_mb)[0])
        for problem in problems:
            print(f"{problem['participant']} {problem['session']}: {problem['message']}")
        return 0
    with_lock = engine.Lock(output)  # Held to the end of this process.
    write_json(cache_path, cache)
    describe(output, arguments.input, plan)
    if arguments.level != "group":
        run_participants(arguments, output, plan, problems)
    failed, kept = engine.failures(output, plan), []
    if arguments.level != "participant":
        kept = report.write(output, plan, failed, problems, limits)
        if arguments.labels_in_image != "none":
            labelled.write(output, report.runs_of(output, plan)[0], labelled.shares_of(arguments.splits),
                           arguments.split_seed)
        crate.write(output, plan, failed)
        if not arguments.quiet:
            print(f"Report: {output}/group/report.html", file=sys.stderr)
    code = max(summary(output, plan, failed, problems, arguments), exceeded(kept))
    del with_lock
    return code


def main(words):
    return user.call("pipelines/cohort", run, parser().parse_intermixed_args(words))
