"""What a workplace asks of its trainees: exercises, curriculum, consent and questionnaires."""
import dataclasses
import datetime
import json
import pathlib
import subprocess

import sessions
from files import UserError, append_csv, read_csv, read_json_object

ANSWERS = ["code", "questionnaire", "item", "answer"]
CONSENT = ["code", "consent", "time"]
TRAINEES = ["code", "hand"]
ORDER = ["code", "exercise"]


@dataclasses.dataclass(frozen=True)
class Step:
    """An exercise for a trainee. Without a curriculum every one is open, or done as often as the study plans."""
    exercise: str  # The file's name in exercises/, without .json; None if the workplace does not have it.
    title: str
    state: str = "open"  # open, locked, mastered or done
    trials: int = 0
    best_percent: float = 0.0
    limit_s: float | None = None  # Of a session.
    place: tuple | None = None  # In a curriculum: step, of how many, successes in a row, of how many.


@dataclasses.dataclass(frozen=True)
class Questionnaire:
    key: str
    title: str
    scale: list
    items: list  # (key, text)


class Workplace:
    def __init__(self, folder, programs, configs):
        self.folder = pathlib.Path(folder).resolve()
        self.programs = pathlib.Path(programs)
        self.configs = pathlib.Path(configs)
        if not (self.folder / "scenario.json").exists():
            raise UserError(f"{self.folder} is no workplace: it has no scenario.json. "
                            f"Make one with: pipelines/live-session --new {folder}")
        self.exercises = {}
        for file in sorted((self.folder / "exercises").glob("*.json")):
            self.exercises[file.stem] = str(read_json_object(file).get("name", file.stem))
        if not self.exercises:
            raise UserError(f"There is no exercise in {self.folder}/exercises; copy one from configs/exercises.")
        (self.folder / "sessions").mkdir(exist_ok=True)
        self.curriculum = self.folder / "curriculum.json"
        study = self.folder / "study.json"
        self.study = read_json_object(study) if study.exists() else None
        # Codes in the study's order, and whether its file has their consent.
        try:
            self.people = {str(person["code"]): bool(person.get("consent", False))
                           for person in (self.study or {}).get("participants", [])}
            names = [pathlib.Path(name) for name in (self.study or {}).get("questionnaires", [])]
            self.trials = int((self.study or {}).get("trials", 3))
        except (AttributeError, KeyError, TypeError, ValueError) as error:
            raise UserError(f"{study}: is no study; acus-study plan says what is wrong with it") from error
        self.questionnaires = [self._questionnaire(name) for name in names]

    def _questionnaire(self, name):
        """From a file of the workplace, or the preset of the same name."""
        near = self.folder / name
        file = near if near.exists() else self.configs / name
        if not file.exists():
            raise UserError(f"{near}: no such file, and no preset; the study of the workplace names it")
        document = read_json_object(file)
        try:
            return Questionnaire(document["key"], document["title"], [str(word) for word in document["scale"]],
                                 [(item["key"], item["text"]) for item in document["items"]])
        except (KeyError, TypeError) as error:
            raise UserError(f"{file}: is no questionnaire (acus-questionnaire): {error} is missing") from error

    def trainees(self, found):
        """Codes: the study's, those that were added, those who have sessions."""
        codes = [*self.people, *(row["code"] for row in read_csv(self.folder / "trainees.csv", TRAINEES)),
                 *sorted({session.trainee for session in found})]
        return list(dict.fromkeys(codes))

    def is_left_handed(self, code):
        return any(row["code"] == code and row["hand"] == "left"
                   for row in read_csv(self.folder / "trainees.csv", TRAINEES))

    def add_trainee(self, code, found, hand="right"):
        """@throws UserError for a code that is none, or is there."""
        sessions.check_code(code)
        if code in self.trainees(found):
            raise UserError(f"The code {code} is there already.")
        append_csv(self.folder / "trainees.csv", TRAINEES, [{"code": code, "hand": hand}])

    # Consent

    def must_ask_consent(self, code):
        """Only of a study, and once."""
        if self.study is None or self.people.get(code, False):
            return False
        return all(row["code"] != code for row in read_csv(self.folder / "consent.csv", CONSENT))

    def has_consent(self, code):
        rows = [row for row in read_csv(self.folder / "consent.csv", CONSENT) if row["code"] == code]
        return rows[-1]["consent"] == "yes" if rows else self.people.get(code, False)

    def record_consent(self, code, given, now=None):
        now = now or datetime.datetime.now()
        append_csv(self.folder / "consent.csv", CONSENT, [
            {"code": code, "consent": "yes" if given else "no", "time": now.isoformat(timespec="seconds")}])

    # Questionnaires

    def open_questionnaire(self, code):
        """The first questionnaire with items that this participant has not answered, with these items alone; or
        None. Only participants of the study with consent are asked: acus-study reads no others."""
        if code not in self.people or not self.has_consent(code):
            return None
        answered = {(row["questionnaire"], row["item"])
                    for row in read_csv(self.folder / "answers.csv", ANSWERS)
                    if row["code"] == code and row["answer"]}
        for asked in self.questionnaires:
            left = [item for item in asked.items if (asked.key, item[0]) not in answered]
            if left:
                return dataclasses.replace(asked, items=left)
        return None

    def record_answers(self, code, asked, answers):
        """answers: from the keys of items to numbers from 1 to the size of the scale."""
        for item, answer in answers.items():
            if not 1 <= answer <= len(asked.scale):
                raise UserError(f"{item}: the answer {answer} is off the scale of 1 to {len(asked.scale)}")
        append_csv(self.folder / "answers.csv", ANSWERS, [
            {"code": code, "questionnaire": asked.key, "item": item, "answer": answer}
            for item, answer in answers.items()])

    def registration(self):
        """Error of the markers in mm (FRE, RMS) and their number, of acus-register; None without that file."""
        file = self.folder / "registration" / "registration.json"
        if not file.exists():
            return None
        document = read_json_object(file)
        error, markers = document.get("fre_rms_mm"), document.get("num_points")
        return None if error is None or markers is None else (float(error), int(markers))

    # Exercises

    def steps(self, codes, found):
        """For each code its exercises as Steps, and the next one's name or None if all are mastered."""
        if not self.curriculum.exists():
            return {code: self._steps_without_curriculum(code, found) for code in codes}
        if not codes:
            return {}
        done = subprocess.run([self.programs / "acus-training", "curriculum", self.curriculum, "--trials",
                               self.folder / "sessions", "--trainee", ",".join(codes), "--json"],
                              capture_output=True, text=True, check=False, cwd=self.folder)
        if done.returncode != 0:
            raise UserError(done.stderr.strip() or "acus-training curriculum was ended by a signal")
        return self._steps_of(json.loads(done.stdout))

    def _steps_without_curriculum(self, code, found):
        kept = [session.exercise for session in found
                if session.trainee == code and session.state is not sessions.State.DISCARDED]
        steps = [Step(name, title, trials=kept.count(name)) for name, title in self.exercises.items()]
        planned = [row["exercise"] for row in read_csv(self.folder / "order.csv", ORDER) if row["code"] == code]
        if planned:
            return self._steps_in_order(steps, planned)
        last = kept[-1] if kept and kept[-1] in self.exercises else next(iter(self.exercises))
        return steps, last

    def _steps_in_order(self, steps, planned):
        """As acus-study plan ordered them for this participant; what is not planned comes last."""
        steps = [dataclasses.replace(step, state="done" if step.title in planned and step.trials >= self.trials else "open")
                 for step in steps]
        steps.sort(key=lambda step: planned.index(step.title) if step.title in planned else len(planned))
        left = [step.exercise for step in steps if step.title in planned and step.state == "open"]
        return steps, left[0] if left else None

    def _steps_of(self, document):
        """From the output of acus-training curriculum --json. Exercises of the workplace are found by their names,
        as sessions are. Of a step with cases it is the one that is next for the trainee."""
        by_title = {title: name for name, title in self.exercises.items()}
        result = {}
        for code, progress in document["trainees"].items():
            steps = []
            for number, (step, at) in enumerate(zip(document["steps"], progress["steps"]), 1):
                case = at["next_case"]["exercise"]
                title = case if step["cases"] == 1 else f"{step['exercise']}: {case}"
                steps.append(Step(by_title.get(case), title, at["state"], at["trials"], at["best_score_percent"],
                                  step["time_limit_s"],
                                  (number, len(document["steps"]), at["longest_row"], step["in_a_row"])))
            following = progress["next"]
            result[code] = steps, None if following is None else steps[following].exercise
        return result
