"""docs/accuracy-and-time.md, docs/papers-claims.md and their figures are what docs/templates and docs/data give;
and what a template may ask for."""
import contextlib
import io
import json
import os
import pathlib
import random
import re
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

ROOT = pathlib.Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
COMMAND = ROOT / "developer" / "accuracy_pages" / "command.py"
sys.dont_write_bytecode = True
sys.path.insert(0, str(COMMAND.parent))

import command  # noqa: E402
from files import UserError  # noqa: E402
from page import make_pages  # noqa: E402

HEADER = ("knob,value,model,error,error_unit,reference,step_us_median,step_us_p999,preparation_s,memory_mb,"
          "is_default,is_paper,unusable\n")


def row(knob, value, error, unit, step_us, is_default=0, is_paper=0, unusable=""):
    return f"{knob},{value},,{error},{unit},,{step_us},,,,{is_default},{is_paper},{unusable}\n"


# Errors that fall with the square of the size, in two units; one value that must not be used.
TISSUE = HEADER + "".join(
    row("size_mm", size, 0.1 * size * size, "N", 12 / size, is_default=int(size == 2))
    + row("size_mm", size, 3 * size, "%", 12 / size, is_default=int(size == 2)) for size in (4, 2, 1)
) + row("model", "2D; coarse", 0.7, "N", 1, is_paper=1) + row("model", "wild", 1e9, "N", 0.5, unusable="diverged")


class WithTemplates(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name).resolve()
        self.write("data/tissue.csv", TISSUE)
        self.write("data/machine.json", '{"cpu": "Abacus 9", "cores": 2, "lost": null}')
        self.write("templates/notes.txt", "{{")

    def write(self, name, text):
        path = self.folder / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return path

    def pages(self, template, strict=True):
        self.write("templates/one.template", template)
        return make_pages(self.folder / "templates", self.folder / "data", strict)

    def text(self, template, strict=True):
        return self.pages(template, strict)["one.md"]

    def refused(self, template, strict=True):
        """The lines of the message without the folder of templates."""
        with self.assertRaises(UserError) as caught:
            self.text(template, strict)
        return str(caught.exception).replace(f"{self.folder}/templates/", "").splitlines()[1:]


class StoredPages(WithTemplates):
    def test_are_what_the_stored_results_give(self):
        files = make_pages(DOCS / "templates", DOCS / "data", strict=True)
        self.assertGreater(len(files), 5)
        for name, text in files.items():
            is_same = (DOCS / name).is_file() and (DOCS / name).read_text(encoding="utf-8") == text
            self.assertTrue(is_same, f"docs/{name} is out of date; run developer/accuracy-and-time --from-stored")

    def test_are_the_same_twice(self):
        made = []
        for seed in ("1", "2"):
            folder = self.folder / seed
            subprocess.run([sys.executable, COMMAND, "--data", DOCS / "data", "-o", folder, "--strict"], check=True,
                           env=os.environ | {"PYTHONHASHSEED": seed})
            made.append({str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*.*")})
        self.assertGreater(len(made[0]), 5)
        self.assertEqual(*made)

    def test_are_made_of_a_few_settings_too(self):
        """A quick run has fewer settings: where text and tables miss them they say so."""
        for path in (DOCS / "data").glob("*.*"):
            lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
            knobs = [line.split(",")[0] for line in lines]
            kept = [line for n, line in enumerate(lines) if n == 0 or knobs[n] != knobs[n - 1]]
            self.write(f"data/{path.name}", "".join(lines if path.suffix == ".json" else kept))
        page = make_pages(DOCS / "templates", self.folder / "data", strict=False)["accuracy-and-time.md"]
        self.assertIn("**(not measured in this run)**", page)
        with self.assertRaises(UserError):
            make_pages(DOCS / "templates", self.folder / "data", strict=True)


class PapersClaims(WithTemplates):
    def test_every_measured_number_changes_the_page_or_fails(self):
        self.write("templates/one.template", (DOCS / "templates" / "papers-claims.template").read_text(encoding="utf-8"))
        for path in (DOCS / "data").glob("*.*"):
            self.write(f"data/{path.name}", path.read_text(encoding="utf-8"))
        claims = json.loads((DOCS / "data" / "claims.json").read_text(encoding="utf-8"))
        before = make_pages(self.folder / "templates", self.folder / "data", strict=True)["one.md"]
        numbers = random.Random(44)
        unseen = []
        for key, value in claims.items():
            other = value * (numbers.uniform(0.2, 0.8) if numbers.random() < 0.5 else numbers.uniform(1.3, 5))
            self.write("data/claims.json", json.dumps(claims | {key: other}))
            try:
                if make_pages(self.folder / "templates", self.folder / "data", strict=True)["one.md"] == before:
                    unseen.append(key)
            except UserError:
                pass
        # The restricted update of the smaller plane, and sizes between those of the table, are not on the page.
        self.assertEqual([key for key in unseen if not re.match("swap_361_restricted|fe_[36]mm_", key)], [])

    def test_work_and_words_follow_from_numbers(self):
        self.write("data/claims.json", '{"nodes": 700, "ms": 20}')
        self.assertEqual(self.text('{{ work({"nodes": [361, claims.nodes]}) }}'), "more: nodes: 700 for 361")
        self.assertEqual(self.text('{{ work({"nodes": [710, claims.nodes]}) }}'), "the same")
        self.assertEqual(self.text("{{ word(claims.ms, 16) }}, {{ word(claims.ms, 20) }}, {{ word(claims.ms, 36) }}"),
                         "**slower**, as fast, faster")


class Templates(WithTemplates):
    def test_are_filled_with_numbers_and_facts(self):
        self.assertEqual(self.text("On {{ machine.cpu }}, {{ machine.cores }} cores: "
                                   "{{ tissue('size_mm', 'default', 'error N') }} N,\n"
                                   "{{ require(0.3 < tissue('size_mm', 2, 'error N') < 0.5) -}}\n"
                                   "{{ (1000 / 3) | digits(4) }} of {{ 1234.5 }}"
                                   "{{ require(machine.cores >= 2 and machine.cores <= 2) }}.\n"),
                         "On Abacus 9, 2 cores: 0.4 N,\n333.3 of 1234.\n")

    def test_compute(self):
        for expression, value in (("-2 * -machine.cores / 8", "0.5"),
                                  ("1 - (machine.cores + 1) / machine.cores", "-0.5"),
                                  ("1000 / tissue('size_mm', 1, 'step_us_median')", "83"),
                                  ("max(tissue.all('size_mm', 'step_us_median'), 5)", "12"),
                                  ("min(tissue.all('size_mm', 'error %'))", "3"),
                                  ("log(tissue('size_mm', 4, 'error N') / tissue('size_mm', 1, 'error N')) / log(4)",
                                   "2"),
                                  ("tissue('model', 'paper', 'error N')", "0.7"),
                                  ("tissue('model', '2D, coarse', 'error N')", "0.7"),
                                  ("tissue('size_mm', 4, '10 * value')", "40"),
                                  ("max(tissue.all('model', 'error N'))", "0.7")):  # Not what must not be used.
            self.assertEqual(self.text("{{ " + expression + " }}"), value, expression)

    def test_of_another_run_say_where_it_is_not_so(self):
        self.assertEqual(self.text("Small{{ require(tissue('size_mm', 2, 'error N') < 0.3) }} and "
                                   "{{ tissue('size_mm', 8, 'error N') }}.{{ require(machine.lost < 1) }}\n"
                                   "{{ require(tissue('size_mm', 2, 'error N') > 0.5) -}}\nSo.\n", strict=False),
                         "Small **(not so in this run: 0.4 < 0.3)**  and –. **(not measured in this run)** \n"
                         " **(not so in this run: 0.4 > 0.5)** So.\n")

    def test_what_was_not_measured_is_no_number(self):
        for expression in ("machine.lost", "machine.never", "1 + tissue('size_mm', 8, 'error N')",
                           "max(tissue('size_mm', 8, 'error N'), 2)", "max(tissue.all('size_mm', 'memory_mb'))",
                           "tissue('size_mm', 4, 'preparation_s')", "1 / (machine.cores - 2)", "log(0 * machine.cores)",
                           "tissue('model', 'wild', 'value')"):
            self.assertEqual(self.text("{{ " + expression + " }}", strict=False), "–", expression)
            self.assertEqual(self.text("{{ require(" + expression + " < 1) }}", strict=False),
                             " **(not measured in this run)** ", expression)
            self.assertEqual(self.refused("{{ " + expression + " }}"),
                             ["one.template:1: a number was not measured"], expression)

    def test_are_refused_when_claims_do_not_hold_with_every_line(self):
        self.write("templates/two.template", "\n\n{{ require(machine.cores < 1) }}\n")
        self.assertEqual(self.refused("One.\n{{ require(tissue('size_mm', 2, 'error N') < 0.3) -}}\n"
                                      "{{ require(0.3 < tissue('size_mm', 2, 'error N')) -}}\n"
                                      "It is {{ tissue('size_mm', 8, 'error N') }}\nof {{ machine.cores }} and "
                                      "{{ machine.lost | digits(3) }}.{{ require(1 < machine.lost < 2) }}\n"),
                         ["one.template:2: what the text says no longer holds: 0.4 < 0.3",
                          "one.template:4: a number was not measured", "one.template:5: a number was not measured",
                          "one.template:5: what the text says was not measured",
                          "two.template:3: what the text says no longer holds: 2 < 1"])

    def test_that_are_broken_are_refused_with_the_line(self):
        for line, wrong in (("{{ 1 +", "unexpected 'end of template'"), ("{{ 1 + }}", "unexpected"),
                            ("{{ median(1) }}", "'median' is undefined"), ("{{ nothing.cores }}", "undefined"),
                            ("{{ tissue('size', 1, 'error N') }}", "sweep tissue has no knob 'size'"),
                            ("{{ tissue('size_mm', 1, 'speed') }}", "no field of a row; there are: error UNIT, step"),
                            ("{{ tissue('size_mm', 1, 'error') }}", "'error' is no field"),
                            ("{{ tissue.all('size_mm', 'x * error N') }}", "'x"),
                            ("{{ machine.cores < 3 }}", "write require"), ("{{ require(2) }}", "needs a comparison"),
                            ("{{ table(tissue, knobs={'model': 'model'}) }}", "columns"),
                            ("{{ machine.cpu + 1 }}", "str"), ("{{ machine.cores + machine.cpu }}", "Abacus")):
            for strict in (True, False):
                problems = self.refused("One.\nTwo.\n" + line, strict)
                self.assertEqual(len(problems), 1, line)
                self.assertTrue(problems[0].startswith("one.template:3: "), problems)
                self.assertIn(wrong, problems[0])

    def test_say_which_of_several_defaults(self):
        self.write("data/tissue.csv", TISSUE + row("size_mm", 8, 6, "N", 2, is_default=1))
        self.assertEqual(self.refused("{{ tissue('size_mm', 'default', 'error N') }}"),
                         ["one.template:1: the sweep tissue has several rows of 'size_mm' that are default: say which"])

    def test_for_elsewhere_link_to_nothing(self):
        text = "See [that page](models/that.md#part), [here](#here).\n"
        self.assertEqual(self.text(text, strict=False), "See that page, [here](#here).\n")
        self.assertEqual(self.text(text), text)


class Tables(WithTemplates):
    def test_show_settings_below_each_other(self):
        self.assertEqual(self.text("{{ table(tissue, knobs={'size_mm': 'size, mm'}, columns={'mN': '1000 * error N', "
                                   "'%': 'error %', 's': 'preparation_s'}) }}\n\n"),
                         "| size, mm | mN | % | s |\n|---|---|---|---|\n"
                         "| 4 | 1600 | 12 | – |\n| **2** | 400 | 6 | – |\n| 1 | 100 | 3 | – |\n\n")
        self.assertEqual(self.text("{{ table(tissue, knobs={'size_mm': 'size', 'model': 'model'}, "
                                   "columns={'%': 'error %', 'N': '1e-12 * error N'}) }}"),
                         "| knob | value | % | N |\n|---|---|---|---|\n| size | 4 | 12 | 0 |\n"
                         "| size | **2** | 6 | 0 |\n| size | 1 | 3 | 0 |\n| model | 2D, coarse (paper) |  | 0 |\n"
                         "| model | wild (unusable) |  | 0.001 |")

    def test_have_no_bars_in_cells(self):
        self.write("data/tissue.csv", TISSUE + row("side", "|left|", 1, "N", 1))
        self.assertEqual(self.text("{{ table(tissue, knobs={'side': 'side'}, columns={'N': 'error N'}) }}"),
                         "| side | N |\n|---|---|\n| /left/ | 1 |")

    def test_show_values_side_by_side(self):
        self.assertEqual(self.text("{{ pivot(tissue, 'N', at={'4': '4 mm', '1': '1'}, rows={'size_mm': 'size'}, "
                                   "cells=['error N', 'error %'], columns={'us': ('step_us_median', '2')}) }}"),
                         "| N | 4 mm | 1 | us |\n|---|---|---|---|\n| size | 1.6 / 12 | 0.1 / 3 | 6 |")
        self.assertEqual(self.text("{{ pivot(tissue, '', at={'wild': 'wild', '7': '7'}, rows={'model': 'model'}, "
                                   "cells=['error N', 'error N'], unusable='diverges') }}"),
                         "|  | wild | 7 |\n|---|---|---|\n| model | diverges | – / – |")

    def test_are_drawn(self):
        files = self.pages("{{ figure('f', 'Costs & more', tissue, x=('step_us_median', 'us'), y=('error N', 'N'), "
                           "lines={'size_mm': 'size'}, points=['model']) }}")
        self.assertEqual(files["one.md"], "![Costs & more](figures/f.svg)")
        svg = xml.etree.ElementTree.fromstring(files["figures/f.svg"])
        texts = [element.text for element in svg.iter() if element.tag.endswith("}text")]
        for text in ("Costs & more", "size", "2D, coarse (paper)", "default", "us", "N", "10"):
            self.assertIn(text, texts)
        self.assertNotIn("wild", texts)  # It must not be used.
        line, = (element for element in svg.iter() if element.tag.endswith("}polyline"))
        places = [tuple(map(float, place.split(","))) for place in line.get("points").split()]
        self.assertEqual(len(places), 3)
        # Four times the error in each step, for twice the time: level distances on logarithmic axes, y down.
        (x4, y4), (x2, y2), (x1, y1) = places
        self.assertAlmostEqual(x2 - x4, x1 - x2, delta=0.2)
        self.assertAlmostEqual(y2 - y4, y1 - y2, delta=0.2)
        self.assertTrue(62 < x4 < x2 < x1 < 844 and y4 < y2 < y1, places)


class Results(WithTemplates):
    def test_that_cannot_be_read_are_named(self):
        for text, wrong in (("knob,value\n1,2\n", "tissue.csv, line 2: there is no column 'error'"),
                            (HEADER + row("a", 1, "much", "N", 2), "line 2, column error: 'much' is not a number"),
                            (HEADER + row("a", 1, "inf", "N", 2), "line 2, column error: 'inf' is not a number")):
            self.write("data/tissue.csv", text)
            with self.assertRaisesRegex(UserError, wrong):
                self.pages("")
        self.write("data/tissue.csv", TISSUE)
        self.write("data/machine.json", "{")
        with self.assertRaisesRegex(UserError, "machine.json: no readable JSON"):
            self.pages("")

    def test_and_templates_must_be_there(self):
        with self.assertRaisesRegex(UserError, "nowhere: there is no table of a sweep; run developer/accuracy"):
            make_pages(DOCS / "templates", self.folder / "nowhere", strict=True)
        with self.assertRaisesRegex(UserError, "there is no .*template"):
            make_pages(self.folder / "templates", self.folder / "data", strict=True)


class Command(WithTemplates):
    def call(self, template, *options):
        self.write("templates/one.template", template)
        errors = io.StringIO()
        with contextlib.redirect_stderr(errors):
            code = command.main(["--templates", f"{self.folder}/templates", "--data", f"{self.folder}/data",
                                 "-o", f"{self.folder}/out", *options])
        return code, errors.getvalue()

    def test_writes_all_pages_or_none(self):
        figure = "{{ figure('f', 'T', tissue, x=('value', 'x'), y=('error N', 'y'), lines={'size_mm': 'size'}) }}"
        self.assertEqual(self.call("Before. " + figure, "--strict"), (0, ""))
        before = {path: path.read_text() for path in (self.folder / "out").rglob("*.*")}
        self.assertEqual(len(before), 2)
        code, errors = self.call("After. " + figure + "\n{{ require(machine.cores > 2) }}", "--strict")
        self.assertEqual(code, 3)
        self.assertIn("one.template:2: what the text says no longer holds: 2 > 2", errors)
        self.assertEqual({path: path.read_text() for path in (self.folder / "out").rglob("*.*")}, before)
        self.assertEqual(self.call("After.\n{{ require(machine.cores > 2) }}"), (0, ""))
        self.assertIn("After.\n **(not so in this run: 2 > 2)** ", (self.folder / "out/one.md").read_text())


if __name__ == "__main__":
    unittest.main()
