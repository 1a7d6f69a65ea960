#!/usr/bin/python3
"""Pages about accuracy and time from stored results; developer/accuracy-and-time runs it."""
import argparse
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path.append(str(ROOT / "pipelines" / "common"))

import page  # noqa: E402
import user  # noqa: E402
from files import write_whole  # noqa: E402


def parser():
    out = argparse.ArgumentParser(prog="accuracy_pages", description=__doc__)
    out.add_argument("--templates", type=pathlib.Path, default=ROOT / "docs" / "templates",
                     metavar="DIR", help="folder of *.template")
    out.add_argument("--data", type=pathlib.Path, required=True, metavar="DIR",
                     help="folder of results: SWEEP.csv, machine.json, ...")
    out.add_argument("-o", "--output", type=pathlib.Path, required=True, metavar="DIR",
                     help="folder for the pages and their figures/")
    out.add_argument("--strict", action="store_true",
                     help="every claim of the text must hold, every number be there")
    return out


def run(arguments):
    files = page.make_pages(arguments.templates, arguments.data, arguments.strict)
    for name, text in files.items():
        write_whole(arguments.output / name, text)
    return 0


def main(words):
    return user.call("accuracy_pages", run, parser().parse_args(words))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
