"""From the sources of a cohort to its jobs: which program, on what, after which others."""
import json
import os
import pathlib
import re

import resources
from files import UserError, read_json, sha256_of, sha256_of_text

ROOT = pathlib.Path(__file__).resolve().parents[2]
PARALLEL = ("phantom", "breathing", "replay")  # Programs that gain from threads.
RULES = ("phantom", "segment", "scene", "mesh", "fit", "register", "breathing", "replay", "compare")
SUFFIX = re.compile(r"(\.seg\.nrrd|\.nii\.gz|\.igs\.mha|\.igs\.nrrd|\.[A-Za-z0-9]{1,6})$")


class Options:
    """What holds for all patients of a cohort."""

    def __init__(self, **values):
        self.scenarios = ["scenarios/lumbar_puncture.json"]
        self.replay_options = ["--no-times", "--no-film"]
        self.set = []
        self.tissue = ""
        self.mesh = False
        self.folders = False       # Whether outputs may name folders.
        self.threads = 1
        self.reference = ""        # An earlier output folder to compare with.
        self.tolerances = "tolerances/default.json"
        self.segment_options = []
        self.scene_options = []    # Target and window of the sessions that are made.
        self.quiet = True
        self.scene_titles = False  # Whether reports are named by the scenes that are made.
        for name, value in values.items():
            assert hasattr(self, name), name
            setattr(self, name, value)


def find_program(folder, name):
    path = pathlib.Path(folder) / name
    if not path.exists():
        raise UserError(f"{path}: the program is missing; pipelines/build --programs builds it")
    return path


def program_folder():
    in_sources = (ROOT / "CMakeLists.txt").exists()
    beside = ROOT / "build/bin" if in_sources else ROOT.parent.parent / "bin"
    return pathlib.Path(os.environ.get("ACUS_BIN", beside)).resolve()


def patient_of(job):
    """The name of the plan that a job is in: no job has a parent in another."""
    return "_".join(word for word in (job["participant"], job["session"]) if word) or "patient"


class Plan:
    """Jobs by id, each with all that it depends on in its key."""

    def __init__(self, output, options, cache=None):
        self.output = pathlib.Path(output).resolve()
        self.options = options
        self.jobs = {}
        self.bin = program_folder()
        self.models = resources.models_for(self.output)
        self.cache = cache if cache is not None else {}
        self.program_hashes = {}
        # Presets: any program may read any of them.
        configs = pathlib.Path(os.environ.get("ACUS_CONFIGS", ROOT / "configs"))
        self.presets = sha256_of(configs) if configs.is_dir() else ""

    def to_json(self, jobs=None):
        return {"output": str(self.output), "bin": str(self.bin), "jobs": self.jobs if jobs is None else jobs,
                "environment": {"OPENBLAS_NUM_THREADS": "1"}}

    def by_patient(self, names):
        """Plans of single patients, those with one of the jobs: what one job has to read does not grow with
        the cohort."""
        wanted = {patient_of(self.jobs[name]) for name in names}
        parts = {}
        for name, job in self.jobs.items():
            if patient_of(job) in wanted:
                parts.setdefault(patient_of(job), {})[name] = job
        return {patient: self.to_json(jobs) for patient, jobs in parts.items()}

    def source_hash(self, path):
        """By size and time of change from the last plan, or of the content."""
        path = pathlib.Path(path)
        if not path.exists():
            return "missing"
        files = sorted(p for p in path.rglob("*") if p.is_file()) if path.is_dir() else [path]
        seen = sha256_of_text("".join(f"{p} {p.stat().st_size} {p.stat().st_mtime_ns}\n"
                                      for p in files))
        if self.cache.get(str(path), [""])[0] != seen:
            self.cache[str(path)] = [seen, sha256_of(path)]
        return self.cache[str(path)][1]

    def add(self, rule, name, program, arguments, *, title, parents=(), links=None, features=None,
            allow=(), where=("", "")):
        """A job that makes the folder `name`, below the output."""
        if program not in self.program_hashes:
            self.program_hashes[program] = self.source_hash(find_program(self.bin, program))
        threads = self.options.threads if rule in PARALLEL else 1
        argv = [program, *arguments, "-o", name, "--threads", str(threads), "--overwrite"]
        if not self.options.folders:
            argv.append("--no-folders")
        if self.options.quiet:
            argv.append("--quiet")
        job = name.replace("/", "_")
        links = links or {}
        features = features or [1.0, 0.0, 0.0]
        key = sha256_of_text("\n".join([
            *argv, self.program_hashes[program], self.presets,
            *[self.jobs[p]["key"] for p in parents], *[self.source_hash(t) for t in links.values()]]))
        seconds, memory = resources.predict(self.models, rule, features)
        self.jobs[job] = {"id": job, "rule": rule, "output": name, "argv": argv, "title": title,
                          "parents": list(parents), "links": links, "features": features,
                          "allow": list(allow), "key": key[:16], "seconds": round(seconds, 3),
                          "memory_mb": memory, "threads": threads, "participant": where[0], "session": where[1],
                          "program_sha256": self.program_hashes[program]}
        return job


def session_of_phantom(kind, config):
    """(name of the session, millions of voxels, whether it has force curves) by a phantom's config."""
    document = read_json(config or ROOT / f"configs/phantoms/{kind}.json")
    voxels = 1.0
    for size in document.get("grid", {}).get("size", [0]):
        voxels *= size
    return document.get("session", {}).get("name", "insertion"), voxels / 1e6, bool(document.get("force_curves"))


def breathes(scenario):
    """Whether a scenario, a file or preset, has the effect breathing: it takes the motion of the phases."""
    path = pathlib.Path(scenario)
    if not path.exists():
        path = pathlib.Path(os.environ.get("ACUS_CONFIGS", ROOT / "configs")) / scenario
    effects = read_json(path).get("effects", {}) if path.exists() else {}
    return effects.get("breathing") is not None


class Patient:
    """The jobs of one session of one participant."""

    def __init__(self, plan, subject, session, files):
        self.plan, self.files = plan, files
        self.where = (subject, session)
        self.base = f"{subject}/{session}" if subject else ""
        self.links = {}
        self.voxels = 0.0
        self.from_phantom = ""

    def path(self, name):
        return f"{self.base}/{name}" if self.base else name

    def link(self, kind, entry, number=None):
        """The name, without folders, under which jobs read a source."""
        target = entry["path"]
        suffix = SUFFIX.search(os.path.basename(target)) if not os.path.isdir(target) else None
        name = f"work/in/{self.path(kind)}{'' if number is None else f'_{number:02}'}"
        name += suffix[1] if suffix else ""
        self.links[name] = target
        return name

    def add(self, rule, name, program, arguments, **more):
        used = {n: t for n, t in self.links.items()
                if any(n == w or w.endswith("=" + n) for w in arguments)}
        more.setdefault("features", [1.0, self.voxels, 0.0])
        return self.plan.add(rule, self.path(name), program, arguments, links=used, where=self.where,
                             **more)

    def jobs(self):
        files, options = self.files, self.plan.options
        one = {kind: self.link(kind, files[kind][0]) for kind in
               ("ct", "labels", "label_mapping", "atlas", "phases", "markers_ct", "markers_mannequin", "target",
                "corridor")
               if kind in files}
        many = {kind: [self.link(kind, entry, i + 1) for i, entry in enumerate(files.get(kind, []))]
                for kind in ("force_curves", "recording")}
        self.has_scene = False
        names = [re.sub(r"[^A-Za-z0-9]+", "", pathlib.Path(e["path"]).name.split(".")[0])
                 for e in files.get("recording", [])]
        truth = []  # The job that makes what is not given.
        if "phantom" in files:
            truth = [self.phantom(files["phantom"][0], one, many, names)]
        elif "ct" in one:
            self.voxels = resources.megavoxels(files["ct"][0]["path"])
        else:
            raise UserError(f"{'/'.join(self.where)}: neither a ct nor a phantom")
        segment = self.segment(one, truth)
        if not truth and not ("markers_ct" in one and many["recording"]):
            truth = [self.scene(one, many, names)]
            self.has_scene = True
        if options.mesh:
            self.mesh(one, [segment, *truth])
        if many["force_curves"]:
            self.add("fit", "fit", "acus-fit", many["force_curves"], parents=truth,
                     title="Recorded force curves to force parameters")
        motion = []
        if "phases" in one:
            motion = [self.add("breathing", "motion", "acus-breathing", [one["phases"]],
                               title="A 4D CT to a model of how the patient breathes")]
        register = self.register(one, truth)
        self.replays(one, many["recording"], names, [segment, *truth, register], motion)

    def phantom(self, entry, one, many, names):
        kind, _, config = entry["path"].partition(":")
        if kind not in ("lumbar", "liver"):
            raise UserError(f"{'/'.join(self.where)}: phantom '{kind}'; allowed: lumbar, liver, or "
                            "one of them with a config, as lumbar:FILE")
        name, self.voxels, has_curves = session_of_phantom(kind, config)
        arguments = ["patient", kind, "--seed", str(entry["seed"] or 0)]
        if config:
            arguments += ["--config", self.link("phantom", {"path": config})]
        job = self.add("phantom", "patient", "acus-phantom", arguments,
                       title="A synthetic patient, with exact truth")
        folder = self.path("patient")
        one.setdefault("ct", f"{folder}/ct.nrrd")
        self.made(folder, name, one, many, names)
        if has_curves and not many["force_curves"]:
            many["force_curves"] = [f"{folder}/force_curves/*.csv"]
        return job

    @staticmethod
    def made(folder, session, one, many, names):
        """Files of a phantom or a scene, where none were given."""
        for kind in ("markers_ct", "markers_mannequin", "target_ct", "corridor_ct"):
            one.setdefault(kind.removesuffix("_ct") if kind != "markers_ct" else kind,
                           f"{folder}/{kind}.csv")
        if not many["recording"]:
            many["recording"], names[:] = [f"{folder}/sessions/{session}"], [session.replace("_", "")]

    def series(self):
        return self.files.get("ct", [{"series": ""}])[0]["series"]

    def segment(self, one, truth):
        arguments = [one["ct"], *self.plan.options.segment_options]
        if self.series():
            arguments += ["--series", self.series()]
        if "labels" in one:
            arguments += ["--import", one["labels"]]
            arguments += ["--mapping", one["label_mapping"]] if "label_mapping" in one else []
        elif "label_mapping" in one:
            raise UserError(f"{'/'.join(self.where)}: a label_mapping, but no labels")
        if "atlas" in one:
            arguments += ["--atlas", one["atlas"]]
        return self.add("segment", "segmentation", "acus-segment", arguments, parents=truth,
                        title="CT to tissues, surfaces and volumes")

    def scene(self, one, many, names):
        seed = self.files["ct"][0]["seed"] or 0
        segment = self.path("segmentation").replace("/", "_")
        job = self.add("scene", "scene", "acus-phantom",
                       ["scene", self.path("segmentation/labels.seg.nrrd"), "--seed", str(seed),
                        *self.plan.options.scene_options],
                       parents=[segment],
                       title="Markers, a target and a recorded session on this patient")
        name = session_of_phantom("scene", "")[0]
        self.made(self.path("scene"), name, one, many, names)
        return job

    def mesh(self, one, parents):
        arguments = [self.path("segmentation/labels.seg.nrrd")]
        solid = self.plan.options.tissue == "fe_3d"
        if solid:
            arguments += [f"--corridor-from=@point:{one['corridor']}:entry",
                          f"--corridor-to=@point:{one['corridor']}:target", "--condense"]
        # Only finite elements need the mesh: a body that cannot be meshed well is replayed without.
        self.add("mesh", "mesh", "acus-mesh", arguments, parents=parents if solid else parents[:1],
                 title="Tissues to a tetrahedral mesh", allow=[] if solid else [4])

    def register(self, one, truth):
        missing = [k for k in ("markers_ct", "markers_mannequin") if k not in one]
        if missing:
            raise UserError(f"{'/'.join(self.where)}: {missing[0]} is missing")
        target = ["--target", one["target"]] if "target" in one else []
        return self.add("register", "registration", "acus-register",
                        ["--from", one["markers_mannequin"], "--to", one["markers_ct"], *target],
                        parents=truth, title="Mannequin markers to the CT")

    def replays(self, one, recordings, names, parents, motion):
        options = self.plan.options
        scenarios = [(e["path"], self.link("scenario", e, i + 1))
                     for i, e in enumerate(self.files.get("scenario", []))]
        scenarios = scenarios or [(s, s) for s in options.scenarios]
        many = len(scenarios) * len(recordings) > 1
        for path, scenario in scenarios:
            if os.path.isabs(scenario) and options.folders:  # It may name files beside it.
                self.links[scenario] = scenario
            elif os.path.isabs(scenario):
                self.links[f"work/in/scenarios/{pathlib.Path(path).name}"] = path
                scenario = f"work/in/scenarios/{pathlib.Path(path).name}"
            stem = re.sub(r"[^A-Za-z0-9]+", "", pathlib.Path(path).stem)
            moves = motion if breathes(path) else []
            for name, recording in zip(names, recordings):
                run = f"replays/{stem}-{name}" if self.base or many else "run"
                self.replay(run, scenario, recording, one, parents, moves)

    def replay(self, run, scenario, recording, one, parents, motion):
        options = self.plan.options
        deformable = ["--set", f"/effects/breathing/motion={self.path('motion')}"] if motion else []
        parents = [*parents, *motion]
        if options.tissue:
            deformable += ["--set", f"/effects/tissue/model={options.tissue}",
                           "--set", f"/patient/corridor={one['corridor']}"]
            if options.tissue != "displacement_functions":
                deformable += ["--set", "/effects/needle_force/model=tissue"]
            if options.tissue == "fe_3d":
                deformable += ["--set", f"/patient/mesh={self.path('mesh')}"]
                parents = [*parents, self.path("mesh").replace("/", "_")]
        for change in options.set:
            deformable += ["--set", change]
        # Quoted: a part of a UID may look like a number.
        series = ["--set", f"/patient/series={json.dumps(self.series())}"] if self.series() else []
        if self.has_scene and options.scene_titles:
            deformable += ["--set", f"/name=@title:{self.path('scene')}/truth.json"]
        labels = self.path("segmentation/labels.seg.nrrd")
        transform = self.path("registration/ct_from_reference.tfm")
        recorded = resources.megabytes(self.links[recording]) if recording in self.links else 0.0
        job = self.add("replay", run, "acus-replay",
                       [scenario, recording, "--ct", one["ct"], *series, "--labels", labels,
                        "--transform", transform, *deformable, *options.replay_options],
                       parents=parents, features=[1.0, self.voxels, recorded],
                       title="The recorded insertion, replayed")
        if options.reference:
            self.links["work/in/reference/" + self.path(run)] = str(
                pathlib.Path(options.reference).resolve() / self.path(run))
            self.add("compare", run.replace("replays", "comparisons"), "acus-compare",
                     ["work/in/reference/" + self.path(run), self.path(run), "--tolerances",
                      options.tolerances], parents=[job], allow=[4],
                     title="The replay held against that of the reference")


def make_plan(people, output, options, cache=None):
    """The jobs of all patients; what is wrong with one patient is in `problems`, and does not stop
    the others."""
    plan = Plan(output, options, cache)
    problems = []
    for subject, sessions in people.items():
        for session, files in sessions.items():
            before = dict(plan.jobs)
            try:
                Patient(plan, subject, session, files).jobs()
            except UserError as error:
                plan.jobs = before
                problems.append({"participant": subject, "session": session, "message": str(error)})
    return plan, problems
