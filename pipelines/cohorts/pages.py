"""Pages of a cohort and their plots: HTML and SVG, without scripts."""
import html
import statistics

STYLE = """body{font-family:sans-serif;max-width:70em;margin:2em auto;padding:0 1em}
table{border-collapse:collapse}td,th{padding:.2em .7em;border-bottom:1px solid #ddd;text-align:left}
td.n{text-align:right}img{max-width:22em;margin:.3em}code{background:#f3f3f3}.bad{color:#a31515}"""


def page(title, body):
    return (f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
            f"<style>{STYLE}</style></head><body>" + "\n".join(body) + "</body></html>\n")


def table(header, rows):
    cells = "".join(f"<th>{html.escape(h)}</th>" for h in header)
    lines = ["<table><tr>" + cells + "</tr>"]
    for row in rows:
        lines.append("<tr>" + "".join(f"<td>{c}</td>" for c in row) + "</tr>")
    return "".join(lines) + "</table>"


def strip_plot(values, unit, flagged):
    """All values on one axis as SVG, with median and quartiles; outliers in red."""
    low, high = min(values), max(values)
    span = (high - low) or abs(high) or 1.0
    def x(value):
        return 20 + 560 * (value - low) / span
    parts = ['<svg xmlns="http://www.w3.org/2000/svg" width="600" height="62" font-size="11">',
             '<line x1="20" y1="42" x2="580" y2="42" stroke="#888"/>']
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
    return (f'<line x1="{x:.1f}" y1="{y(one["min"]):.1f}" x2="{x:.1f}" y2="{y(one["max"]):.1f}" stroke="#888"/>'
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
    parts = ['<svg xmlns="http://www.w3.org/2000/svg" width="680" height="150" font-size="11">',
             '<path d="M70 10V125H610" fill="none" stroke="#888"/>',
             f'<text x="64" y="19" text-anchor="end">{high:.4g}</text>',
             f'<text x="64" y="124" text-anchor="end">{low:.4g}</text>']
    at = [(80 + i * step, p) for i, p in enumerate(points) if p]
    parts.append('<polyline fill="none" stroke="#2a5a8c" points="'
                 + " ".join(f"{x:.1f},{y(p['median']):.1f}" for x, p in at) + '"/>')
    parts += [_band(x, p, y) for x, p in at]
    parts += [f'<text x="{80 + i * step:.1f}" y="142" text-anchor="middle">{i + 1}</text>' for i in range(len(labels))]
    return "".join(parts) + "</svg>"
