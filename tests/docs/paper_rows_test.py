"""Sentences of the pages of the papers: pipelines/paper_pages/NAME.toml, rows.py and work.py."""
import importlib.machinery
import importlib.util
import math
import os
import pathlib
import random
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGES = ROOT / "pipelines" / "paper_pages"
DATA = ROOT / "docs" / "data" / "papers"
sys.dont_write_bytecode = True
sys.path.append(str(PAGES))

import rows  # noqa: E402
import work  # noqa: E402

# Words that compare: outside of an expression they would stay when the numbers change.
COMPARING = re.compile(r"\b(more|less|same|slower|faster|larger|smaller|above|below|within|beyond|higher|lower|equal|"
                       r"similar|better|worse|stronger|weaker|rises|falls|stiffer|softer|exceeds?)\b", re.IGNORECASE)
# Numbers that name a thing, not a result: figures, tables and equations of the paper, names of files and of settings.
NAMES = re.compile(r"[Ff]igures? \d+[a-z]?(?:, (?:upper|lower|right|left))?(?:(?:,| and| to) \d+[a-z]?)*|[Tt]able (?:\d+|II?)|"
                   r"eq\. \d+|[\w./-]*[a-z]_[\w./-]*\d[\w./-]*|[\w./-]+\.(?:md|json|sh)|algorithm 1|section [\d.]+|\b\d?D\b|"
                   r"Vidal-2008|GeForce [GTX ]*\d+|\d[\d.]* k?Hz|\d+ (?:and \d+ )?iterations?|1 with twice|from 50|\d+ nodes|5:|the same")
TEMPLATES = sorted(PAGES.glob("*.toml"))


def literal(text):
    """What is not computed."""
    return NAMES.sub("", rows.EXPRESSION.sub("", text))


def changed(value, random_numbers):
    """A fact as another run could have it."""
    if isinstance(value, str):
        return value + "x"
    factor = random_numbers.choice((-1, 1)) if random_numbers.random() < 0.1 else 1
    return factor * (value or 1.0) * math.exp(random_numbers.uniform(-3, 3))


class Sentences(unittest.TestCase):
    def every_row(self):
        for path in TEMPLATES:
            template = rows.read_template(path)
            facts = rows.read_facts(DATA / f"{path.stem}.csv")
            for name, table in template["table"].items():
                for row in table:
                    if row.get("if", "") in ("", *facts):
                        yield f"{path.stem}, {name}, {row['quantity']}", row, facts

    def test_there_is_one_template_for_each_paper(self):
        self.assertEqual([path.stem for path in TEMPLATES],
                         ["alamilla_2021", "augmented_2010", "fortmeier_2016", "vidal_2008"])

    def test_no_number_and_no_comparison_of_ours_is_written_down(self):
        for path in TEMPLATES:
            template = rows.read_template(path)
            for table in template["table"].values():
                for row in table:
                    text = literal(row.get("acus", ""))
                    self.assertIsNone(re.search(r"\d", text), f"{path.name}: '{row['quantity']}': acus: {text}")
                    for column in ("acus", "why"):
                        self.assertIsNone(COMPARING.search(literal(row.get(column, ""))),
                                          f"{path.name}: '{row['quantity']}': {column}: {row.get(column)}")

    def depends(self, row, facts, used, key, numbers):
        """True if this row, of a run whose other results are random too, is another when one fact is."""
        others = {k: changed(dict.__getitem__(facts, k), numbers) for k in used if numbers.random() < 0.5}
        outcomes = []
        for value in (dict.__getitem__(facts, key), changed(dict.__getitem__(facts, key), numbers)):
            try:
                outcomes.append(rows.filled_row(row, rows.Facts(facts | others | {key: value})))
            except rows.RowError:
                outcomes.append("fails")
        return outcomes[0] != outcomes[1]

    def test_every_sentence_changes_or_fails_when_results_change(self):
        numbers = random.Random(44)
        count = 0
        for where, row, facts in self.every_row():
            before = rows.filled_row(row, facts)
            used = sorted(set(facts.used))  # A set has another order in each process.
            facts.used.clear()
            for key in used:
                self.assertTrue(any(self.depends(row, facts, used, key, numbers) for _ in range(3000)),
                                f"{where}: nothing changes with {key}")
                count += 1
            if re.search(r"\d", NAMES.sub("", before[2])):
                self.assertTrue(used, f"{where}: says a number and reads no fact")
        self.assertGreater(count, 100)

    def test_a_fact_that_was_not_measured_makes_no_page(self):
        for where, row, facts in self.every_row():
            rows.filled_row(row, facts)
            for key in set(facts.used):
                without = rows.Facts({k: v for k, v in facts.items() if k != key})
                with self.assertRaises(rows.RowError, msg=f"{where}: {key}"):
                    rows.filled_row(row, without)
            facts.used.clear()

    def test_captions_are_filled(self):
        for path in TEMPLATES:
            facts = rows.read_facts(DATA / f"{path.stem}.csv")
            for key, text in rows.read_template(path)["caption"].items():
                self.assertNotIn("{", rows.fill(text, facts), key)


class Load(unittest.TestCase):
    def test_a_busy_machine_a_quick_run_and_one_without_a_record_are_said(self):
        idle = {"quick": 0.0, "cores": 2.0, "others_percent": 3.0}
        self.assertNotIn("longer", rows.load_of(rows.Facts(idle)))
        self.assertIn("longer", rows.load_of(rows.Facts(idle | {"others_percent": 40.0})))
        self.assertIn("40 % of the machine's 2 cores", rows.load_of(rows.Facts(idle | {"others_percent": 40.0})))
        self.assertIn("not for print", rows.load_of(rows.Facts(idle | {"quick": 1.0})))
        self.assertIn("not recorded", rows.load_of(rows.Facts({})))


class Limits(unittest.TestCase):
    """What a row of table 2 may take: peak.py, and the row that says why there is no number."""

    def run_peak(self, at_most, *command):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "peak"
            code = subprocess.run([sys.executable, PAGES / "peak.py", path, *command], check=False,
                                  env=os.environ | {"AT_MOST": at_most}).returncode
            return code, path.read_text(encoding="utf-8").strip()

    def test_a_command_has_its_code_and_its_memory(self):
        code, memory = self.run_peak("inf inf", sys.executable, "-c", "import sys; block = bytearray(64 << 20); sys.exit(3)")
        self.assertEqual(code, 3)
        self.assertGreater(float(memory), 64)

    def test_a_command_that_takes_too_much_is_ended(self):
        self.assertEqual(self.run_peak("inf 0.2", "sleep", "600"), (75, "more than 0.2 s"))
        greedy = "import time; block = bytearray(200 << 20); time.sleep(600)"
        self.assertEqual(self.run_peak("100 inf", sys.executable, "-c", greedy), (75, "more than 100 MB"))

    def test_its_row_says_so(self):
        template = rows.read_template(PAGES / "fortmeier_2016.toml")
        facts = {"width_px": 2.0, "height_px": 1.0, "layer": "skin", "key_frame_256_large_over": "more than 100 MB"}
        template["table"]["volume"] = [row for row in template["table"]["volume"] if row["if"] == "key_frame_256_large_over"]
        self.assertEqual([row[4] for row in rows.table(template, rows.Facts(facts), "volume")], ["the run was ended: more than 100 MB"])


class Plots(unittest.TestCase):
    def plot(self, text):
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "a.csv").write_text(text, encoding="utf-8")
            subprocess.run(["bash", "-c", f"source '{PAGES}/common.sh'; plot a.svg title x y name=a.csv"], check=True, cwd=folder)
            return (pathlib.Path(folder) / "a.svg").read_text(encoding="utf-8")

    def test_ticks_are_round_numbers_within_the_data(self):
        svg = self.plot("-142,99.2\n-87.4,113\n")
        self.assertEqual(re.findall(r'text-anchor="middle">([^<]*)', svg), ["-140", "-130", "-120", "-110", "-100", "-90"])
        self.assertEqual(re.findall(r'text-anchor="end">([^<]*)', svg), ["100", "105", "110"])
        self.assertEqual(re.findall(r'text-anchor="end">([^<]*)', self.plot("0,-0.3\n1,0.3\n")), ["-0.3", "-0.2", "-0.1", "0", "0.1", "0.2", "0.3"])

    def test_an_empty_line_begins_another_line(self):
        lines = re.findall(r'points="([^"]*)"', self.plot("0,0\n1,1\n\n2,0\n3,1\n"))
        self.assertEqual([len(line.split()) for line in lines], [2, 2])


def paper_pages_module():
    loader = importlib.machinery.SourceFileLoader("paper_pages", str(ROOT / "developer" / "paper-pages"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("paper_pages", loader))
    loader.exec_module(module)
    return module


paper_pages = paper_pages_module()
TEST = re.compile(r"TEST(?:_F|_P)?\((\w+),\s*(\w+)\)")
ADDED = re.compile(r"NAME ([\w.]+)")
# Of each paper: how many equations it numbers, tables and figures.
NUMBERED = {"vidal_2008": (8, 3, 7), "alamilla_2021": (14, 2, 20), "fortmeier_2016": (13, 2, 13), "augmented_2010": (0, 0, 3)}


def words_of(text):
    """Numbers that a row names: 'figures 1 to 4' are four."""
    found = [int(n) for n in re.findall(r"\d+", text)]
    return range(found[0], found[1] + 1) if " to " in text and len(found) == 2 else found


class Items(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.items = paper_pages.read_items(ROOT / "docs" / "data" / "papers" / "items.psv")
        cls.tests = set()
        for path in (ROOT / "tests").rglob("*.cpp"):
            cls.tests.update(".".join(match) for match in TEST.findall(path.read_text(encoding="utf-8")))
        for path in [*(ROOT / "tests").rglob("*.cmake"), *(ROOT / "tests").rglob("CMakeLists.txt")]:
            cls.tests.update(ADDED.findall(path.read_text(encoding="utf-8")))
        cls.tests.update(f"cli.papers.{name}" for name in paper_pages.PAPERS)  # Of a loop.

    def test_every_status_file_command_and_test_is_there(self):
        programs = {path.stem for path in (ROOT / "apps").glob("*.cpp")} | {"bench_paper_claims", "model_sweeps"}
        for item in self.items:
            where = f"{item['paper']}, {item['item']}"
            self.assertIn(item["paper"], paper_pages.PAPERS, where)
            match = paper_pages.STATUS.fullmatch(item["status"])
            self.assertIsNotNone(match, f"{where}: {item['status']}")
            self.assertFalse(match[1] == "partly" and not match[2], f"{where}: what is missing?")
            self.assertTrue(match[1] == "not made" or item["where"], f"{where}: where is it?")
            if item["where"]:
                self.assertTrue((ROOT / item["where"]).is_file(), f"{where}: {item['where']}")
            if item["test"]:
                self.assertIn(item["test"], self.tests, where)
            if item["command"]:
                program = item["command"].split()[0]
                self.assertTrue(program in programs or (ROOT / program).is_file(), f"{where}: {program}")

    def test_every_numbered_equation_table_and_figure_has_a_row(self):
        for paper, counts in NUMBERED.items():
            for kind, count in zip(("eq.", "table", "figure"), counts):
                rows_of_kind = [item["item"] for item in self.items
                                if item["paper"] == paper and re.match(f"{re.escape(kind)}s? [\\dI]", item["item"])]
                roman = {"I": 1, "II": 2}
                found = {roman[name.split()[1]] if name.split()[1] in roman else n
                         for name in rows_of_kind for n in (words_of(name.split(",")[0]) or [0])}
                self.assertEqual(found, set(range(1, count + 1)), f"{paper}, {kind}")


class StoredPages(unittest.TestCase):
    def test_are_what_the_stored_results_give(self):
        for path, text in paper_pages.pages(ROOT).items():
            self.assertEqual(path.read_text(encoding="utf-8"), text, f"{path} is out of date; run developer/paper-pages")


    def test_say_the_forces_that_the_cases_of_the_presets_hold(self):
        """tests/cli/papers/NAME.txt holds them; whole numbers are counts and depths."""
        for name in paper_pages.PAPERS:
            page = (ROOT / "docs" / "papers" / f"{name}.md").read_text(encoding="utf-8")
            for line in (ROOT / "tests" / "cli" / "papers" / f"{name}.txt").read_text(encoding="utf-8").splitlines():
                what, value = line.rsplit(" ", 1)
                if "." in value and "depth" not in what:
                    self.assertRegex(page, rf"(?<![\d.]){re.escape(value)}(?![\d.])", f"{name}: {what}")


class Work(unittest.TestCase):
    def test_the_word_follows_from_the_parts(self):
        same = {"nodes": ("361", 361), "update": ("whole inverse", "whole inverse")}
        self.assertEqual(work.verdict(same), "the same")
        self.assertEqual(work.verdict(same | {"nodes": (361, 365)}), "the same")
        self.assertEqual(work.verdict(same | {"nodes": (361, 700)}), "more: nodes: 700 for 361")
        self.assertEqual(work.verdict(same | {"nodes": (361, 100)}), "less: nodes: 100 for 361")
        self.assertEqual(work.verdict(same | {"update": ("whole inverse", "rows")}), "other: update: rows for whole inverse")
        self.assertEqual(work.verdict({"nodes": (361, 700), "images": (2, 1)}), "other: nodes: 700 for 361; images: 1 for 2")
        self.assertEqual(work.verdict({"image size": ("not given", "512 x 512")}), "other: image size: 512 x 512, the paper gives none")


if __name__ == "__main__":
    unittest.main()
