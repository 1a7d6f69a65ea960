"""What pages about measurements are made from: rows of sweeps and single facts, and how templates compute
with them."""
import csv
import json
import math
import operator
import pathlib

from files import UserError

NUMBERS = ("error", "step_us_median", "step_us_p999", "preparation_s", "memory_mb")
TEXTS = ("knob", "value", "error_unit", "is_default", "is_paper", "unusable")
COMPARISONS = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}


def rounded(value, digits=2):
    """At most so many significant digits, but all of those before the point; a dash for what was not measured."""
    if not math.isfinite(value):
        return "–"
    return f"{value:.0f}" if 10**digits <= abs(value) < 1e9 else f"{value:.{digits}g}"


class Claim:
    """A comparison of numbers, which is true if it holds; it knows what it compared, and whether both were measured."""

    def __init__(self, left, sign, right):
        self.holds = COMPARISONS[sign](float(left), float(right))
        self.measured = math.isfinite(left) and math.isfinite(right)
        self.text = f"{rounded(left, 3)} {sign} {rounded(right, 3)}"

    def __bool__(self):
        return self.holds


class Number(float):
    """A measured number; not a number where nothing was measured. What is computed from numbers is one, too."""

    def __neg__(self):
        return Number(-float(self))

    def __truediv__(self, other):
        return Number(float(self) / float(other) if other else math.nan)

    def __rtruediv__(self, other):
        return Number(other) / self

    def __lt__(self, other):
        return Claim(self, "<", other)

    def __le__(self, other):
        return Claim(self, "<=", other)

    def __gt__(self, other):
        return Claim(self, ">", other)

    def __ge__(self, other):
        return Claim(self, ">=", other)


for _name in ("__add__", "__radd__", "__sub__", "__rsub__", "__mul__", "__rmul__"):
    setattr(Number, _name, lambda a, b, of=getattr(float, _name): Number(of(float(a), float(b))))

NOT_MEASURED = Number(math.nan)


def number_of(text):
    try:
        return Number(text)
    except ValueError:
        return NOT_MEASURED


class Field:
    """One number of a row by its name: "error N" (of rows whose error_unit is N), another column of numbers, or
    "value" where that is a number; with a factor before it: "1000 * error N"."""

    def __init__(self, text):
        factor, _, name = text.rpartition(" * ")
        self.factor = Number(factor or 1)
        self.column, _, self.unit = name.partition(" ")
        if self.column not in (*NUMBERS, "value") or bool(self.unit) != (self.column == "error"):
            raise UserError(f"'{name}' is no field of a row; there are: error UNIT, {', '.join(NUMBERS[1:])}, value")

    def __call__(self, row):
        return self.factor * (number_of(row["value"]) if self.column == "value" else row[self.column])


class Sweep:
    """The rows of one sweep. Templates call it for one number: tissue("element_size_mm", 4, "error N"); the value
    may be "default" or "paper"."""

    def __init__(self, name, rows):
        self.name, self.rows = name, rows

    def settings(self, knob, field):
        """Of each value of a knob the first row that has the field, or None: rows of errors in several units repeat
        the rest."""
        settings = {}
        for row in self.rows:
            if row["knob"] == knob and not settings.get(row["value"]):
                settings[row["value"]] = row if field.unit in ("", row["error_unit"]) else None
        if not settings:
            raise UserError(f"the sweep {self.name} has no knob '{knob}'")
        return settings

    def __call__(self, knob, value, name):
        field = Field(name)
        settings = self.settings(knob, field)
        if value in ("default", "paper"):
            found = [row for row in settings.values() if row and row[f"is_{value}"] == "1"]
        else:
            found = [settings[str(value)]] if settings.get(str(value)) else []
        if len(found) > 1:
            raise UserError(f"the sweep {self.name} has several rows of '{knob}' that are {value}: say which")
        return field(found[0]) if found else NOT_MEASURED

    def all(self, knob, name):
        """The numbers of all values that may be used."""
        field = Field(name)
        rows = [row for row in self.settings(knob, field).values() if row and not row["unusable"]]
        return [number for number in map(field, rows) if math.isfinite(number)]


class Facts(dict):
    """Numbers and texts by key; what is not there was not measured."""

    def __missing__(self, key):
        return NOT_MEASURED


def read_sweep(path):
    """A table as model_sweeps writes it."""
    with open(path, encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    for line, row in enumerate(rows, 2):
        for column in (*NUMBERS, *TEXTS):
            if row.get(column) is None:
                raise UserError(f"{path}, line {line}: there is no column '{column}'")
        for column in NUMBERS:
            number = number_of(row[column])
            if row[column] and not math.isfinite(number):
                raise UserError(f"{path}, line {line}, column {column}: '{row[column]}' is not a number")
            row[column] = number
        for column in TEXTS:  # Where a text has a comma, its cell has a semicolon.
            row[column] = row[column].replace(";", ",")
    return Sweep(path.stem, rows)


def read_facts(path):
    try:
        facts = json.loads(path.read_text(encoding="utf-8"), parse_float=Number, parse_int=Number)
    except ValueError as error:
        raise UserError(f"{path}: no readable JSON: {error}") from error
    return Facts((key, value) for key, value in facts.items() if value is not None)


def read_folder(folder):
    """By name, every NAME.csv of a folder as a sweep and every NAME.json as facts."""
    folder = pathlib.Path(folder)
    measured = {path.stem: read_sweep(path) for path in sorted(folder.glob("*.csv"))}
    if not measured:
        raise UserError(f"{folder}: there is no table of a sweep; run developer/accuracy-and-time")
    return measured | {path.stem: read_facts(path) for path in sorted(folder.glob("*.json"))}


def _of_all(function):
    """`function` of numbers and lists of numbers; not measured if one of them was not."""
    def of(*values):
        numbers = [number for value in values for number in (value if isinstance(value, list) else [value])]
        if any(value == [] for value in values) or not all(map(math.isfinite, numbers)):
            return NOT_MEASURED
        return Number(function(map(float, numbers)))
    return of


FUNCTIONS = {"min": _of_all(min), "max": _of_all(max),
             "log": lambda x: Number(math.log(x)) if float(x) > 0 else NOT_MEASURED}
