"""Budgets of a cohort: what its jobs may take, and how accurate its replays must be.

A file of budgets (acus-budgets/1), all parts optional:
  {"format": "acus-budgets/1",
   "jobs": {"replay": {"cpu_s": 30, "memory_mb": 500}},                  of each job
   "cohort": {"cpu_h": 2},                                               of all jobs
   "metrics": {"greatest depth [mm]": {"at_most": 90, "share": 0.95}},   columns of group/metrics.tsv
   "comparisons": {"share": 1}}                                          of replays within tolerances
"""
import plan as plans
from files import UserError, read_json

HEADER = ("budget", "value", "limit", "of", "passed", "remark")
COSTS = ("cpu_s", "memory_mb")
LIMITS = ("at_least", "at_most", "share")


def _object(document, allowed, where):
    """The document, an object with allowed keys only."""
    if not isinstance(document, dict):
        raise UserError(f"{where}: must be an object")
    for key in document:
        if allowed and key not in allowed:
            raise UserError(f"{where}: unknown key '{key}'; allowed: {', '.join(allowed)}")
    return document


def _numbers(document, allowed, where):
    for key, value in _object(document, allowed, where).items():
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise UserError(f"{where}/{key}: must be a number, got {value!r}")
        if key == "share" and not 0 <= value <= 1:
            raise UserError(f"{where}/share: must be from 0 to 1, got {value!r}")
        if key in (*COSTS, "cpu_h") and value <= 0:
            raise UserError(f"{where}/{key}: must be above 0, got {value!r}")


def read(path):
    """Budgets of a file, checked. @throws UserError with the place of what is wrong."""
    document = _object(read_json(path), ("format", "description", "jobs", "cohort", "metrics", "comparisons"), path)
    if document.get("format") != "acus-budgets/1":
        raise UserError(f"{path}: format must be \"acus-budgets/1\", got {document.get('format')!r}")
    for rule, limits in _object(document.get("jobs", {}), plans.RULES, f"{path}: /jobs").items():
        _numbers(limits, COSTS, f"{path}: /jobs/{rule}")
    _numbers(document.get("cohort", {}), ("cpu_h",), f"{path}: /cohort")
    for name, limits in _object(document.get("metrics", {}), (), f"{path}: /metrics").items():
        _numbers(limits, LIMITS, f"{path}: /metrics/{name}")
        if not {"at_least", "at_most"} & limits.keys():
            raise UserError(f"{path}: /metrics/{name}: needs at_least or at_most")
    _numbers(document.get("comparisons", {}), ("share",), f"{path}: /comparisons")
    return document


def _row(budget, value, limit, of, passed, remark=""):
    return dict(zip(HEADER, (budget, value, limit, of, "true" if passed else "false", remark)))


def _costs(budgets, costs):
    for rule, limits in sorted(budgets.get("jobs", {}).items()):
        own = [c for c in costs if c["rule"] == rule]
        for key, limit in sorted(limits.items()):
            if own:
                worst = max(own, key=lambda c: c[key])  # pylint: disable=cell-var-from-loop
                yield _row(f"{rule} {key}", worst[key], limit, len(own), worst[key] <= limit,
                           f"largest: {worst['participant_id']} {worst['session_id']}")
    if "cpu_h" in budgets.get("cohort", {}):
        hours, limit = sum(c["cpu_s"] for c in costs) / 3600, budgets["cohort"]["cpu_h"]
        yield _row("cohort cpu_h", hours, limit, len(costs), hours <= limit)


def _accuracy(budgets, rows, comparisons):
    for name, limits in sorted(budgets.get("metrics", {}).items()):
        own = [r for r in rows if isinstance(r.get(name), (int, float))]
        low, high = limits.get("at_least", float("-inf")), limits.get("at_most", float("inf"))
        bad = [r["run"] for r in own if not low <= r[name] <= high]
        yield _share(name, len(own), bad, limits.get("share", 1.0), "no replay has this metric")
    if "share" in budgets.get("comparisons", {}):
        runs = {c["run"] for c in comparisons}
        bad = sorted({c["run"] for c in comparisons if c["passed"] == "false"})
        yield _share("comparisons", len(runs), bad, budgets["comparisons"]["share"],
                     "no replay was compared; see --reference")


def _share(name, count, bad, limit, nothing):
    if not count:
        return _row(f"{name} share", None, limit, 0, False, nothing)
    share = 1 - len(bad) / count
    more = f" and {len(bad) - 3} more" if len(bad) > 3 else ""
    return _row(f"{name} share", share, limit, count, share >= limit,
                "outside: " + ", ".join(bad[:3]) + more if bad else "")


def checks(budgets, rows, comparisons, costs):
    """One row (HEADER) for each budget. A program without a job in the cohort has no row."""
    return [*_costs(budgets, costs), *_accuracy(budgets, rows, comparisons)]


def text_of(check):
    value = "n/a" if check["value"] is None else f"{check['value']:.4g}"
    return f"budget {check['budget']}: {value}, limit {check['limit']:g}. {check['remark']}".rstrip(". ")
