#!/usr/bin/env python3
"""The jobs of pipelines/demo: one patient, without participants and sessions, in one folder.

Usage: demo.py OUTPUT CT SERIES SCENARIO TISSUE SEED ATLAS TARGET WINDOW LABELS MAPPING; CT, SERIES, TISSUE and all
after SEED may be empty.
"""
import os
import pathlib
import sys
import time

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "common"))

import engine  # noqa: E402
import plan as plans  # noqa: E402
import user  # noqa: E402
from files import UserError, read_json, write_json  # noqa: E402


def make_plan(output, ct, series, scenario, tissue, seed, atlas, scene_options, labels, mapping, cache):
    options = plans.Options(scenarios=[scenario], tissue=tissue, mesh=True, folders=True, quiet=False,
                            replay_options=[], threads=os.cpu_count(), scene_options=scene_options,
                            scene_titles=True)
    plan = plans.Plan(output, options, cache)
    source = {"path": ct, "seed": seed, "series": series}
    files = {"ct": [source]} if ct else {"phantom": [{**source, "path": "lumbar"}]}
    if atlas:
        files["atlas"] = [{"path": atlas, "seed": None, "series": ""}]
    if labels:
        files["labels"] = [{"path": labels, "seed": None, "series": ""}]
    if mapping:
        files["label_mapping"] = [{"path": mapping, "seed": None, "series": ""}]
    plans.Patient(plan, "", "", files).jobs()
    return plan


def run(output, *arguments):
    cache_path = output / "work/hashes.json"
    cache = read_json(cache_path) if cache_path.exists() else {}
    lock = engine.Lock(output)
    plan = make_plan(output, *arguments, cache)
    write_json(cache_path, cache)
    begin = time.monotonic()
    engine.run(output, plan, engine.to_do(output, plan), cores=os.cpu_count(), titles=True, quiet=True,
               memory_mb=engine.free_memory_mb())
    failed = engine.failures(output, plan)
    for failure in failed:
        print(f"{failure['message']}\npipelines/demo: {failure['command'].split()[0]} ended with exit code "
              f"{failure['exit_code']}; see its message above", file=sys.stderr)
    if failed:
        return failed[0]["exit_code"]
    if engine.to_do(output, plan):
        raise UserError(f"not all jobs were run; see {output}/work/snakemake.log")
    refused = output / "mesh/refused.txt"
    mesh = f"none: {refused.read_text().strip()}" if refused.exists() else output / "mesh/mesh.vtu"
    page = output / "segmentation/report.html"
    tissues = page if page.exists() else output / "segmentation/preview_axial.png"
    print(f"""
The programs took {time.monotonic() - begin:.0f} s. Look at:
  report      {output}/run/report.html
  film        {output}/run/film.mp4
  force plot  {output}/run/forces.svg
and, of the steps before:
  tissues     {tissues}
  mesh        {mesh}""")
    del lock
    return 0


def main(words):
    folder, *words, seed_text, atlas_folder, target, window, labels, mapping = words
    # As one word each: a point may begin with a minus.
    scene_options = [f"--{name}={value}" for name, value in (("target", target), ("window", window)) if value]
    return run(pathlib.Path(folder), *words, int(seed_text), atlas_folder, scene_options, labels, mapping)


if __name__ == "__main__":
    sys.exit(user.call("pipelines/demo", main, sys.argv[1:]))
