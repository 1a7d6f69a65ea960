"""Another patient in a workplace: a case with an exercise and a scenario of its own.

The patient is placed so that entry and direction of the planned path are those of the workplace's patient: hands,
mannequin and devices stay where they are."""
import json
import math
import os
import pathlib
import subprocess
import sys

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "common"))

import user  # noqa: E402
from files import UserError, read_csv, read_json_object, write_whole  # noqa: E402
from sessions import CODE  # noqa: E402

POINTS = ["name", "x_mm", "y_mm", "z_mm"]


def points_of(file):
    """Entry and target in CT space, mm."""
    if not file.is_file():
        raise UserError(f"{file}: no such file; a case needs the points entry and target of its patient")
    found = {row["name"]: row for row in read_csv(file, POINTS)}
    points = []
    for name in ("entry", "target"):
        try:
            points.append([float(found[name][column]) for column in POINTS[1:]])
        except (KeyError, ValueError) as error:
            raise UserError(f"{file}: has no point named {name} with three numbers") from error
    return points


def unit(vector):
    length = math.hypot(*vector)
    return [value / length for value in vector]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def frame_of(entry, target):
    """4 x 4: origin at the entry, z along the path, x across it towards the head (or to the left, where the path
    runs along the body)."""
    along = [b - a for a, b in zip(entry, target)]
    if math.hypot(*along) < 1.0:
        raise UserError("entry and target are less than 1 mm apart")
    z = unit(along)
    head = [0.0, 0.0, 1.0] if abs(z[2]) < 0.95 else [1.0, 0.0, 0.0]
    share = sum(a * b for a, b in zip(head, z))
    x = unit([a - share * b for a, b in zip(head, z)])
    y = cross(z, x)
    return [[x[i], y[i], z[i], entry[i]] for i in range(3)] + [[0.0, 0.0, 0.0, 1.0]]


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


def rigid_inverse(a):
    turned = [[a[j][i] for j in range(3)] for i in range(3)]
    return [row + [-sum(row[k] * a[k][3] for k in range(3))] for row in turned] + [[0.0, 0.0, 0.0, 1.0]]


def transform_of(patient, folder):
    """ct_from_reference of a scenario's patient, 4 x 4."""
    if "ct_from_reference" in patient:
        numbers = patient["ct_from_reference"]
        return [numbers[4 * row:4 * row + 4] for row in range(4)]
    if "ct_from_reference_file" not in patient:
        return [[float(i == j) for j in range(4)] for i in range(4)]
    return read_transform(folder / patient["ct_from_reference_file"])


def read_transform(file):
    """An ITK text file with one affine or rigid matrix transform, as acus-register writes it."""
    try:
        lines = dict(line.split(":", 1) for line in file.read_text(encoding="utf-8").splitlines() if ":" in line)
        values = [float(word) for word in lines["Parameters"].split()]
        centre = [float(word) for word in lines.get("FixedParameters", "0 0 0").split()]
        if len(values) != 12 or len(centre) != 3:
            raise ValueError("it must have 12 parameters and a centre")
    except (OSError, KeyError, ValueError) as error:
        raise UserError(f"{file}: is no transform of acus-register: {error}") from error
    rows = [values[3 * i:3 * i + 3] for i in range(3)]
    return [row + [values[9 + i] + centre[i] - sum(a * b for a, b in zip(row, centre))]
            for i, row in enumerate(rows)] + [[0.0, 0.0, 0.0, 1.0]]


def scenario_of_case(scenario, folder, patient):
    """The workplace's scenario with the patient of a folder in place of its own."""
    if "breathing" in scenario.get("effects", {}):
        raise UserError("the scenario of the workplace has the breath of its own patient (effects/breathing); "
                        "make a workplace of its own for each patient who breathes")
    own = scenario.get("patient", {})
    if "corridor" not in own:
        raise UserError(f"{folder}/scenario.json: /patient/corridor is missing: entry and target of the patient")
    placed = product(product(frame_of(*points_of(patient / "corridor_ct.csv")),
                             rigid_inverse(frame_of(*points_of(folder / own["corridor"])))),
                     transform_of(own, folder))
    files = {"ct": patient / "ct.nrrd", "labels": patient / "labels.seg.nrrd", "corridor": patient / "corridor_ct.csv"}
    for file in files.values():
        if not file.is_file():
            raise UserError(f"{file}: no such file; a prepared patient is a folder with it")
    case = {**{key: str(file) for key, file in files.items()}, "ct_from_reference": [x for row in placed for x in row]}
    return {**scenario, "patient": case}


def add(workplace, name, patient, exercise):
    """exercise: the file that the case's exercise is made from. @returns the new exercise's file."""
    if not CODE.fullmatch(name):
        raise UserError(f"The name of a case may only hold letters from a to z and A to Z, digits, '-' and '_'; got '{name}'.")
    made = [workplace / f"case_{name}.json", workplace / "exercises" / f"{name}.json"]
    for file in made:
        if file.exists():
            raise UserError(f"{file}: is there already; choose another name")
    scenario = scenario_of_case(read_json_object(workplace / "scenario.json"), workplace, patient.resolve())
    task = read_json_object(exercise)
    task = {**task, "name": f"{task.get('name', exercise.stem)}, {name}", "scenario": f"../{made[0].name}"}
    for file, content in zip(made, (scenario, task)):
        write_whole(file, json.dumps(content, indent=2, ensure_ascii=False) + "\n")
    return made


def check(workplace, made):
    """What the programs say of the case; without their consent it does not stay."""
    done = subprocess.run(["acus-live", made[0], "--devices", workplace / "devices.json", "--check"],
                          capture_output=True, text=True, check=False)
    if done.returncode != 0:
        for file in made:
            file.unlink()
        raise UserError(done.stderr.strip() or "acus-live --check was ended by a signal")


def run(arguments):
    workplace, name, patient, exercise = arguments
    folder = pathlib.Path(workplace).resolve()
    made = add(folder, name, pathlib.Path(patient), pathlib.Path(exercise))
    check(folder, made)
    print(f"Added {os.path.relpath(made[1], folder)}; start it with: "
          f"pipelines/live-session --exercise {name} {workplace}", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(user.call("pipelines/live-session", run, sys.argv[1:]))
