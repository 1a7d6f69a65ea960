"""What the figures of README and docs/ were made of: docs/figures/figures.toml names it, docs/figures/figures.csv records it.

    figure_record.py names | stale | targets | stamp NAME...

A figure is stale where its sources have another content than when it was made. Content is what can change a figure: of C++,
Python and shell without comments and spaces, of JSON the values without descriptions, of the rest every byte.
"""
import csv
import hashlib
import io
import json
import pathlib
import re
import sys
import tomllib

ROOT = pathlib.Path(__file__).resolve().parents[1]
FIGURES = "docs/figures"
CPP = re.compile(r'//[^\n]*|/\*.*?\*/|("(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\')|\s+', re.DOTALL)
SUFFIXES = {".cpp", ".h", ".json", ".csv", ".sh", ".py", ".toml", ".template", ".svg", ".png", ".glsl", ""}


class FigureError(Exception):
    pass


def groups(root=ROOT):
    with open(root / "docs/figures/figures.toml", "rb") as file:
        return tomllib.load(file)


def without_descriptions(value):
    if isinstance(value, dict):
        return {key: without_descriptions(item) for key, item in value.items() if key not in ("description", "source")}
    return [without_descriptions(item) for item in value] if isinstance(value, list) else value


def content(path):
    """What of a file can change a figure."""
    if path.suffix in (".png", ".csv", ".svg", ".template"):
        return path.read_bytes()
    text = path.read_text(encoding="utf-8")
    if path.suffix in (".cpp", ".h"):
        text = CPP.sub(lambda match: match[1] or "", text)
    elif path.suffix == ".json":
        text = json.dumps(without_descriptions(json.loads(re.sub(r"^\s*//.*$", "", text, flags=re.MULTILINE))), sort_keys=True)
    else:
        text = "\n".join(line.strip() for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#"))
    return text.encode()


def files_of(root, name):
    path = root / name
    if path.is_dir():
        found = sorted(p for p in path.rglob("*") if p.is_file() and p.suffix in SUFFIXES and "__pycache__" not in p.parts)
    else:
        found = [path] if path.is_file() else []
    if not found:
        raise FigureError(f"docs/figures/figures.toml: {name} is not there")
    return found


def sources(root, group, kinds=("of", "code")):
    """Digest of all that a group's figures are made of."""
    digest = hashlib.sha256()
    for name in (name for kind in kinds for name in group.get(kind, [])):
        for path in files_of(root, name):
            digest.update(path.relative_to(root).as_posix().encode() + b"\0" + content(path) + b"\0")
    return digest.hexdigest()[:16]


def image(root, name):
    path = root / FIGURES / name
    return hashlib.sha256(path.read_bytes()).hexdigest()[:16] if path.is_file() else ""


def record(root=ROOT):
    """(sources, image, listed) by the figure's name."""
    path = root / "docs/figures/figures.csv"
    if not path.is_file():
        return {}
    with open(path, encoding="utf-8", newline="") as file:
        return {row["figure"]: (row["sources"], row["image"], row["listed"]) for row in csv.DictReader(file)}


def stale(root=ROOT, with_open=False):
    """What is wrong, by the group's name. A group with `open` (why) waits to be made again: the test passes it over,
    as it does a change of what is `listed` only."""
    recorded = record(root)
    found = {}
    for name, group in groups(root).items():
        if "open" in group:
            if with_open:
                found[name] = group["open"]
            continue
        now = sources(root, group)
        for figure in group["makes"]:
            before = recorded.get(figure, ("", "", ""))
            if before[0] != now:
                found[name] = "its sources changed"
            elif before[1] != image(root, figure):
                found[name] = f"{figure} is not the one that was recorded"
            elif with_open and before[2] != sources(root, group, ("listed",)):
                found[name] = "the code of its window changed"
    return found


def stamp(names, root=ROOT):
    known = groups(root)
    recorded = record(root)
    for name in names:
        now = sources(root, known[name])
        for figure in known[name]["makes"]:
            if not image(root, figure):
                raise FigureError(f"{FIGURES}/{figure} was not made")
            recorded[figure] = (now, image(root, figure), sources(root, known[name], ("listed",)))
    kept = {figure for group in known.values() for figure in group["makes"]}
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(("figure", "sources", "image", "listed"))
    writer.writerows((figure, *recorded[figure]) for figure in sorted(kept & recorded.keys()))
    (root / "docs/figures/figures.csv").write_text(text.getvalue(), encoding="utf-8")


def main():
    try:
        command, names = sys.argv[1], sys.argv[2:]
        if command == "names":
            print("\n".join(groups()))
        elif command == "stale":
            for name, why in stale(with_open=True).items():
                print(f"{name}: {why}")
        elif command == "stamp":
            stamp(names)
        else:
            raise FigureError(f"unknown command {command}")
    except (FigureError, OSError, KeyError) as error:
        sys.exit(f"developer/figures: {error}")


if __name__ == "__main__":
    main()
