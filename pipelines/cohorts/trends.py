"""The command line of pipelines/trends: metrics, times and memory of cohorts and suites over versions."""
import argparse
import html
import math
import pathlib
import statistics

import pages
import user
from files import UserError, read_json, read_tsv, write_tsv, write_whole
from wording import counted

HEADER = ("version", "quantity", "n", "min", "q1", "median", "q3", "max", "outside")
NUMBERS = HEADER[3:8]
EPILOG = """\
Each RUN is one of
  the output of pipelines/cohort        metrics, CPU time and memory by program, failures
  the result of acus-regression run     CPU time of each case, values of its checks
  trends.tsv of an earlier call         so that runs that were deleted stay in the page
in the order of the page. The version is what the run states; LABEL=RUN gives it another name.

EXAMPLE
  pipelines/trends study/acus-0.1 study/acus-0.2 -o trends
"""


def parser():
    p = argparse.ArgumentParser(
        prog="pipelines/trends", epilog=EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Writes trends.html, with a plot of every quantity over versions, and trends.tsv.")
    p.add_argument("run", nargs="+", metavar="RUN", help="folder or table, or LABEL=folder")
    p.add_argument("-o", "--output", required=True, metavar="FOLDER", help="is made if it is not there")
    return p


def row_of(version, quantity, values, outside=0):
    """Distribution of the values of one quantity in one version; `outside` counts failed checks."""
    quarters = [values[0]] * 3
    if len(values) > 1:
        quarters = statistics.quantiles(values, n=4, method="inclusive")
    return {"version": version, "quantity": quantity, "n": len(values), "min": min(values), "q1": quarters[0],
            "median": quarters[1], "q3": quarters[2], "max": max(values), "outside": outside}


def number(text):
    """A finite number, or None."""
    try:
        value = float(text)
    except (TypeError, ValueError):
        return None
    return value if math.isfinite(value) else None


def column(rows, name):
    return [v for v in (number(row.get(name)) for row in rows) if v is not None]


def of_cohort(folder):
    """(version, rows) of an output of pipelines/cohort."""
    made = read_json(folder / "dataset_description.json").get("GeneratedBy") or [{}]
    version = made[0].get("Version") or folder.name
    header, metrics = read_tsv(folder / "group/metrics.tsv")
    found = [(name, column(metrics, name)) for name in header if name not in ("participant_id", "session_id",
                                                                                "run", "name")]
    costs = read_tsv(folder / "work/costs.tsv")[1] if (folder / "work/costs.tsv").exists() else []
    for rule in sorted({c["rule"] for c in costs}):
        own = [c for c in costs if c["rule"] == rule]
        found += [(f"{rule}: CPU time [s]", column(own, "cpu_s")), (f"{rule}: memory [MB]", column(own, "memory_mb"))]
    if costs:
        found.append(("all jobs: CPU time [h]", [sum(column(costs, "cpu_s")) / 3600]))
    failures = read_tsv(folder / "group/failures.tsv")[1]
    failed = len({f["participant_id"] for f in failures})
    rows = [row_of(version, name, values) for name, values in found if values]
    rows.append(row_of(version, "participants that failed", [failed], failed))
    if (folder / "group/comparisons.tsv").exists():
        rows += of_comparisons(version, read_tsv(folder / "group/comparisons.tsv")[1])
    return version, rows


def of_comparisons(version, checks):
    """Differences from the reference, by quantity."""
    for name in sorted({c["quantity"] for c in checks}):
        own = [c for c in checks if c["quantity"] == name]
        values = column(own, "value")
        if values:
            yield row_of(version, f"against the reference: {name}", values,
                         sum(c["passed"] == "false" for c in own))


def of_suite(folder):
    """(version, rows) of a result of acus-regression run."""
    document = read_json(folder / "regression.json")
    version = document.get("provenance", {}).get("version") or folder.name
    rows = []
    for case in document["cases"]:
        name, compared = case["name"], case["comparison"]
        if case["calibration_s"]:
            rows.append(row_of(version, f"{name}: CPU time [calibration loops]",
                               [case["cpu_s"] / case["calibration_s"]]))
        failed = case["verdict"] != "same"
        rows.append(row_of(version, f"{name}: not as expected", [int(failed)], int(failed)))
        for check in compared["checks"] if compared else []:
            value = number(check["value"])
            if value is not None:
                unit = f" [{check['unit']}]" if check["unit"] else ""
                rows.append(row_of(version, f"{name}: {check['quantity']}{unit}", [value], int(not check["passed"])))
    return version, rows


def of_table(path):
    """[(version, rows)] of an earlier trends.tsv."""
    header, rows = read_tsv(path)
    if tuple(header) != HEADER:
        raise UserError(f"{path}: is no trends.tsv; its columns must be {', '.join(HEADER)}")
    by_version = {}
    for line, row in enumerate(rows, 2):
        for name in NUMBERS:
            if (row.setdefault(name) is None) or number(row[name]) is None:
                raise UserError(f"{path}, line {line}: {name} '{row[name]}' is no number")
            row[name] = float(row[name])
        if not (row["n"].isdigit() and row["outside"].isdigit()):
            raise UserError(f"{path}, line {line}: n and outside must be whole numbers from 0")
        row["n"], row["outside"] = int(row["n"]), int(row["outside"])
        by_version.setdefault(row["version"], []).append(row)
    return list(by_version.items())


def read_run(word):
    """[(version, rows)] of one argument."""
    label, path = "", pathlib.Path(word)
    if not path.exists() and "=" in word:
        label, _, name = word.partition("=")
        path = pathlib.Path(name)
    if not path.exists():
        raise UserError(f"{path}: no such file or folder")
    try:
        if path.is_file():
            found = of_table(path)
        elif (path / "regression.json").is_file():
            found = [of_suite(path)]
        elif (path / "group/metrics.tsv").is_file():
            found = [of_cohort(path)]
        else:
            raise UserError(f"{path}: neither an output of pipelines/cohort (group/metrics.tsv) nor a result of "
                            "acus-regression run (regression.json)")
    except (KeyError, TypeError, AttributeError) as error:
        raise UserError(f"{path}: is incomplete: {error}") from error
    if label and len(found) > 1:
        raise UserError(f"{word}: the table has {len(found)} versions; a label is for one")
    return [(label or version, rows) for version, rows in found]


def with_own_names(runs):
    """The same, in order; a second run of a version is VERSION (2)."""
    seen, out = {}, []
    for version, rows in runs:
        seen[version] = seen.get(version, 0) + 1
        name = version if seen[version] == 1 else f"{version} ({seen[version]})"
        out.append((name, [{**row, "version": name} for row in rows]))
    return out


def change(before, now):
    """How far a median moved: (relative change, in interquartile ranges of before); None where undefined."""
    moved = now["median"] - before["median"]
    spread = before["q3"] - before["q1"]
    return moved / abs(before["median"]) if before["median"] else None, moved / spread if spread else None


def changes_part(quantities):
    """The largest changes from the last version but one to the last."""
    rows = []
    for name, points in quantities.items():
        if len(points) > 1 and points[-1] and points[-2] and points[-1]["median"] != points[-2]["median"]:
            relative, spreads = change(points[-2], points[-1])
            rows.append((abs(relative) if relative is not None else math.inf, [
                html.escape(name), f"{points[-2]['median']:.4g}", f"{points[-1]['median']:.4g}",
                "n/a" if relative is None else f"{100 * relative:+.1f} %",
                "n/a" if spreads is None else f"{spreads:+.2f}"]))
    if not rows:
        return ["<p>No median changed from the last version but one to the last.</p>"]
    rows.sort(key=lambda r: -r[0])
    return [pages.table(["quantity", "before", "now", "change", "in interquartile ranges"], [r[1] for r in rows[:20]])]


def page_of(runs):
    labels = [version for version, _ in runs]
    by_version = [{row["quantity"]: row for row in rows} for _, rows in runs]
    names = list(dict.fromkeys(name for found in by_version for name in found))
    quantities = {name: [found.get(name) for found in by_version] for name in names}
    body = [pages.table(["", "version"], [
        [i + 1, html.escape(label)] for i, label in enumerate(labels)]),
        "<h2>From the last version but one to the last</h2>", *changes_part(quantities),
        "<h2>All quantities</h2>",
        "<p>Point: median; box: quartiles; line: range. CPU times depend on the machine, except those in "
        "calibration loops.</p>"]
    for name, points in quantities.items():
        outside = [f"{p['outside']} in {i + 1}" for i, p in enumerate(points) if p and p["outside"]]
        body.append(f"<h3>{html.escape(name)}</h3>{pages.trend_plot(labels, points)}")
        body += [f'<p class="bad">Outside of the limit: {", ".join(outside)}</p>'] if outside else []
    return pages.page("Trends over versions", body)


def run(arguments):
    runs = with_own_names([one for word in arguments.run for one in read_run(word)])
    output = pathlib.Path(arguments.output)
    write_tsv(output / "trends.tsv", HEADER, [row for _, rows in runs for row in rows])
    write_whole(output / "trends.html", page_of(runs))
    print(f"{output}/trends.html: {counted(len(runs), 'version')}")
    return 0


def main(words):
    return user.call("pipelines/trends", run, parser().parse_args(words))
