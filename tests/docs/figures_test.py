"""The images of README and docs/ are those of their sources: docs/figures/figures.toml, docs/figures/figures.csv."""
import pathlib
import re
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path.append(str(ROOT / "developer"))

import figure_record  # noqa: E402

SHOWN = re.compile(r"figures/([\w.-]+\.(?:png|svg))")


class Figures(unittest.TestCase):
    def test_none_is_stale(self):
        self.assertEqual(figure_record.stale(), {},
                         "developer/figures --stale makes these again (developer/figures --same NAME: they were looked at and "
                         "still are what would be made)")

    def test_each_has_one_maker_and_a_page(self):
        made = [figure for group in figure_record.groups().values() for figure in group["makes"]]
        self.assertEqual(len(made), len(set(made)), "a figure is made twice")
        there = {path.name for path in (ROOT / "docs" / "figures").iterdir() if path.suffix in (".png", ".svg")}
        self.assertEqual(there, set(made))
        shown = set()
        for path in [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]:
            shown.update(SHOWN.findall(path.read_text(encoding="utf-8")))
        self.assertEqual(shown, there)

    def test_each_group_has_a_command(self):
        makers = (ROOT / "developer" / "figure_makers.sh").read_text(encoding="utf-8")
        for name in figure_record.groups():
            self.assertIn(f"\nmake_{name}() {{", makers)


class Digest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.root = pathlib.Path(self.folder.name)
        for name, text in {"docs/figures/figures.toml": '[a]\nmakes = ["a.svg"]\nof = ["p.json"]\ncode = ["lib"]\n',
                           "docs/figures/a.svg": "<svg/>", "p.json": '// A preset.\n{"x": 1, "description": "one"}',
                           "lib/m.cpp": 'int f() { return 1; }  // One.\nconst char* s = "a // b";\n'}.items():
            (self.root / name).parent.mkdir(parents=True, exist_ok=True)
            (self.root / name).write_text(text, encoding="utf-8")
        figure_record.stamp(["a"], self.root)

    def change(self, name, text):
        (self.root / name).write_text(text, encoding="utf-8")
        return figure_record.stale(self.root)

    def test_what_changes_no_figure_makes_none_stale(self):
        self.assertEqual(figure_record.stale(self.root), {})
        self.assertEqual(self.change("lib/m.cpp", '/* One. */ int f() {\n  return 1;\n}\nconst char* s = "a // b";\n'), {})
        self.assertEqual(self.change("p.json", '{"description": "two",\n "x": 1}'), {})

    def test_what_can_change_a_figure_makes_it_stale(self):
        self.assertEqual(self.change("p.json", '{"x": 2}'), {"a": "its sources changed"})
        self.assertEqual(self.change("p.json", '{"x": 1}'), {})
        self.assertIn("a", self.change("lib/m.cpp", 'int f() { return 2; }\nconst char* s = "a // b";\n'))
        self.assertIn("a", self.change("lib/m.cpp", 'int f() { return 1; }\nconst char* s = "a // c";\n'))

    def test_a_new_file_a_lost_one_and_an_image_from_elsewhere(self):
        self.assertIn("recorded", self.change("docs/figures/a.svg", "<svg></svg>")["a"])
        self.change("docs/figures/a.svg", "<svg/>")
        self.assertIn("a", self.change("lib/n.cpp", "int g();"))
        (self.root / "p.json").unlink()
        with self.assertRaisesRegex(figure_record.FigureError, "p.json is not there"):
            figure_record.stale(self.root)


if __name__ == "__main__":
    unittest.main()
