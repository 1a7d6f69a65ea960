"""What the pages of the models cite is there: files, tests, and equations of the papers."""
import csv
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
MODELS = sorted((ROOT / "docs" / "models").glob("*.md"))
TEST = re.compile(r"TEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\)")
CODE = re.compile(r"`([^`\n]+)`")
FILE = re.compile(r"(?:lib|tests|configs|docs|pipelines|developer|apps)/[\w./*-]+")
CASE = re.compile(r"([A-Z]\w+)\.([A-Z]\w+|\*)")
EQUATION = re.compile(r"(?:(Augmented|Vidal|Alamilla|Fortmeier)-\d{4}\W*(?:section [\d.]+, )?)?\b[Ee]q\. (\d+)(?:( to |-)(\d+)|((?:, \d+| and \d+)*))")
PAPERS = {"Augmented": "augmented_2010", "Vidal": "vidal_2008", "Alamilla": "alamilla_2021", "Fortmeier": "fortmeier_2016"}
# The paper that a page without its name beside the equation is about.
PAGES = {"breathing": "fortmeier_2016", "forces_alamilla": "alamilla_2021", "forces_vidal": "vidal_2008", "force_fit": "fortmeier_2016",
         "needle_forces": "alamilla_2021", "needle_rod": "fortmeier_2016", "needle_shape": "fortmeier_2016",
         "tissue_functions_and_springs": "fortmeier_2016", "volume_rendering": "fortmeier_2016"}
# Links whose text is an equation of another page's paper.
LINKED = re.compile(r"\[(?:[\w-]+ )?[Ee]q\. [\d to]+\]\((\w+)\.md[^)]*\)")


def cited_equations(text, page):
    """(paper, number) of a page."""
    of_link = {match.start(): PAGES.get(match[1], page) for match in LINKED.finditer(text)}
    for match in EQUATION.finditer(text):
        linked = next((paper for start, paper in of_link.items() if 0 <= match.start() - start <= 2), None)
        paper = PAPERS[match[1]] if match[1] else linked or PAGES.get(page)
        last = int(match[4]) if match[4] else int(match[2])
        numbers = [*range(int(match[2]), last + 1), *map(int, re.findall(r"\d+", match[5] or ""))]
        yield from ((paper, number, match[0]) for number in numbers)


class Citations(unittest.TestCase):
    def test_every_cited_file_is_there(self):
        count = 0
        for path in MODELS:
            for code in CODE.findall(path.read_text(encoding="utf-8")):
                if FILE.fullmatch(code):
                    self.assertTrue(list(ROOT.glob(code.rstrip("/"))), f"{path.name}: {code}")
                    count += 1
        self.assertGreater(count, 100)

    def test_every_cited_test_is_there(self):
        tests = {match for path in (ROOT / "tests").rglob("*.cpp") for match in TEST.findall(path.read_text(encoding="utf-8"))}
        suites = {suite for suite, _ in tests}
        count = 0
        for path in MODELS:
            for code in CODE.findall(path.read_text(encoding="utf-8")):
                match = CASE.fullmatch(code)
                if match:
                    self.assertTrue((match[1], match[2]) in tests or (match[2] == "*" and match[1] in suites), f"{path.name}: {code}")
                    count += 1
        self.assertGreater(count, 150)

    def test_every_cited_equation_has_a_row_that_is_made(self):
        with open(ROOT / "docs" / "data" / "papers" / "items.psv", encoding="utf-8", newline="") as file:
            items = list(csv.DictReader(file, delimiter="|", quoting=csv.QUOTE_NONE))
        made = {(item["paper"], int(number)) for item in items if not item["status"].startswith("not made")
                for number in re.findall(r"^eq\. (\d+)", item["item"])}
        count = 0
        for path in MODELS:
            for paper, number, text in cited_equations(path.read_text(encoding="utf-8"), path.stem):
                self.assertIsNotNone(paper, f"{path.name}: '{text}': of which paper?")
                self.assertIn((paper, number), made, f"{path.name}: '{text}'")
                count += 1
        self.assertGreater(count, 80)

    def test_what_is_not_there_is_seen(self):
        self.assertEqual([(paper, number) for paper, number, _ in cited_equations("eq. 4 to 6 and Vidal-2008 eq. 9, 10", "breathing")],
                         [("fortmeier_2016", 4), ("fortmeier_2016", 5), ("fortmeier_2016", 6), ("vidal_2008", 9), ("vidal_2008", 10)])
        self.assertEqual([paper for paper, _, _ in cited_equations("([eq. 8](forces_vidal.md), block)", "needle_forces")], ["vidal_2008"])
        self.assertEqual([paper for paper, _, _ in cited_equations("eq. 1", "fluoroscopy")], [None])


if __name__ == "__main__":
    unittest.main()
