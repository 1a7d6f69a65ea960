"""Rows of sweeps as tables of Markdown, as templates of pages ask for them."""
from measured import Field, rounded


def cell(number):
    """Two significant digits; 0 for what is rounding; a dash if not measured."""
    return "0" if abs(number) < 1e-9 else rounded(number)


def value_text(value):
    """A '|' would make a cell in Markdown."""
    return value.replace("|", "/")


def markdown(header, rows):
    lines = [header, *rows]
    text = ["| " + " | ".join(cells) + " |" for cells in lines]
    return "\n".join([text[0], "|" + "---|" * len(header), *text[1:]])


def table(sweep, knobs, columns):
    """Settings below each other, in the order of the sweep; the default is bold, what the paper did is marked, and
    what must not be used says so. Knobs by their names in the sweep, fields by the heads of columns; with several
    knobs, a column tells which."""
    several = len(knobs) > 1
    fields = [Field(text) for text in columns.values()]
    lines = []
    for knob, meaning in knobs.items():
        found = [sweep.settings(knob, field) for field in fields]
        for value in found[0]:
            rows = [settings[value] for settings in found]
            has = lambda column: any(row and row[column] not in ("", "0") for row in rows)  # noqa: E731
            shown = value_text(value)
            shown = f"**{shown}**" if has("is_default") else shown
            shown += " (paper)" * has("is_paper") + " (unusable)" * has("unusable")
            cells = [cell(field(row)) if row else "" for field, row in zip(fields, rows)]
            lines.append([meaning] * several + [shown] + cells)
    return markdown((["knob", "value"] if several else list(knobs.values())) + list(columns), lines)


def pivot(sweep, title, at, rows, cells, columns=None, unusable="unusable"):
    """Knobs below each other, their values side by side. `at`: heads by value; `rows`: names by knob; `cells`:
    fields, several as "a / b"; `columns`: by head a field and the value at which it is."""
    def shown(knob, value, name):
        field = Field(name)
        row = sweep.settings(knob, field).get(value)
        if not row:
            return "–"
        return unusable if row["unusable"] else cell(field(row))

    def cell_at(knob, value):
        parts = [shown(knob, value, name) for name in cells]
        return " / ".join(part for n, part in enumerate(parts) if n == 0 or part != unusable)

    columns = columns or {}
    lines = [[name, *(cell_at(knob, value) for value in at),
              *(shown(knob, value, field) for field, value in columns.values())] for knob, name in rows.items()]
    return markdown([title, *at.values(), *columns], lines)
