#!/usr/bin/env python3
"""Tables of the pages of the papers: rows of a template (NAME.toml), filled with the facts of a run.

    rows.py TEMPLATE FACTS TABLE [--markdown] [--csv FILE]     a table on standard output
    rows.py TEMPLATE FACTS --caption KEY                       one caption; load: how busy the machine was

FACTS has a line KEY,VALUE for each fact that the run measured or that it was set to. In a template `{...}` is an
expression of these and of FUNCTIONS: outside of it there is no number of ours and no word that compares, as the test
docs.paper_rows checks. A row with `holds` that does not hold, or with a fact that was not measured,
makes no page.

A row: quantity, paper (what it says), acus, on (which run), why (where they differ); or, in place of `why`, a table
`work`: what each does, from which work.py says whether it is the same.
"""
import argparse
import csv
import html
import math
import pathlib
import re
import sys
import tomllib

import work

EXPRESSION = re.compile(r"\{([^{}]+)\}")
COLUMNS = ("quantity", "paper", "acus", "on", "why")
TITLES = ("quantity", "the paper", "Acus", "on what", "where they differ, and why")


# Of every page.
LOAD = ("{pick(quick > 0, 'Of a run with --quick: not for print. ', '')}Other programs used {others_percent} % of the machine's {cores} cores "
        "while these numbers were made{pick(others_percent > 10, '; times are CPU times, but caches and memory were shared: they may be "
        "longer than on an idle machine', '')}. Forces, distances and memory of replays do not depend on it.")


class RowError(Exception):
    pass


class Facts(dict):
    """By key, numbers where they are numbers. `used` collects what was read."""

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.used = set()

    def __getitem__(self, key):
        self.used.add(key)
        if key not in self:
            raise RowError(f"the fact '{key}' was not measured")
        return super().__getitem__(key)


def number_or_text(text):
    try:
        value = float(text)
    except ValueError:
        return text
    return value if math.isfinite(value) else text


def read_facts(path):
    with open(path, encoding="utf-8", newline="") as file:
        return Facts((row[0], number_or_text(row[1])) for row in csv.reader(file) if len(row) == 2)


def shown(value):
    """At most three significant digits; whole numbers from 1000 on."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return str(value)
    if not math.isfinite(value):
        raise RowError("a number was not measured")
    if value == int(value) and abs(value) < 1e6:
        return f"{int(value)}"
    return f"{value:.0f}" if abs(value) >= 1000 else f"{value:.3g}" if abs(value) >= 1e-4 else "0"


def pick(condition, yes, no):
    return yes if condition else no


def word(ours, paper, more, less, same, tolerance=0.1):
    """`same` within the tolerance of the paper's number."""
    if abs(ours - paper) <= tolerance * abs(paper):
        return same
    return more if ours > paper else less


FUNCTIONS = {"pick": pick, "word": word, "abs": abs, "min": min, "max": max, "round": round,
             "per_s": lambda milliseconds: 1000 / milliseconds, "fixed": lambda value, digits: f"{value:.{int(digits)}f}"}


def fill(text, facts):
    def value_of(match):
        try:
            return shown(eval(match[1], {"__builtins__": {}}, Scope(facts)))  # pylint: disable=eval-used
        except RowError:
            raise
        except Exception as error:  # A template's mistake, or a fact of the wrong kind.
            raise RowError(f"{{{match[1]}}}: {error}") from error
    return EXPRESSION.sub(value_of, text)


class Scope(dict):
    """Facts and functions as names of an expression."""

    def __init__(self, facts):
        super().__init__()
        self.facts = facts

    def __missing__(self, name):
        return FUNCTIONS[name] if name in FUNCTIONS else self.facts[name]


def each(row, template):
    """A row with `each`, a list of tables of words or the template's name of one, is one for each: <word> stands for its text."""
    def put(value, words):
        if isinstance(value, str):
            return re.sub(r"<(\w+)>", lambda match: words[match[1]], value)
        if isinstance(value, list):
            return [put(item, words) for item in value]
        return {key: put(item, words) for key, item in value.items()}
    rest = {key: value for key, value in row.items() if key != "each"}
    lists = row.get("each")
    return [row] if lists is None else [put(rest, words) for words in (template[lists] if isinstance(lists, str) else lists)]


def read_template(path):
    with open(path, "rb") as file:
        template = tomllib.load(file)
    for name, table_rows in template.get("table", {}).items():
        template["table"][name] = [one for row in table_rows for one in each(row, template)]
    return template


def load_of(facts):
    """What else the machine did while the facts were made."""
    return fill(LOAD, facts) if "others_percent" in facts else "How busy the machine was is not recorded: times may be longer than on an idle one."


def filled_row(row, facts):
    """Its five columns."""
    for claim in row.get("holds", []):
        if fill("{pick(" + claim + ", 'yes', 'no')}", facts) != "yes":
            raise RowError(f"what the row '{row['quantity']}' says does not hold: {claim}")
    columns = [fill(row.get(column, ""), facts) for column in COLUMNS]
    if "work" in row:
        parts = {what: [fill(str(side), facts) for side in sides] for what, sides in row["work"].items()}
        columns[4] = f"work: {work.verdict(parts)}" + (f". {columns[4]}" if columns[4] else "")
    return columns


def table(template, facts, name):
    """Rows of columns. A row whose fact `if` is not there is omitted."""
    if name not in template.get("table", {}):
        raise RowError(f"there is no table '{name}'")
    return [filled_row(row, facts) for row in template["table"][name] if row.get("if", "") in ("", *facts)]


def as_html(rows):
    head = "".join(f"<th>{title}</th>" for title in TITLES)
    lines = [f"<table><tr>{head}</tr>"]
    for row in rows:
        cells = [html.escape(cell, quote=False) for cell in row]
        cells[2] = f"<b>{cells[2]}</b>"
        lines.append("<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>")
    return "\n".join([*lines, "</table>"]) + "\n"


def as_markdown(rows):
    lines = ["| " + " | ".join(TITLES) + " |", "|---" * len(TITLES) + "|"]
    lines += ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows]
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("template", type=pathlib.Path)
    parser.add_argument("facts", type=pathlib.Path)
    parser.add_argument("table", nargs="?")
    parser.add_argument("--markdown", action="store_true")
    parser.add_argument("--csv", type=pathlib.Path)
    parser.add_argument("--caption")
    arguments = parser.parse_args()
    try:
        template, facts = read_template(arguments.template), read_facts(arguments.facts)
        if arguments.caption:
            sys.stdout.write(load_of(facts) if arguments.caption == "load" else fill(template["caption"][arguments.caption], facts))
            return
        rows = table(template, facts, arguments.table)
    except (OSError, KeyError, tomllib.TOMLDecodeError, RowError) as error:
        sys.exit(f"{arguments.template}: {error}")
    if arguments.csv:
        with open(arguments.csv, "a", encoding="utf-8", newline="") as file:
            csv.writer(file).writerows(row[:3] for row in rows)
    sys.stdout.write(as_markdown(rows) if arguments.markdown else as_html(rows))


if __name__ == "__main__":
    main()
