"""Files of a workplace: read with messages that say what is wrong, written whole or not at all."""
import csv
import io
import json
import os
import pathlib
import re


class UserError(Exception):
    """What the user can mend: one message with file, value, what is allowed, what to try."""


def write_whole(path, text):
    """Writes a text file completely or not at all, and puts it on the medium."""
    path = pathlib.Path(path)
    partial = path.with_name(f".partial-{os.getpid()}-{path.name}")
    try:
        with open(partial, "w", encoding="utf-8", newline="") as stream:
            stream.write(text)
            stream.flush()
            os.fsync(stream.fileno())
        os.replace(partial, path)
        folder = os.open(path.parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise UserError(f"{path}: cannot be written: {error.strerror}") from error


def read_json(path):
    """A JSON object; lines that begin with // are comments, as in the presets."""
    try:
        text = pathlib.Path(path).read_text(encoding="utf-8")
        document = json.loads(re.sub(r"(?m)^\s*//.*$", "", text))
    except (OSError, ValueError) as error:
        raise UserError(f"{path}: no readable JSON: {error}") from error
    if not isinstance(document, dict):
        raise UserError(f"{path}: must be a JSON object in braces")
    return document


def read_csv(path, columns):
    """Rows of a CSV file as dictionaries; none if there is no file."""
    try:
        with open(path, encoding="utf-8", newline="") as stream:
            reader = csv.DictReader(stream)
            rows = list(reader)
    except FileNotFoundError:
        return []
    except (OSError, ValueError, csv.Error) as error:
        raise UserError(f"{path}: cannot be read: {error}") from error
    missing = [name for name in columns if name not in (reader.fieldnames or [])]
    if missing:
        raise UserError(f"{path}:1: the column {missing[0]} is missing; it must have {','.join(columns)}")
    return rows


def append_csv(path, columns, rows):
    """The file with more rows; what was in it stays. Rows are dictionaries."""
    out = io.StringIO()
    writer = csv.DictWriter(out, columns, lineterminator="\n", extrasaction="ignore", restval="")
    writer.writeheader()
    writer.writerows(read_csv(path, columns))
    writer.writerows(rows)
    write_whole(path, out.getvalue())
