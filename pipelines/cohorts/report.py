"""The report of a cohort: distributions of metrics, outliers with images, failures; tables for R and
pandas (tab-separated, n/a for missing)."""
import html
import json
import os
import statistics

import budgets
import pages
import resources
from files import read_json, write_json, write_tsv, write_whole
from wording import counted, duration

OUTLIER_Z = 3.5  # Iglewicz and Hoaglin (1993), of the modified z-score.


def median_and_spread(values):
    """Median, and 1.4826 times the median absolute deviation: the SD of a normal distribution."""
    middle = statistics.median(values)
    return middle, 1.4826 * statistics.median(abs(v - middle) for v in values)


def outliers(values):
    """Positions of the values far from the median, with their modified z-scores."""
    middle, spread = median_and_spread(values)
    if len(values) < 5 or spread == 0:
        return {}
    return {i: (v - middle) / spread for i, v in enumerate(values) if abs(v - middle) > OUTLIER_Z * spread}


def runs_of(output, plan):
    """One row for each finished replay: ids, and its metrics by name; with their units."""
    rows, units = [], {}
    for job in plan.jobs.values():
        folder = output / job["output"]
        if job["rule"] != "replay" or not (folder / "metrics.json").exists():
            continue
        row = {"participant_id": job["participant"], "session_id": job["session"],
               "run": job["output"], "name": job["output"].rpartition("/")[2]}
        for metric in read_json(folder / "metrics.json")["metrics"]:
            column = metric["name"] + (f" [{metric['unit']}]" if metric["unit"] else "")
            row[column], units[column] = metric["value"], metric["unit"]
        rows.append(row)
    return rows, units


def comparisons_of(output, plan):
    """One row for each check of each comparison with the reference."""
    rows = []
    for job in plan.jobs.values():
        path = output / job["output"] / "comparison.json"
        if job["rule"] != "compare" or not path.exists():
            continue
        for check in read_json(path)["checks"]:
            rows.append({"participant_id": job["participant"], "session_id": job["session"],
                         "run": job["output"], "quantity": check["quantity"], "value": check["value"],
                         "limit": check["limit"], "unit": check["unit"],
                         "passed": "true" if check["passed"] else "false", "remark": check["remark"]})
    return rows


def differences_of(comparisons):
    """Rows and units as of `runs_of`: what differs from the reference, for each replay that was compared."""
    rows, units = {}, {}
    for check in comparisons:
        if isinstance(check["value"], (int, float)):
            column = "against the reference: " + check["quantity"] + (f" [{check['unit']}]" if check["unit"] else "")
            run = check["run"].replace("/comparisons/", "/replays/")
            rows.setdefault(run, {"run": run})[column], units[column] = check["value"], check["unit"]
    return list(rows.values()), units


def costs_of(output, plan):
    """One row for each job that ran: measured and predicted time and memory."""
    rows = []
    for name, job in plan.jobs.items():
        path = output / "work/measured" / f"{name}.json"
        if path.exists():
            m = json.loads(path.read_text(encoding="utf-8"))
            rows.append({"participant_id": job["participant"], "session_id": job["session"],
                         "rule": job["rule"], "wall_s": m["seconds"], **{k: m[k] for k in (
                             "cpu_s", "memory_mb", "predicted_s", "predicted_mb", "host")}})
    return rows


def _images(output, run):
    """The segmentation, the first events of a run and the image that differs most from the reference, as links
    relative to the report."""
    base = output / run
    patient = base.parent.parent if base.parent.name == "replays" else base.parent
    found = [patient / "segmentation/preview_axial.png", *sorted(base.glob("event_*.png"))[:3],
             patient / "comparisons" / base.name / "worst_frame.png"]
    return "".join(f'<a href="{os.path.relpath(p, output / "group")}"><img loading="lazy" '
                   f'src="{os.path.relpath(p, output / "group")}" alt="{p.stem}"></a>'
                   for p in found if p.exists())


def _metrics_part(output, rows, units):
    parts, table = [], []
    for column, unit in sorted(units.items()):
        own = [row for row in rows if isinstance(row.get(column), (int, float))]
        if not own:
            continue
        values = [float(row[column]) for row in own]
        flagged = outliers(values)
        middle, spread = median_and_spread(values)
        table.append({"metric": column, "n": len(values), "median": middle, "spread": spread,
                      "min": min(values), "max": max(values), "outliers": len(flagged)})
        parts.append(f"<h3>{html.escape(column)}</h3>{pages.strip_plot(values, unit, flagged)}<p>{counted(len(values), 'run')}, "
                     f"median {middle:.4g}, spread (1.4826 MAD) {spread:.4g}</p>")
        for i in sorted(flagged, key=lambda k: -abs(flagged[k]))[:5]:
            run = own[i]["run"]
            link = f'<a href="../{html.escape(run)}/report.html">{html.escape(run)}</a>'
            parts.append(f"<p>{link}: {values[i]:.4g}, {flagged[i]:+.1f} spreads from the median</p>"
                         + _images(output, run))
    return parts, table


def _failures_part(output, failed, problems):
    if not failed and not problems:
        return ["<p>No participant failed.</p>"]
    rows = [[html.escape(f["participant"]), html.escape(f["session"]), f.get("rule", "sources"),
             f'<span class="bad">{html.escape(f["message"])}</span>',
             f'<code>{html.escape(f["command"])}</code>' if "command" in f else ""]
            for f in failed + problems]
    return [pages.table(["participant", "session", "step", "message", "command, in this folder"], rows)]


def _costs_part(output, costs):
    if not costs:
        return []
    rows = []
    for rule in sorted({c["rule"] for c in costs}):
        own = [c for c in costs if c["rule"] == rule]
        ratio, within = resources.accuracy(own)
        rows.append([rule, len(own), duration(sum(c["cpu_s"] for c in own)),
                     f"{max(c['memory_mb'] for c in own):.0f}", f"{ratio:.2f}", f"{100 * within:.0f} %"])
    text = ""
    if (output / "work/last_run.json").exists():
        last = read_json(output / "work/last_run.json")
        text = (f"<p>Last run: {counted(last['jobs'], 'job')} took {duration(last['took_s'])}; predicted "
                f"{duration(last['wall_s'])} on {last['cores']} cores.</p>")
    plots = []
    for rule in sorted({c["rule"] for c in costs}):
        values = [c["cpu_s"] for c in costs if c["rule"] == rule]
        plots.append(f"<h3>{rule}: CPU time [s]</h3>{pages.strip_plot(values, 's', outliers(values))}")
    return ["<h2>Programs</h2>", text, pages.table(
        ["program", "jobs", "CPU time", "largest memory, MB", "measured / predicted time (median)",
         "within the memory asked for"], rows), *plots]


def _budgets_part(checks):
    if not checks:
        return []
    rows = [[html.escape(c["budget"]), "n/a" if c["value"] is None else f"{c['value']:.4g}", f"{c['limit']:g}", c["of"],
             "yes" if c["passed"] == "true" else '<span class="bad">NO</span>', html.escape(c["remark"])]
            for c in checks]
    return ["<h2>Budgets</h2>", pages.table(["budget", "value", "limit", "jobs or replays", "kept", ""], rows)]


def write(output, plan, failed, problems, limits=None):
    """Writes group/report.html and the tables beside it; returns the checks of the budgets `limits`.
    Measured times differ from run to run: they are in group/times.html, group/budgets.tsv and
    work/costs.tsv, and in no other page or table."""
    group = output / "group"
    rows, units = runs_of(output, plan)
    parts, table = _metrics_part(output, rows, units)
    comparisons, costs = comparisons_of(output, plan), costs_of(output, plan)
    differing, of_differences = _metrics_part(output, *differences_of(comparisons))
    ids = ["participant_id", "session_id", "run", "name"]
    write_tsv(group / "metrics.tsv", ids + sorted(units), rows)
    write_tsv(group / "distributions.tsv", ["metric", "n", "median", "spread", "min", "max", "outliers"],
              table + of_differences)
    write_json(group / "metrics.json", {c: {"Units": u or "1"} for c, u in units.items()})
    failures = [{"participant_id": f["participant"], "session_id": f["session"], "step": f.get("rule", "sources"),
                 "message": f["message"], "command": f.get("command")} for f in failed + problems]
    write_tsv(group / "failures.tsv", ["participant_id", "session_id", "step", "message", "command"], failures)
    write_tsv(output / "work/costs.tsv", ["participant_id", "session_id", "rule", "wall_s", "cpu_s", "memory_mb",
                                          "predicted_s", "predicted_mb", "host"], costs)
    kept = budgets.checks(limits or {}, rows, comparisons, costs)
    (group / "budgets.tsv").unlink(missing_ok=True)
    if limits:
        write_tsv(group / "budgets.tsv", budgets.HEADER, kept)
    differ = []
    if comparisons:
        write_tsv(group / "comparisons.tsv", list(comparisons[0]), comparisons)
        bad = [c for c in comparisons if c["passed"] == "false"]
        runs = {c["run"] for c in comparisons}
        differ = ["<h2>Comparison with the reference</h2>",
                  f"<p>{len(runs) - len({c['run'] for c in bad})} of {counted(len(runs), 'replay')} within "
                  "tolerances.</p>", pages.table(["run", "quantity", "value", "limit", "remark"], [
                      [f'<a href="../{c["run"]}/comparison.html">{c["run"]}</a>', html.escape(c["quantity"]),
                       c["value"], c["limit"], html.escape(c["remark"])] for c in bad[:200]]), *differing]
    people = {j["participant"] for j in plan.jobs.values()} | {p["participant"] for p in problems}
    warnings = [f"{counted(len({f['participant'] for f in failed + problems}), 'participant')} failed."] if failed + problems else []
    body = [f"<p>{counted(len(people), 'participant')}, {counted(len(rows), 'replay')}.</p>", "<h2>Failures</h2>",
            *_failures_part(output, failed, problems), *differ, "<h2>Metrics</h2>", *parts,
            "<p>Tables: <a href=\"metrics.tsv\">metrics.tsv</a>, <a href=\"distributions.tsv\">distributions.tsv"
            "</a>, <a href=\"failures.tsv\">failures.tsv</a>; <a href=\"times.html\">time, memory and budgets</a></p>"]
    write_whole(group / "report.html", pages.page("Cohort", body, warnings))
    write_whole(group / "times.html", pages.page("Time and memory",
                                                   _budgets_part(kept) + _costs_part(output, costs)))
    return kept
