"""Whether a demonstration does all of its exercise. Usage: check_play.py RUN_FOLDER

Every step of the checklist is done, every goal is met, the target, if there is one, is reached in one attempt, and nothing warns."""
import json
import pathlib
import sys


def faults_of(run):
    training = json.loads((run / "training.json").read_text(encoding="utf-8"))
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
    has_target = any(goal["metric"].startswith("tip to target") for goal in training["goals"])
    if has_target and metrics["tip to target, closest"] > 1.0:
        yield f"the tip comes to {metrics['tip to target, closest']} mm of the target only"
    for warning in json.loads((run / "run.json").read_text(encoding="utf-8"))["warnings"]:
        yield f"warning: {warning}"


faults = list(faults_of(pathlib.Path(sys.argv[1])))
print("\n".join(faults) or "all steps done, all goals met")
sys.exit(bool(faults))
