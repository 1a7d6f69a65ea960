"""Fields of a sweep over each other as SVG, on logarithmic axes, as templates of pages ask for it."""
import math
import pathlib

import jinja2
from measured import Field
from tables import value_text

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#444444")
INK = "#222222"
WIDTH, HEIGHT, LEFT, RIGHT = 860, 340, 62, 844
LEGEND_TOP, LEGEND_ROW, CHARACTER_WIDTH = 40, 17, 7.2
SHOWN_SHARE = 1e-4  # Of the largest: what is smaller is rounding, and would stretch the axis.
# Of labels, from the densest: the first that has room.
MANTISSAS = ([n / 10 for n in range(10, 100)], (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8), (1, 2, 5), (1,))
TEMPLATES = jinja2.Environment(loader=jinja2.FileSystemLoader(pathlib.Path(__file__).parent), autoescape=True,
                               trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True)


class Axis:
    """Places of values between two pixels, and which values have a line and a label."""

    def __init__(self, label, values, from_px, to_px, max_labels):
        self.label = label
        logs = [math.log10(value) for value in values] or [0.0]
        margin = 0.04 * (max(logs) - min(logs)) or 0.1
        self.low, self.high = min(logs) - margin, max(logs) + margin
        self.from_px, self.to_px = from_px, to_px
        self.lines = self.within(range(1, 10))
        self.labels = next(filter(lambda labels: len(labels) <= max_labels, map(self.within, MANTISSAS)), [])

    def within(self, mantissas):
        decades = range(math.floor(self.low), math.ceil(self.high))
        values = [float(f"{mantissa:g}e{decade}") for decade in decades for mantissa in mantissas]
        return [value for value in values if self.low <= math.log10(value) <= self.high]

    def __call__(self, value):
        share = (math.log10(value) - self.low) / (self.high - self.low)
        return f"{self.from_px + share * (self.to_px - self.from_px):.1f}"


def series_of(sweep, x, y, lines, points):
    """Curves of `lines` by name, a dot for each value of `points`, then what is the default and the papers'."""
    x, y = Field(x), Field(y)
    rows = {knob: [(value, row) for value, row in sweep.settings(knob, y).items() if row and not row["unusable"]]
            for knob in (*lines, *points)}
    errors = [float(y(row)) for settings in rows.values() for _, row in settings]
    least = SHOWN_SHARE * max(filter(math.isfinite, errors), default=0.0)
    series, marks = [], {"default": [], "paper": []}
    for knob, settings in rows.items():
        line = []
        for value, row in settings:
            place = (float(x(row)), float(y(row)))
            if not (0.0 < place[0] < math.inf and least < place[1] < math.inf):
                continue
            mark = next((mark for mark in marks if row[f"is_{mark}"] == "1"), None)
            if knob in points:  # A mark would lie on the dot.
                name = value_text(value) + (f" ({mark})" if mark else "")
                series.append({"name": name, "kind": "points", "places": [place]})
                continue
            line.append(place)
            if mark:
                marks[mark].append(place)
        if line:
            series.append({"name": lines[knob], "kind": "line", "places": line})
    for n, one in enumerate(series):
        one["colour"] = COLOURS[n % len(COLOURS)]
    for (mark, places), kind in zip(marks.items(), ("ring", "square")):
        if places:
            series.append({"name": mark, "kind": kind, "places": places, "colour": INK})
    return series


def place_legend(series):
    """Gives each series a place in rows above the frame; returns where the frame begins."""
    x, y = LEFT, LEGEND_TOP
    for one in series:
        width = 28 + CHARACTER_WIDTH * len(one["name"])
        if x > LEFT and x + width > RIGHT:
            x, y = LEFT, y + LEGEND_ROW
        one["legend"] = (x, y)
        x += round(width) + 14
    return y + 16


def svg(title, sweep, x, y, lines, points):
    """`x` and `y`: field and label; `lines`: names by knob; `points`: knobs whose values have no order."""
    series = series_of(sweep, x[0], y[0], lines, points)
    top = place_legend(series)
    across, up = zip(*(place for one in series for place in one["places"])) if series else ((), ())
    return TEMPLATES.get_template("figure.svg").render(
        title=title, series=series, width=WIDTH, left=LEFT, right=RIGHT, top=top, bottom=top + HEIGHT,
        x=Axis(x[1], across, LEFT, RIGHT, 11), y=Axis(y[1], up, top + HEIGHT, top, 9))
