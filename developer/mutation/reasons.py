"""Why a change stays that no test notices: unnoticed.csv beside this file."""
import collections
import csv
import pathlib

TABLE = pathlib.Path(__file__).resolve().parent / "unnoticed.csv"
COLUMNS = ("file", "text", "before", "after", "kind", "reason")
KINDS = {"same": "change nothing that can be observed", "cost": "would need tests that take too long"}


def read():
    """Rows by file, text of the line, and change."""
    with open(TABLE, newline="", encoding="utf-8") as file:
        return {tuple(row[name] for name in COLUMNS[:4]): row for row in csv.DictReader(file)}


def text_of(row, root):
    """The line of the source that a row of the table of mutants names; nothing if it is gone."""
    path = root / row["file"]
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    number = int(row["line"])
    return lines[number - 1].strip() if number <= len(lines) else ""


def count(rows, root):
    """How many of these unnoticed mutants have a reason, by kind."""
    known = read()
    found = (known.get((row["file"], text_of(row, root), row["before"], row["after"])) for row in rows)
    return collections.Counter(row["kind"] for row in found if row)
