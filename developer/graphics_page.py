#!/usr/bin/env python3
"""The page of developer/graphics-check: images that were compared, and times."""
import json
import pathlib
import re
import sys


def image_rows(folder):
    with open(folder / "images.json", encoding="utf-8") as file:
        suites = json.load(file)["testsuites"]
    for case in (case for suite in suites for case in suite["testsuite"]):
        words = re.sub(r"(?<!^)(?=[A-Z])", " ", case["name"]).lower()
        yield words, "differs" if case.get("failures") else "same within 40 dB"


def time_rows(folder):
    path = folder / "graphics.json"
    if not path.exists():
        return
    with open(path, encoding="utf-8") as file:
        runs = json.load(file)["benchmarks"]
    for run in runs:
        _, _, nodes, components, _ = run["name"].split("/")[:5]
        breath = "at rest" if components == "0" else f"{nodes}^3 nodes, {components} components"
        yield run["label"], breath, run["real_time"], run["cpu_time"]


def main():
    folder, card = pathlib.Path(sys.argv[1]), sys.argv[2]
    print(f"# Volume view: {card}\n\n| scenes | the card's image and the processor's |\n|---|---|")
    for words, result in image_rows(folder):
        print(f"| {words} | {result} |")
    rows = list(time_rows(folder))
    if not rows:
        return
    print("\n| 1224 x 1014 | breath | time per image [ms] | of it CPU time of this computer [ms] |\n|---|---|---|---|")
    for label, breath, real_ms, cpu_ms in rows:
        print(f"| {label} | {breath} | {real_ms:.1f} | {cpu_ms:.1f} |")


if __name__ == "__main__":
    main()
