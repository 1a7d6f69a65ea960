"""The launcher without its window: sessions of a workplace, answers, consent, curriculum, words."""
import ast
import json
import pathlib
import re
import string
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
LAUNCHER = ROOT / "pipelines" / "launcher"
sys.dont_write_bytecode = True
sys.path[:0] = [str(LAUNCHER), str(LAUNCHER.parent / "common")]

import add_case  # noqa: E402
import jobs  # noqa: E402
import sessions  # noqa: E402
import texts  # noqa: E402
import wording  # noqa: E402
import workplace  # noqa: E402
from files import UserError, read_csv, write_whole  # noqa: E402
from sessions import State  # noqa: E402

STUDY = """// Comments are allowed.
{"format": "acus-study/1", "name": "S", "questionnaires": ["q.json"],
 "participants": [{"code": "N1"}, {"code": "E1", "consent": true}]}"""
QUESTIONS = {"format": "acus-questionnaire/1", "key": "face", "title": "Face", "scale": ["no", "so", "yes"],
             "items": [{"key": "looks", "text": "It looks real."}, {"key": "feels", "text": "It feels real."}]}


class WithWorkplace(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = pathlib.Path(self.temporary.name).resolve()
        self.write("scenario.json", "{}")
        self.write("exercises/one.json", '{"name": "Exercise one"}')
        self.write("exercises/two_more.json", '// Why.\n{"name": "Exercise two"}')
        (self.folder / "sessions").mkdir()

    def write(self, name, text):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return path

    def place(self):
        return workplace.Workplace(self.folder, "/nowhere", self.folder)

    def session(self, trainee, stamp, ended=True, goals=None, exercise="one"):
        folder = f"sessions/{trainee}/{stamp}_{exercise}"
        self.write(f"{folder}/session.json", "{}")
        if ended:
            self.write(f"{folder}/summary.json", "{}")
        if goals is not None:
            self.write(f"{folder}/report/training.json", json.dumps({"goals": [{"met": met} for met in goals]}))
        return self.folder / folder


class Sessions(WithWorkplace):
    def test_states_are_those_of_the_folders(self):
        self.session("A", "2026-01-01_10-00-00", goals=[True, False])
        self.session("A", "2026-01-01_10-05-00")
        self.session("A", "2026-01-01_10-10-00", ended=False)
        self.session("A", "2026-01-01_10-15-00", ended=False, goals=[True], exercise="two_more")
        (self.folder / "sessions/A/2026-01-01_11-00-00_one").mkdir()  # Nothing was recorded.
        self.write("sessions/A/progress_one/session.json", "{}")
        found = sessions.find(self.folder)
        self.assertEqual([s.state for s in found], [State.DONE, State.NO_REPORT, State.NO_END, State.RECOVERED])
        self.assertEqual((found[0].goals, found[0].time, found[0].trainee), ("1/2", "10:00:00", "A"))
        self.assertEqual(found[3].exercise, "two_more")
        self.assertEqual(sessions.to_finish(found), found[1:3])

    def test_the_second_of_a_second_is_a_session_too(self):
        self.session("A", "2026-01-01_10-00-00.2", exercise="two_more")
        self.assertEqual(sessions.find(self.folder)[0].exercise, "two_more")

    def test_a_session_that_a_process_writes_is_running(self):
        folder = self.session("A", "2026-01-01_10-00-00", ended=False)
        with open(folder / "needle.csv", "w", encoding="utf-8"):
            found = sessions.find(self.folder)
            self.assertEqual(found[0].state, State.RUNNING)
            with self.assertRaisesRegex(UserError, "running"):
                sessions.discard(found[0], "x")
        self.assertEqual(sessions.find(self.folder)[0].state, State.NO_END)

    def test_a_discarded_session_keeps_its_files_and_its_reason(self):
        folder = self.session("A", "2026-01-01_10-00-00", goals=[True])
        before = sorted(folder.rglob("*"))
        session = sessions.find(self.folder)[0]
        with self.assertRaisesRegex(UserError, "with a reason"):
            sessions.discard(session, "  ")
        sessions.discard(session, 'cable "loose", ä')
        self.assertEqual(sorted([*before, folder / "discarded.json"]), sorted(folder.rglob("*")))
        session = sessions.find(self.folder)[0]
        self.assertEqual((session.state, session.reason), (State.DISCARDED, 'cable "loose", ä'))
        with self.assertRaisesRegex(UserError, "already: cable"):
            sessions.discard(session, "again")
        (folder / "discarded.json").write_text("", encoding="utf-8")  # Broken, but there.
        self.assertEqual(sessions.find(self.folder)[0].state, State.DISCARDED)


class OfAWorkplace(WithWorkplace):
    def test_what_is_no_workplace_is_said(self):
        (self.folder / "scenario.json").unlink()
        with self.assertRaisesRegex(UserError, "live-session --new"):
            self.place()

    def test_a_broken_study_is_said(self):
        for text, message in (('{"participants": [3]}', "study.json: is no study"),
                              ('{"trials": "many"}', "study.json: is no study"),
                              ('{"participants": ', "study.json: no readable JSON"),
                              ('{"questionnaires": ["x.json"]}', "x.json: no such file, and no preset"),
                              ('{"questionnaires": ["exercises/one.json"]}', "is no questionnaire")):
            self.write("study.json", text)
            with self.assertRaisesRegex(UserError, message):
                self.place()

    def test_trainees_are_those_of_the_study_added_and_seen(self):
        self.write("study.json", STUDY)
        self.write("q.json", json.dumps(QUESTIONS))
        self.session("Z9", "2026-01-01_10-00-00")
        place = self.place()
        place.add_trainee("B-2", [])
        self.assertEqual(place.trainees(sessions.find(self.folder)), ["N1", "E1", "B-2", "Z9"])
        place.add_trainee("L1", [], "left")
        self.assertEqual([place.is_left_handed(code) for code in ("L1", "B-2", "N1")], [True, False, False])
        for code, message in (("B-2", "there already"), ("A 7", "may only hold"), ("../x", "may only hold"),
                              ("", "may only hold")):
            with self.assertRaisesRegex(UserError, message):
                place.add_trainee(code, [])

    def test_consent_is_asked_once_and_only_of_a_study(self):
        self.assertFalse(self.place().must_ask_consent("N1"))
        self.write("study.json", STUDY)
        self.write("q.json", json.dumps(QUESTIONS))
        place = self.place()
        self.assertTrue(place.must_ask_consent("N1"))
        self.assertFalse(place.must_ask_consent("E1"))  # The study has it.
        place.record_consent("N1", False)
        self.assertFalse(place.must_ask_consent("N1"))
        self.assertIsNone(place.open_questionnaire("N1"))
        place.record_consent("N1", True)
        self.assertTrue(place.has_consent("N1"))

    def test_answers_are_appended_and_asked_once(self):
        self.write("study.json", STUDY)
        self.write("q.json", json.dumps(QUESTIONS))
        # As acus-study plan makes it: rows without an answer.
        self.write("answers.csv", "code,questionnaire,item,answer\nN1,face,looks,2\nE1,face,looks,\n")
        place = self.place()
        asked = place.open_questionnaire("E1")
        self.assertEqual([key for key, _ in asked.items], ["looks", "feels"])
        with self.assertRaisesRegex(UserError, "off the scale of 1 to 3"):
            place.record_answers("E1", asked, {"looks": 4})
        place.record_answers("E1", asked, {"looks": 3})
        asked = place.open_questionnaire("E1")
        self.assertEqual([key for key, _ in asked.items], ["feels"])
        place.record_answers("E1", asked, {"feels": 1})
        self.assertIsNone(place.open_questionnaire("E1"))
        rows = read_csv(self.folder / "answers.csv", workplace.ANSWERS)
        self.assertEqual([tuple(row.values()) for row in rows], [
            ("N1", "face", "looks", "2"), ("E1", "face", "looks", ""), ("E1", "face", "looks", "3"),
            ("E1", "face", "feels", "1")])

    def test_a_table_without_its_column_is_left_alone(self):
        path = self.write("trainees.csv", "name\nX\n")
        with self.assertRaisesRegex(UserError, "trainees.csv:1: the column code is missing"):
            self.place().add_trainee("A", [])
        self.assertEqual(path.read_text(encoding="utf-8"), "name\nX\n")

    def test_without_a_curriculum_the_last_exercise_comes_again(self):
        self.session("A", "2026-01-01_10-00-00", exercise="two_more")
        found = sessions.find(self.folder)
        steps = self.place().steps(["A", "B"], found)
        self.assertEqual(steps["A"][1], "two_more")
        self.assertEqual([step.trials for step in steps["A"][0]], [0, 1])
        self.assertEqual(steps["B"][1], "one")
        sessions.discard(found[0], "x")
        self.assertEqual(self.place().steps(["A"], sessions.find(self.folder))["A"][1], "one")

    def test_a_failed_write_leaves_nothing_of_its_own(self):
        with self.assertRaisesRegex(UserError, "sessions: cannot be written"):
            write_whole(self.folder / "sessions", "in place of a folder")
        self.assertEqual(list(self.folder.glob(".partial*")), [])


    def test_a_study_without_a_curriculum_goes_by_its_plan(self):
        self.write("study.json", '{"trials": 2, "participants": [{"code": "A"}]}')
        self.write("order.csv", "code,group,place,exercise\nB,x,1,Exercise one\n"
                   "A,x,1,Exercise two\nA,x,2,Exercise one\n")
        place = self.place()
        followed = []
        for minute in range(10, 14):
            steps, following = place.steps(["A"], sessions.find(self.folder))["A"]
            followed.append(following)
            self.session("A", f"2026-01-01_10-{minute}-00", exercise=following)
        self.assertEqual(followed, ["two_more", "two_more", "one", "one"])
        steps, following = place.steps(["A"], sessions.find(self.folder))["A"]
        self.assertEqual([(step.exercise, step.state) for step in steps], [("two_more", "done"), ("one", "done")])
        self.assertIsNone(following)


class BesideTheWindow(WithWorkplace):
    """A script in place of pipelines/live-session."""

    def script(self, text):
        path = self.write("stand_in", f"#!/bin/sh\n{text}\n")
        path.chmod(0o755)
        return jobs.Jobs(path, self.folder, ["--headless"])

    def wait(self, runs, kind):
        for _ in range(200):
            for ended in runs.poll():
                if ended[0] == kind:
                    return ended
            time.sleep(0.02)
        return self.fail(f"no {kind} ended")

    # Answers each request as acus-live --requests does.
    ANSWERS = r"""echo '{"event": "ready"}'
while read -r line; do
  printf '%s\n' "$line" >> requests
  echo noise
  sleep 0.2
  printf '{"event": "ended", "output": "", "code": %s, "message": "why"}\n' "$(cat code)"
done"""

    def requests(self):
        return [json.loads(line) for line in (self.folder / "requests").read_text(encoding="utf-8").splitlines()]

    def test_one_session_at_a_time_and_one_program_for_all(self):
        self.write("code", "4")
        runs = self.script(f"echo $$ >> {self.folder}/programs; cd {self.folder}\n{self.ANSWERS}")
        runs.start_session("A", "one")
        folder = runs.session
        with self.assertRaisesRegex(UserError, "running"):
            runs.start_session("B", "one")
        self.assertEqual(self.wait(runs, "session"), ("session", 4, "why"))
        self.assertFalse(folder.exists(), "nothing was recorded in it")
        self.write("code", "0")
        runs.start_session("B", "one", trial=3, limit_s=90, left_handed=True, caption="Step 1 of 2")
        self.assertEqual(self.wait(runs, "session"), ("session", 0, ""))
        first, second = self.requests()
        self.assertEqual(first["exercise"], str(self.folder / "exercises/one.json"))
        self.assertEqual(first["scenario"], str(self.folder / "scenario.json"))
        self.assertEqual((first["duration_s"], first["trial"], first["left_handed"]), (0.0, 1, False))
        self.assertEqual((second["duration_s"], second["trial"], second["left_handed"]), (90, 3, True))
        self.assertEqual((first["caption"], second["caption"]), ("", "Step 1 of 2"))
        self.assertRegex(second["output"], "/sessions/B/[0-9_-]+_one$")
        self.assertEqual(len((self.folder / "programs").read_text(encoding="utf-8").split()), 1)
        runs.close()
        self.assertFalse(runs.live.is_running())

    def test_a_program_that_dies_is_started_anew(self):
        runs = self.script("read line; echo acus-live: the reason >&2; exit 5")
        for _ in range(2):
            runs.start_session("A", "one")
            self.assertEqual(self.wait(runs, "session"), ("session", 5, "acus-live: the reason"))

    def test_a_session_waits_for_the_check_of_the_devices(self):
        self.write("code", "0")
        runs = self.script(f'cd {self.folder}; case "$*" in *--check*) sleep 0.3; touch checked; exit 0 ;; esac\n'
                           f"[ -f checked ] || exit 9\n{self.ANSWERS}")
        runs.start_check()
        runs.start_session("A", "one")
        self.assertEqual(self.wait(runs, "session"), ("session", 0, ""))
        runs.close()

    def test_an_exercise_may_have_a_patient_of_its_own(self):
        self.write("code", "0")
        self.write("exercises/case_7.json", '{"name": "Case 7", "scenario": "case_7/scenario.json"}')
        self.write("exercises/case_7/scenario.json", "{}")
        runs = self.script(f"cd {self.folder}\n{self.ANSWERS}")
        runs.start_session("A", "case_7")
        self.wait(runs, "session")
        self.assertEqual(self.requests()[0]["scenario"], str(self.folder / "exercises/case_7/scenario.json"))
        runs.close()

    def test_each_session_is_reported_once_even_if_that_fails(self):
        self.session("A", "2026-01-01_10-00-00")
        self.session("A", "2026-01-01_10-05-00", ended=False)
        runs = self.script("exit 3")
        ended = []
        for _ in range(50):
            runs.finish(sessions.find(self.folder))
            ended += runs.poll()
            time.sleep(0.02)
        self.assertEqual([(kind, code) for kind, code, _ in ended], [("report", 3), ("report", 3)])

    def test_what_may_be_running_is_not_reported(self):
        self.session("A", "2026-01-01_10-05-00", ended=False)
        runs = self.script("sleep 0.2")
        runs.start_session("A", "one")
        runs.finish(sessions.find(self.folder))
        self.assertEqual(runs.num_reports, 0)
        self.wait(runs, "session")
        runs.finish(sessions.find(self.folder))
        self.assertEqual(runs.num_reports, 1)
        self.wait(runs, "report")


class AnotherPatient(WithWorkplace):
    def patient(self, name, entry, target):
        for file in ("ct.nrrd", "labels.seg.nrrd"):
            self.write(f"{name}/{file}", "")
        self.write(f"{name}/corridor_ct.csv", "name,x_mm,y_mm,z_mm\n" + "".join(
            f"{key},{','.join(map(str, point))}\n" for key, point in (("entry", entry), ("target", target))))
        return self.folder / name

    def moved(self, matrix, point):
        return [sum(row[k] * point[k] for k in range(3)) + row[3] for row in matrix[:3]]

    def test_entry_and_direction_are_where_those_of_the_first_one_are(self):
        self.patient("own", (10, 20, 30), (10, 80, 50))
        turn = [0, -1, 0, 5, 1, 0, 0, -6, 0, 0, 1, 7, 0, 0, 0, 1]
        self.write("scenario.json", json.dumps({"effects": {}, "patient": {
            "corridor": "own/corridor_ct.csv", "ct_from_reference": turn}}))
        other = self.patient("other", (-40, 5, 900), (-10, 60, 870))
        made = add_case.add(self.folder, "case_2", other, self.folder / "exercises/one.json")
        scenario = json.loads(made[0].read_text(encoding="utf-8"))
        numbers = scenario["patient"]["ct_from_reference"]
        placed = [numbers[4 * row:4 * row + 4] for row in range(4)]
        own = add_case.rigid_inverse([turn[4 * row:4 * row + 4] for row in range(4)])
        entry = self.moved(own, (10, 20, 30))  # In the reference frame, as the target's direction is.
        for got, wanted in zip(self.moved(placed, entry), (-40, 5, 900)):
            self.assertAlmostEqual(got, wanted, 9)
        along = self.moved(own, (10, 80, 50))
        share = (30**2 + 55**2 + 30**2)**0.5 / (60**2 + 20**2)**0.5
        there = [a + share * (b - a) for a, b in zip(entry, along)]
        for got, wanted in zip(self.moved(placed, there), (-10, 60, 870)):
            self.assertAlmostEqual(got, wanted, 9)
        exercise = json.loads(made[1].read_text(encoding="utf-8"))
        self.assertEqual((exercise["name"], exercise["scenario"]), ("Exercise one, case_2", "../case_case_2.json"))
        self.assertEqual(self.place().exercises["case_2"], "Exercise one, case_2")

    def test_a_transform_of_acus_register_is_read(self):
        file = self.write("t.tfm", "#Insight Transform File V1.0\nTransform: AffineTransform_double_3_3\n"
                          "Parameters: 0 -1 0 1 0 0 0 0 1 5 6 7\nFixedParameters: 1 2 3\n")
        # M (x - c) + c + t of the centre itself is c + t.
        self.assertEqual(self.moved(add_case.read_transform(file), (1, 2, 3)), [6, 8, 10])

    def test_what_cannot_be_placed_is_refused_and_leaves_nothing(self):
        own = self.patient("own", (0, 0, 0), (0, 50, 0))
        scenario = {"effects": {}, "patient": {"corridor": "own/corridor_ct.csv"}}
        task = self.folder / "exercises/one.json"
        for change, patient, reason in (
                ({"effects": {"breathing": {}}}, own, "breath of its own patient"),
                ({"patient": {}}, own, "corridor is missing"),
                ({}, self.patient("flat", (0, 0, 0), (0, 0.5, 0)), "less than 1 mm"),
                ({}, self.folder / "exercises", "corridor_ct.csv: no such file")):
            self.write("scenario.json", json.dumps({**scenario, **change}))
            with self.assertRaisesRegex(UserError, reason):
                add_case.add(self.folder, "x", patient, task)
        with self.assertRaisesRegex(UserError, "letters from a to z"):
            add_case.add(self.folder, "../x", own, task)
        self.assertFalse((self.folder / "exercises/x.json").exists() or (self.folder / "case_x.json").exists())


class Words(unittest.TestCase):
    def used(self):
        """Keys in calls of texts(...) and of what hands them on; and the values of each."""
        keys = set()
        for file in LAUNCHER.glob("*.py"):
            for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Constant) and isinstance(node.value, str):
                    keys.add(node.value)
        keys |= {f"state_{state.value}" for state in State}
        keys |= {f"state_{word}" for word in ("open", "locked", "mastered")}
        source = (LAUNCHER / "window.py").read_text(encoding="utf-8")
        for columns in re.findall(r"_table\([^{]*{([^}]*)}", source):
            keys |= {f"column_{name}" for name in re.findall(r'"(\w+)":', columns)}
        return keys

    def test_every_word_is_used(self):
        self.assertEqual(sorted(set(texts.english()) - self.used()), [])

    def test_every_used_word_is_there(self):
        words = texts.english()
        for file in LAUNCHER.glob("*.py"):
            tree = ast.parse(file.read_text(encoding="utf-8"))
            for node in ast.walk(tree):
                if not isinstance(node, ast.Call):
                    continue
                name = getattr(node.func, "attr", getattr(node.func, "id", ""))
                place = {"texts": 0, "add_button": 0, "_button": 1, "_ask_reason": 0}.get(name)
                if place is None or len(node.args) <= place or not isinstance(node.args[place], ast.Constant):
                    continue
                key = node.args[place].value
                self.assertIn(key, words, file.name)
                if name == "texts":
                    given = {word.arg for word in node.keywords}
                    asked = {field for _, field, _, _ in string.Formatter().parse(words[key]) if field}
                    self.assertLessEqual(asked, given, f"{file.name}: {key}")
        self.assertGreaterEqual(set(words), {key for key in self.used() if key.startswith(("state_", "column_"))} -
                                {"state_", "column_"})

    def test_languages_have_the_same_values_in_their_texts(self):
        def fields(text):
            return sorted(f for _, f, _, _ in string.Formatter().parse(text) if f)
        for language in texts.languages():
            for key, text in texts.Texts(language).words.items():
                self.assertEqual(fields(text), fields(texts.english()[key]), f"{language}: {key}")

    def test_languages_differ_where_there_are_catalogues(self):
        for language in set(texts.languages()) - {"en"}:
            self.assertNotEqual(texts.Texts(language).words["exercises"], texts.english()["exercises"])


class Wording(unittest.TestCase):
    def test_one_is_singular_and_times_have_the_unit_that_suits_them(self):
        self.assertEqual([wording.counted(n, "job") for n in (0, 1, 2)], ["0 jobs", "1 job", "2 jobs"])
        self.assertEqual([wording.duration(s) for s in (0.4, 89, 97, 3600, 5400, 9000)],
                         ["0 s", "89 s", "2 min", "60 min", "1.5 h", "2.5 h"])


class CommandLine(unittest.TestCase):
    def test_a_folder_that_is_no_workplace(self):
        done = subprocess.run([ROOT / "pipelines/training-day", "--list", "/nowhere"], capture_output=True, text=True,
                              check=False)
        self.assertEqual(done.returncode, 3)
        self.assertRegex(done.stderr, "training-day: /nowhere is no workplace.*--new")
        self.assertEqual(len(done.stderr.splitlines()), 1)


if __name__ == "__main__":
    unittest.main()
