"""Pages with measured numbers, from Jinja templates that hold no number themselves.

A template knows each sweep and each file of facts by its name, and `min`, `max` and `log` of what they hold
(measured.py). Beside plain Jinja it has:

    {{ 1000 * needle("num_nodes", 15, "error N") }}   a number, with two significant digits
    {{ claims.fe_4mm_nodes | digits(4) }}             a number with more
    {{ require(2 < log(...) / log(4) < 3) -}}         nothing if that holds; before the sentence that says so
    {{ table(...) }}, {{ pivot(...) }}                rows of a sweep (tables.py)
    {{ work({"nodes": [361, claims.nodes]}) }}        whether that is the same work (pipelines/paper_pages/work.py)
    {{ word(claims.image_ms, 16) }}                   slower, faster or as fast as the paper's time
    {{ figure("name", "title", ...) }}                a figure (figures.py) as figures/name.svg
"""
import math
import pathlib
import re
import sys
import traceback

import figures
import jinja2

sys.path.append(str(pathlib.Path(__file__).resolve().parents[2] / "pipelines" / "paper_pages"))
import rows  # noqa: E402
import work  # noqa: E402
from files import UserError
from measured import FUNCTIONS, Claim, Number, read_folder, rounded
from tables import pivot, table

LINK_TO_PAGE = re.compile(r"\[([^\]\n]+)\]\([^)\s]+\.md[^)\s]*\)")


def template_line():
    """The line of the template that is being filled in."""
    frame = sys._getframe(1)
    while "__jinja_template__" not in frame.f_globals:
        frame = frame.f_back
    return frame.f_globals["__jinja_template__"].get_corresponding_lineno(frame.f_lineno)


class Page:
    """One template, filled in. `problems` lists by line what cannot be understood and, if claims must hold, all
    that do not and all that was not measured. Otherwise the text says where it is not so."""

    def __init__(self, path, measured, strict):
        self.path, self.strict = path, strict
        self.text, self.figures, self.problems = "", {}, []
        environment = jinja2.Environment(loader=jinja2.FileSystemLoader(path.parent), finalize=self.shown,
                                         undefined=jinja2.StrictUndefined, keep_trailing_newline=True)
        environment.filters["digits"] = self.number
        environment.globals.update(measured, require=self.require, table=table, pivot=pivot, figure=self.figure,
                                   work=self.work, word=self.word, **FUNCTIONS)
        try:
            self.text = environment.get_template(path.name).render()
        except jinja2.TemplateSyntaxError as error:
            self.problem(error.lineno, error.message)
        except (UserError, jinja2.TemplateError, TypeError, ValueError) as error:
            places = [place.lineno for place in traceback.extract_tb(error.__traceback__)
                      if place.filename == str(path)]
            self.problem(places[-1], error)

    def problem(self, line, what):
        self.problems.append(f"{self.path}:{line}: {what}")

    def number(self, value, digits=2):
        if self.strict and not math.isfinite(value):
            self.problem(template_line(), "a number was not measured")
        return rounded(value, digits)

    def shown(self, value):
        """What a template's {{ value }} becomes."""
        if isinstance(value, (Number, float)):
            return self.number(value)
        if isinstance(value, (Claim, bool)):
            raise UserError("a comparison is no text: write require(...)")
        return value

    def require(self, claim):
        if not isinstance(claim, Claim):
            raise UserError("require() needs a comparison of what was measured, by <, <=, > or >=")
        if claim:
            return ""
        if self.strict:
            why = f"what the text says no longer holds: {claim.text}"
            self.problem(template_line(), why if claim.measured else "what the text says was not measured")
        return f" **(not so in this run: {claim.text})** " if claim.measured else " **(not measured in this run)** "

    def work(self, parts):
        return work.verdict({what: tuple(map(self.plain, sides)) for what, sides in parts.items()})

    def word(self, ours, paper):
        if not math.isfinite(ours):
            return self.number(ours)
        return rows.word(ours, paper, "**slower**", "faster", "as fast")

    def plain(self, value):
        """A number that was not measured is none of the paper's: the same mark as elsewhere."""
        return self.number(value) if isinstance(value, Number) and not math.isfinite(value) else value

    def figure(self, name, title, sweep, x, y, lines=None, points=()):
        self.figures[name] = figures.svg(title, sweep, x, y, lines or {}, points)
        return f"![{title}](figures/{name}.svg)"


def make_pages(templates, data, strict):
    """Files by their path in the folder of pages: NAME.md for each NAME.template, figures/NAME.svg. Pages for
    elsewhere (claims are marked) do not link to other pages of the documentation."""
    measured = read_folder(data)
    pages = [Page(path, measured, strict) for path in sorted(pathlib.Path(templates).glob("*.template"))]
    if not pages:
        raise UserError(f"{templates}: there is no *.template")
    problems = [problem for page in pages for problem in page.problems]
    if problems:
        raise UserError("\n".join(["no page was written:", *problems]))
    files = {}
    for page in pages:
        files[f"{page.path.stem}.md"] = page.text if strict else LINK_TO_PAGE.sub(r"\1", page.text)
        files.update((f"figures/{name}.svg", svg) for name, svg in page.figures.items())
    return files
