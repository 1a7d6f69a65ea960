#!/usr/bin/env python3
"""Manual pages of all programs and workflows, from their --help.

Usage: man_pages.py PROGRAMS_FOLDER WORKFLOWS_FOLDER VERSION OUTPUT_FOLDER
"""
import gzip
import os
import pathlib
import sys

sys.dont_write_bytecode = True
import commands  # noqa: E402


def escaped(text):
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + text if text.startswith((".", "'")) else text


def items_of(items):
    for item in items:
        yield ".TP"
        # A list of values may be longer than a line: it breaks after a comma, and lines are not stretched.
        yield f".B {escaped(item.term)}".replace(",", ",\\:")
        yield escaped(item.text) or "\\&"


def body_of(command):
    for usage in command.usage:
        yield ".PP"
        yield escaped(usage)
    for heading, items in command.sections:
        if items and heading not in ("Options", "Positionals", "Subcommands", "options", "positional arguments"):
            yield ".PP"
            yield escaped(heading) + ":"
        yield from items_of(items)


def page_of(command, version):
    name = command.name.replace(" ", "-")
    yield f'.TH {name.upper()} 1 "" "Acus {version}" "User Commands"'
    yield ".ad l"
    yield ".SH NAME"
    yield f"{escaped(name)} \\- {escaped(command.summary)}"
    yield ".SH SYNOPSIS"
    yield from (f".B {escaped(usage)}" for usage in command.usage)
    yield ".SH DESCRIPTION"
    for paragraph in command.text:
        yield escaped(paragraph)
        yield ".PP"
    yield ".SH OPTIONS"
    for _, items in command.sections:
        yield from items_of(items)
    for subcommand in command.subcommands:
        yield f".SH {escaped(subcommand.name.upper())}"
        yield escaped(subcommand.summary)
        yield from body_of(subcommand)
    if command.example:
        yield ".SH EXAMPLE"
        yield ".nf"
        yield from map(escaped, command.example)
        yield ".fi"
    yield ".SH EXIT STATUS"
    yield ("0: done; 1: unforeseen error; 2: command line; 3: input not usable; 4: no usable answer; "
           "130: stopped by the user.")
    yield ".SH SEE ALSO"
    yield ".BR acus (1)"


def main(programs, workflows, version, output):
    folder = pathlib.Path(output)
    folder.mkdir(parents=True, exist_ok=True)
    for command in commands.all_commands(pathlib.Path(programs), pathlib.Path(workflows)):
        text = "\n".join(page_of(command, version)) + "\n"
        path = folder / (command.name.replace(" ", "-") + ".1.gz")
        # Without name and time: the same text, the same bytes.
        path.write_bytes(gzip.compress(text.encode(), 9, mtime=0))


if __name__ == "__main__":
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    main(*sys.argv[1:])
