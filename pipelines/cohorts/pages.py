"""Pages of a cohort and their plots: HTML and SVG, without scripts, in the style of all reports."""
import html
import pathlib
import re
import statistics

STYLE = pathlib.Path(__file__).resolve().parent.parent / "common/page.css"
NUMBER = re.compile(r"[-+]?\d[\d.,e+-]*( ?%)?")


def page(title, body, warnings=()):
    """body: HTML after the title and the warnings, with a contents list of its h2."""
    headings = re.findall(r"<h2>(.*?)</h2>", "\n".join(body))
    parts = ['<!DOCTYPE html>', '<html lang="en">', '<head><meta charset="utf-8">',
             '<meta name="viewport" content="width=device-width, initial-scale=1">', f"<title>{html.escape(title)}</title>",
             f"<style>{STYLE.read_text(encoding='utf-8')}</style></head><body>", f"<h1>{html.escape(title)}</h1>"]
    if warnings:
        parts += ['<aside class="warnings" role="note"><strong>Please note</strong><ul>',
                  *(f"<li>{html.escape(text)}</li>" for text in warnings), "</ul></aside>"]
    if len(headings) > 1:
        links = "".join(f'<li><a href="#s{i}">{text}</a></li>' for i, text in enumerate(headings, 1))
        parts.append(f'<nav aria-label="Contents"><ul>{links}</ul></nav>')
    text = "\n".join(body)
    for i in range(len(headings)):
        text = text.replace("<h2>", f'<h2 id="s{i + 1}">', 1)
    return "\n".join([*parts, "<main>", text, "</main></body></html>"]) + "\n"


def table(header, rows):
    """Columns of numbers are flush right."""
    is_number = [bool(rows) and all(NUMBER.fullmatch(str(row[i])) or str(row[i]) in ("", "n/a") for row in rows)
                 for i in range(len(header))]
    def line(cells, tag):
        marks = [' class="n"' if number else "" for number in is_number]
        return "<tr>" + "".join(f"<{tag}{mark}>{cell}</{tag}>" for mark, cell in zip(marks, cells)) + "</tr>"
    return ('<div class="scroll"><table><thead>' + line(map(html.escape, header), "th") + "</thead><tbody>"
            + "".join(line(row, "td") for row in rows) + "</tbody></table></div>")


def strip_plot(values, unit, flagged):
    """All values on one axis as SVG, with median and quartiles; outliers in red."""
    low, high = min(values), max(values)
    span = (high - low) or abs(high) or 1.0
    def x(value):
        return 20 + 560 * (value - low) / span
    parts = ['<svg xmlns="http://www.w3.org/2000/svg" width="600" height="62" font-size="11" fill="currentColor">',
             '<line x1="20" y1="42" x2="580" y2="42" stroke="currentColor"/>']
    if len(values) > 1:
        first, middle, third = statistics.quantiles(values, n=4, method="inclusive")
        parts.append(f'<rect x="{x(first):.1f}" y="8" width="{x(third) - x(first) + 0.5:.1f}" height="26" '
                     f'fill="#dfe8f3"/><line x1="{x(middle):.1f}" y1="8" x2="{x(middle):.1f}" y2="34" '
                     'stroke="#2a5a8c" stroke-width="2"/>')
    for i, value in enumerate(values):
        colour = "#c4231d" if i in flagged else "#2a5a8c"
        y = 12 + 18 * ((i * 0.618034) % 1)  # Apart from each other, the same in every run.
        parts.append(f'<circle cx="{x(value):.1f}" cy="{y:.1f}" r="2.6" fill="{colour}" fill-opacity="0.6"/>')
    parts += [f'<text x="20" y="56">{low:.4g} {html.escape(unit)}</text>',
              f'<text x="580" y="56" text-anchor="end">{high:.4g} {html.escape(unit)}</text></svg>']
    return "".join(parts)


def _band(x, one, y):
    """Range, quartiles and median of one point of a trend."""
    return (f'<line x1="{x:.1f}" y1="{y(one["min"]):.1f}" x2="{x:.1f}" y2="{y(one["max"]):.1f}" stroke="currentColor"/>'
            f'<rect x="{x - 6:.1f}" y="{y(one["q3"]):.1f}" width="12" '
            f'height="{y(one["q1"]) - y(one["q3"]) + 0.5:.1f}" fill="#dfe8f3" stroke="#2a5a8c"/>'
            f'<circle cx="{x:.1f}" cy="{y(one["median"]):.1f}" r="3" fill="#2a5a8c"/>')


def trend_plot(labels, points):
    """Medians over versions as SVG, with quartiles and range; None where a version has no value."""
    there = [p for p in points if p]
    low, high = min(p["min"] for p in there), max(p["max"] for p in there)
    span = (high - low) or abs(high) or 1.0
    step = 520 / max(1, len(labels) - 1)
    def y(value):
        return 120 - 105 * (value - low) / span
    parts = ['<svg xmlns="http://www.w3.org/2000/svg" width="680" height="150" font-size="11" fill="currentColor">',
             '<path d="M70 10V125H610" fill="none" stroke="currentColor"/>',
             f'<text x="64" y="19" text-anchor="end">{high:.4g}</text>',
             f'<text x="64" y="124" text-anchor="end">{low:.4g}</text>']
    at = [(80 + i * step, p) for i, p in enumerate(points) if p]
    parts.append('<polyline fill="none" stroke="#2a5a8c" points="'
                 + " ".join(f"{x:.1f},{y(p['median']):.1f}" for x, p in at) + '"/>')
    parts += [_band(x, p, y) for x, p in at]
    parts += [f'<text x="{80 + i * step:.1f}" y="142" text-anchor="middle">{i + 1}</text>' for i in range(len(labels))]
    return "".join(parts) + "</svg>"
