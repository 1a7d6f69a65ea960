"""Whether a played session does all of its exercise, as a person would look at it. Usage: check_play.py RUN_FOLDER [EXPECTED_WARNING]

Every step of the checklist is done, every goal is met, the target, if there is one, is reached in one attempt, and nothing warns; the
report begins with the outcome, whose number is that of its goal; its images (of --labels-in-image png) are not black, show the target,
and the needle is bright in them. A warning that begins with EXPECTED_WARNING is as it should be."""
import csv
import html
import json
import pathlib
import re
import sys

from PIL import Image, ImageChops, ImageFilter, ImageStat

NEEDLE, BEYOND = 251, 255


def read_json(file):
    return json.loads(file.read_text(encoding="utf-8"))


def faults_of_training(training):
    metrics = {metric["name"]: metric["value"] for metric in training["metrics"]}
    for step in training["checklist"]:
        if step["state"] != "done":
            yield f"step '{step['text']}' is {step['state']}"
    for goal in training["goals"]:
        if not goal["met"]:
            yield f"goal '{goal['metric']}' is not met: {goal['value']}"
    if not training["passed"]:
        yield f"the trial is not passed: {training['outcome']}"
    if metrics["attempts"] != 1:
        yield f"{metrics['attempts']} attempts"
    if has_target(training) and training["trainee"] == "demonstration" and metrics["tip to target, closest"] > 1.0:
        yield f"the tip comes to {metrics['tip to target, closest']} mm of the target only"


def faults_of_run(run, expected):
    for warning in read_json(run / "run.json")["warnings"]:
        if not expected or not warning.startswith(expected):
            yield f"warning: {warning}"


def has_target(training):
    return any(goal["metric"].startswith("tip to target") for goal in training["goals"])


def faults_of_report(run, training):
    """The outcome stands before pictures and tables, and its number is that of the goal."""
    page = (run / "report.html").read_text(encoding="utf-8")
    body = page[page.index("<body"):]
    outcome = html.escape(training["outcome"], quote=False)
    place = html.unescape(body).find(training["outcome"])
    if place < 0:
        yield f"the report does not state the outcome: {outcome}"
        return
    if re.search(r"<(table|svg|img|figure)", html.unescape(body)[:place]):
        yield "the report states the outcome after a picture or table"
    if has_target(training):
        at_end = next(goal["value"] for goal in training["goals"] if goal["metric"] == "tip to target at the end")
        stated = re.search(r"([0-9.]+) mm", training["outcome"])
        if not stated or abs(float(stated[1]) - at_end) > 0.005 + 0.005 * at_end:
            yield f"the outcome and its goal differ: {training['outcome']} {at_end} mm"


def mask(image, holds):
    return image.point(lambda value: 255 if holds(value) else 0)


def needle_contrast(image, labels):
    """Grey level of the shaft over that of the tissue 4 to 11 pixels beside it; 0 where little of it is in the image."""
    shaft = mask(labels, lambda value: value == NEEDLE)
    ring = ImageChops.subtract(shaft.filter(ImageFilter.MaxFilter(23)), shaft.filter(ImageFilter.MaxFilter(7)))
    beside = ImageChops.darker(ring, mask(labels, lambda value: value not in (0, BEYOND)))
    if shaft.histogram()[255] < 30 or beside.histogram()[255] == 0:
        return 0.0
    return ImageStat.Stat(image, shaft).mean[0] / max(1.0, ImageStat.Stat(image, beside).mean[0])


def is_black(image, labels):
    field = mask(labels, lambda value: value != BEYOND)
    return field.getbbox() is None or ImageStat.Stat(mask(image, lambda value: value > 30), field).mean[0] < 0.03 * 255


def faults_of_images(run, shows_target):
    folder = run / "labelled"
    with open(folder / "frames.csv", encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    if shows_target and not any(abs(float(row["target_off_plane_mm"] or 99.0)) <= 2.0 for row in rows):
        yield "no image shows the target"
    best, black, files = 0.0, 0, sorted((folder / "images").glob("*.png"))
    for file in files:
        image, labels = Image.open(file).convert("L"), Image.open(folder / "labels" / file.name)
        black += is_black(image, labels)
        best = max(best, needle_contrast(image, labels))
    if black > len(files) / 4:  # Before the probe is on the skin.
        yield f"{black} of {len(files)} images are black"
    if any(row["tip_column_px"] for row in rows) and best < 1.3:
        yield f"the needle is not seen in any image: {best:.2f} times the grey level beside it"


def faults_of(run, expected):
    training = read_json(run / "training.json")
    yield from faults_of_training(training)
    yield from faults_of_report(run, training)
    yield from faults_of_run(run, expected)
    yield from faults_of_images(run, has_target(training))


if __name__ == "__main__":
    FAULTS = list(faults_of(pathlib.Path(sys.argv[1]), "".join(sys.argv[2:])))
    print("\n".join(FAULTS or ["all is as it should be"]))
    sys.exit(bool(FAULTS))
