"""What a job will take, from the size of its inputs: seconds and memory as linear models.

Models are in resources.json, with the measurements that they were fitted on; a cohort's own
measurements (work/measured) refine them. Features of a job: 1, millions of voxels, MB of recordings.
"""
import json
import pathlib
import re
import statistics

from files import read_json, write_json

HERE = pathlib.Path(__file__).parent
FEATURES = ("constant", "megavoxels", "recording_mb")
MEMORY_MARGIN = 1.3  # Over the fit, besides the largest residual.
ENOUGH = 8  # Measurements of a rule from which a cohort's own model is used.


def megavoxels(path):
    """Of a volume, from its header; of a folder or another file, from its size (16 bits a voxel)."""
    path = pathlib.Path(path)
    if path.is_dir():
        return sum(p.stat().st_size for p in path.rglob("*") if p.is_file()) / 2e6
    if not path.exists():
        return 0.0
    with open(path, "rb") as stream:
        head = stream.read(8192).decode("latin-1")
    match = re.search(r"(?m)^(?:sizes:|DimSize =)((?: +\d+){3})", head)
    if match:
        size = [int(word) for word in match[1].split()]
        return size[0] * size[1] * size[2] / 1e6
    return path.stat().st_size / (1e6 if path.suffix == ".gz" else 2e6)


def megabytes(path):
    path = pathlib.Path(path)
    if path.is_dir():
        return sum(p.stat().st_size for p in path.rglob("*.csv")) / 1e6
    return path.stat().st_size / 1e6 if path.exists() else 0.0


def _solve(matrix, right):
    """Gaussian elimination with pivots, for the few unknowns here."""
    n = len(right)
    rows = [list(matrix[i]) + [right[i]] for i in range(n)]
    for i in range(n):
        pivot = max(range(i, n), key=lambda r: abs(rows[r][i]))
        rows[i], rows[pivot] = rows[pivot], rows[i]
        if abs(rows[i][i]) < 1e-12:
            return None
        for r in range(n):
            if r != i:
                factor = rows[r][i] / rows[i][i]
                rows[r] = [a - factor * b for a, b in zip(rows[r], rows[i])]
    return [rows[i][n] / rows[i][i] for i in range(n)]


def fit(samples):
    """Least squares with coefficients >= 0: [(features, value)] -> coefficients.

    A feature that does not vary, or whose coefficient is negative, is left out (its coefficient
    is 0)."""
    used = [i for i in range(len(FEATURES))
            if i == 0 or len({round(f[i], 6) for f, _ in samples}) > 1]
    while used:
        matrix = [[sum(f[i] * f[j] for f, _ in samples) for j in used] for i in used]
        right = [sum(f[i] * value for f, value in samples) for i in used]
        found = _solve(matrix, right)
        if found is None:
            used.pop()
            continue
        worst = min(range(len(used)), key=lambda k: found[k])
        if found[worst] >= 0:
            return [found[used.index(i)] if i in used else 0.0 for i in range(len(FEATURES))]
        used.pop(worst)
    return [0.0] * len(FEATURES)


def value_of(coefficients, features):
    return sum(c * f for c, f in zip(coefficients, features))


def model_of(measurements):
    """{'seconds': [...], 'memory_mb': [...]} of [{'features', 'cpu_s', 'memory_mb'}]."""
    seconds = fit([(m["features"], m["cpu_s"]) for m in measurements])
    memory = fit([(m["features"], m["memory_mb"]) for m in measurements])
    above = max(m["memory_mb"] - value_of(memory, m["features"]) for m in measurements)
    memory[0] += max(0.0, above)
    return {"cpu_s": [round(c, 4) for c in seconds], "memory_mb": [round(c, 2) for c in memory],
            "measurements": len(measurements)}


def measured_in(output):
    """{rule: measurements} of the jobs of a cohort that have run."""
    found = {}
    for path in sorted(pathlib.Path(output, "work/measured").glob("*.json")):
        try:
            measurement = json.loads(path.read_text(encoding="utf-8"))
        except ValueError:
            continue
        found.setdefault(measurement["rule"], []).append(measurement)
    return found


def models_for(output):
    """The shipped models, and those of the cohort's own runs where there are enough of them."""
    models = dict(read_json(HERE / "resources.json")["models"])
    for rule, measurements in measured_in(output).items():
        if len(measurements) >= ENOUGH:
            models[rule] = model_of(measurements)
    return models


def predict(models, rule, features):
    """(CPU seconds, memory in MB to ask for)."""
    model = models[rule]
    memory = MEMORY_MARGIN * value_of(model["memory_mb"], features)
    return value_of(model["cpu_s"], features), max(64, int(memory + 0.5))


def write_shipped(outputs, rules=()):
    """Fits resources.json again on the measurements of finished cohorts; only these rules, if any are named."""
    all_of = {}
    for output in outputs:
        for rule, measurements in measured_in(output).items():
            if not rules or rule in rules:
                all_of.setdefault(rule, []).extend(measurements)
    kept = {rule: [{"features": [round(f, 4) for f in m["features"]], "cpu_s": round(m["cpu_s"], 3),
                    "memory_mb": round(m["memory_mb"], 1)} for m in ms]
            for rule, ms in sorted(all_of.items())}
    old = read_json(HERE / "resources.json") if (HERE / "resources.json").exists() else {"models": {}, "measurements": {}}
    models = {**old["models"], **{rule: model_of(ms) for rule, ms in kept.items()}}
    write_json(HERE / "resources.json", {"features": FEATURES, "models": models,
                                         "measurements": {**old["measurements"], **kept}})


def accuracy(measurements):
    """How right the predictions were: median of measured / predicted CPU time, and the share of
    jobs that stayed within their memory."""
    ratios = [m["cpu_s"] / m["predicted_s"] for m in measurements if m["predicted_s"] > 0]
    within = [m["memory_mb"] <= m["predicted_mb"] for m in measurements]
    return (statistics.median(ratios) if ratios else float("nan"),
            sum(within) / len(within) if within else float("nan"))
