"""The files of a new workplace for pipelines/live-session, from presets: a scenario with its patient, an exercise and
devices. A workplace that would not start is not left behind. Writes to standard output what the user should read."""
import argparse
import csv
import json
import math
import os
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "common"))

import user  # noqa: E402
from add_case import cross, frame_of  # noqa: E402
from files import UserError, read_json_object, write_whole  # noqa: E402

CONFIGS = pathlib.Path(__file__).resolve().parents[2] / "configs"
POSE = ["x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz"]
HAND_TO_SKIN_MM = 30.0
PROBE_BESIDE_NEEDLE_MM = 25.0
LEAST_IMAGES_PER_S = 25.0
TRIED_S = 3

# Of a paper or a procedure: kind of the synthetic patient, exercise, and what differs from the other workplaces.
SYSTEMS = {
    "": {"scenario": "lumbar_puncture", "kind": "lumbar", "exercise": "lumbar_puncture"},
    "epidural": {"kind": "lumbar", "exercise": "epidural"},
    "epidural_obese": {"scenario": "epidural", "kind": "lumbar", "exercise": "epidural", "needle": "tuohy_18g_long",
                       "phantom": ["--config", str(CONFIGS / "phantoms/lumbar_obese.json")]},
    "epidural_narrow": {"scenario": "epidural", "kind": "lumbar", "exercise": "epidural",
                        "phantom": ["--config", str(CONFIGS / "phantoms/lumbar_narrow.json")]},
    "spinal": {"kind": "lumbar", "exercise": "spinal"},
    "bursa_injection": {"kind": "bursa_injection", "exercise": "bursa_injection"},
    "nephrostomy": {"kind": "nephrostomy", "exercise": "nephrostomy"},
    "liver_cyst": {"kind": "liver_cyst", "exercise": "liver_cyst"},
    # Face down in the mannequin that the stand-in camera sees.
    "augmented_2010": {"kind": "lumbar", "exercise": "spinal_needle_2010", "camera": True,
                       "phantom": ["--config", str(CONFIGS / "phantoms/lumbar_prone.json")]},
    "vidal_2008": {"kind": "kidney", "exercise": "kidney_puncture"},
    "alamilla_2021": {"kind": "shoulder", "exercise": "shoulder_puncture"},
    # X-ray and film of a patient who breathes take more than a second for each image: the workplace leaves them to
    # replays, so that ultrasound and CT come at their rate. The window renders its volume view beside the session.
    "fortmeier_2016": {"kind": "liver_ptc", "exercise": "bile_duct_drainage", "breathes": True,
                       "without": ["fluoroscopy", "view_3d"], "views": "ultrasound,3d,volume,ct"},
}
PROCEDURES = ["epidural", "epidural_obese", "epidural_narrow", "spinal", "bursa_injection", "nephrostomy", "liver_cyst"]
SYSTEMS_OF_PAPERS = [name for name in SYSTEMS if name not in ("", *PROCEDURES)]


def program(name, *arguments, cwd=None):
    """Runs a program of Acus; its message where it fails."""
    command = [name, *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=cwd)
    if done.returncode != 0:
        raise UserError(done.stderr.strip() or f"{name} was ended by a signal")
    return done


def write_document(file, document):
    write_whole(file, json.dumps(document, indent=2, ensure_ascii=False) + "\n")


def hand(name, pose):
    """A virtual hand whose origin is at a pose: x y z in mm and a quaternion w x y z."""
    return {"name": name, "driver": "virtual_hand",
            "reference_from_device": {"translation_mm": pose[:3], "quaternion_wxyz": pose[3:]}}


def recorded_pose(file):
    """The first pose of a recorded tool."""
    with open(file, encoding="utf-8", newline="") as stream:
        try:
            row = next(csv.DictReader(stream))
            return [float(row[column]) for column in POSE]
        except (StopIteration, KeyError, TypeError, ValueError) as error:
            raise UserError(f"{file}: has no pose in its second line; it must have {','.join(POSE)}") from error


def quaternion_of(x, y, z):
    """w x y z of the rotation with these columns."""
    columns = [x, y, z]
    trace = x[0] + y[1] + z[2]
    squared = [(1.0 + trace) / 4.0] + [(1.0 + 2.0 * columns[i][i] - trace) / 4.0 for i in range(3)]
    largest = max(range(4), key=squared.__getitem__)
    apart = [y[2] - z[1], z[0] - x[2], x[1] - y[0]]
    if largest == 0:
        raw = [4.0 * squared[0], *apart]
    else:
        i = largest - 1
        raw = [apart[i]] + [columns[k][i] + columns[i][k] if k != i else 4.0 * squared[largest] for k in range(3)]
    length = math.hypot(*raw)
    return [value / length for value in raw]


def poses_at(point, direction):
    """Of needle and probe: the needle is before the point and looks along the direction; the probe is beside it and
    its image plane holds the needle."""
    frame = frame_of(point, [a + 100.0 * b for a, b in zip(point, direction)])
    x, y, z = ([row[column] for row in frame[:3]] for column in range(3))
    at = [p - HAND_TO_SKIN_MM * d for p, d in zip(point, z)]
    beside = [a + PROBE_BESIDE_NEEDLE_MM * b for a, b in zip(at, x)]
    return at + quaternion_of(x, y, z), beside + quaternion_of(x, z, cross(x, z))


def virtual_hands(poses):
    return {"format": "acus-devices/1", "name": "virtual hands",
            "devices": [hand(name, pose) for name, pose in zip(("right", "left"), poses)],
            "needle": {"device": "right"}, "probe": {"device": "left"}}


def poses_of_session(session):
    return [recorded_pose(session / f"{tool}.csv") for tool in ("needle", "probe")]


def scenario_of(preset, patient, without=()):
    """The preset with a patient in place."""
    scenario = read_json_object(CONFIGS / "scenarios" / f"{preset}.json")
    if scenario.get("patient"):
        raise UserError(f"The preset scenarios/{preset}.json has a patient of its own; choose another --model.")
    effects = {key: value for key, value in scenario["effects"].items() if key not in without}
    return {**scenario, "patient": patient, "effects": effects}


def write_exercise(folder, name):
    exercise = read_json_object(CONFIGS / "exercises" / f"{name}.json")
    write_document(folder / "exercises" / f"{name}.json", {**exercise, "scenario": "../scenario.json"})


def add_camera(folder, devices, session):
    """The camera of the 2010 paper: where none is attached, acus-devices draws what it would see. The file stand_ins
    holds its arguments; without that file a real camera takes its place."""
    port = random.randint(18950, 19949)
    devices["camera"] = {
        "place": f"igtl:localhost:{port}/Video", "model": "cameras/micron_tracker_2010.json",
        "facets": "facets/training.json",
        "second": {"place": f"igtl:localhost:{port}/VideoRight", "stereo": "cameras/micron_pair_2010.json",
                   "apart_ms": 16}}
    write_whole(folder / "stand_ins",
                f"play {session.relative_to(folder)} --camera cameras/micron_tracker_2010.json facets/training.json "
                f"--stereo cameras/micron_pair_2010.json --port {port} --quiet\n")


def register(markers, folder):
    target = markers / "target_ct.csv"
    program("acus-register", "--quiet", "--from", markers / "markers_mannequin.csv", "--to", markers / "markers_ct.csv",
            *(["--target", target] if target.is_file() else []), "-o", folder / "registration")


def check(folder, devices):
    """A workplace that would not start is none."""
    program("acus-live", folder / "scenario.json", "--devices", devices, "--check")


def make_patient(folder, system):
    """The synthetic patient of a system, registered."""
    print(f"Making a workplace with a synthetic patient in {folder} ...", file=sys.stderr)
    program("acus-phantom", "patient", system["kind"], *system.get("phantom", []), "--quiet", "-o", folder / "patient")
    register(folder / "patient", folder)
    if system.get("breathes"):
        print("Finding how the patient breathes ...", file=sys.stderr)
        program("acus-breathing", "--single", folder / "patient/ct.nrrd", "--labels",
                folder / "patient/labels.seg.nrrd", "--model", "surrogate", "--resolution", 64, "--quiet",
                "-o", folder / "motion")


def write_system(folder, paper):
    """The default workplace, or that of a paper, around a patient who is there."""
    system = SYSTEMS[paper]
    patient = {"ct": "patient/ct.nrrd", "labels": "patient/labels.seg.nrrd", "corridor": "patient/corridor_ct.csv",
               "ct_from_reference_file": "registration/ct_from_reference.tfm"}
    scenario = scenario_of(system.get("scenario", paper), patient, system.get("without", ()))
    if "needle" in system:
        scenario["needle"] = f"needles/{system['needle']}.json"
    write_document(folder / "scenario.json", scenario)
    if "views" in system:
        write_whole(folder / "views", system["views"] + "\n")
    write_exercise(folder, system["exercise"])
    session = min((folder / "patient/sessions").iterdir())
    devices = virtual_hands(poses_of_session(session))
    if system.get("camera"):
        add_camera(folder, devices, session)
    write_document(folder / "devices.json", devices)
    check(folder, folder / "devices.json")


def make_own(folder, given):
    """The workplace of a patient of the user's own."""
    patient = {"ct": given.ct, "labels": given.labels, "corridor": "target_ct.csv"}
    if (folder / "registration").is_dir():
        patient["ct_from_reference_file"] = "registration/ct_from_reference.tfm"
    else:  # Virtual hands are in the CT's frame.
        patient["ct_from_reference"] = [float(i % 5 == 0) for i in range(16)]
    write_document(folder / "scenario.json", scenario_of(given.model, patient))
    write_exercise(folder, given.exercise)
    poses = (poses_of_session(pathlib.Path(given.session)) if given.session else
             poses_at(given.point, given.direction))
    tried = devices = folder / "devices.json"
    if given.devices != "virtual":
        shutil.copy(CONFIGS / "devices" / f"{given.devices}.json", devices)
        tried = folder / "virtual_hands.json"
    write_document(tried, virtual_hands(poses))
    check(folder, tried)
    check_speed(folder, tried, given.model)


def check_speed(folder, devices, model):
    """How fast this machine is with the new workplace: some seconds with virtual hands."""
    print(f"Trying the workplace for {TRIED_S} s ...", file=sys.stderr)
    with tempfile.TemporaryDirectory() as tried:
        session = pathlib.Path(tried) / "session"
        program("acus-live", folder / "scenario.json", "--devices", devices, "--headless", "--duration", TRIED_S,
                "--quiet", "-o", session)
        summary = read_json_object(session / "summary.json")
    rate, late = summary["images"]["per_s"], summary["steps"]["missed_by_computation"]
    steps = summary["recording"]["steps_on_disk"]
    print(f"This machine: {rate:.1f} images a second of 30, {late} of {steps} steps late.", file=sys.stderr)
    if rate < LEAST_IMAGES_PER_S or late > steps / 100:
        print(f"The model {model} is too slow for this machine. Make the workplace with another --model, such as "
              "lumbar_puncture or liver_biopsy; acus-tradeoff finds settings for a machine.")


def numbers(text):
    return [float(word) for word in text.split()]


def arguments_of(words):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=pathlib.Path)
    for name in ("paper", "procedure"):
        parser.add_argument(f"--{name}", default="")
    for name in ("model", "exercise", "devices", "ct", "labels", "session"):
        parser.add_argument(f"--{name}")
    for name in ("point", "direction"):
        parser.add_argument(f"--{name}", type=numbers)
    return parser.parse_args(words)


def run(words):
    given = arguments_of(words)
    for option, allowed in (("paper", SYSTEMS_OF_PAPERS), ("procedure", PROCEDURES)):
        name = getattr(given, option)
        if name and name not in allowed:
            print(f"pipelines/live-session: --{option} must be one of {', '.join(allowed)}; got '{name}'",
                  file=sys.stderr)
            return 2
    system = given.paper or given.procedure
    folder = given.folder.resolve()
    try:
        for name in ("exercises", "sessions"):
            os.makedirs(folder / name, exist_ok=True)
        if given.model:
            make_own(folder, given)
        else:
            make_patient(folder, SYSTEMS[system])
            write_system(folder, system)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)  # Whole or not at all.
        raise
    print(f"Start it with: pipelines/live-session {given.folder}", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(user.call("pipelines/live-session", run, sys.argv[1:]))
