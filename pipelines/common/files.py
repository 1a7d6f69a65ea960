"""Files of scripts: read with messages that say what is wrong, written whole or not at all."""
import csv
import hashlib
import io
import json
import os
import pathlib
import re


class UserError(Exception):
    """What the user can mend: one message with file, value, what is allowed, what to try."""


def sha256_of(path):
    """SHA-256 of a file's bytes, or of a folder's files (relative names and hashes), as hex."""
    path = pathlib.Path(path)
    digest = hashlib.sha256()
    if path.is_dir():
        for file in sorted(p for p in path.rglob("*") if p.is_file()):
            digest.update(f"{file.relative_to(path)}\n{sha256_of(file)}\n".encode())
        return digest.hexdigest()
    with open(path, "rb") as stream:
        while block := stream.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()


def sha256_of_text(text):
    return hashlib.sha256(text.encode()).hexdigest()


def write_whole(path, text):
    """Writes a text file completely or not at all, and puts it on the medium."""
    path = pathlib.Path(path)
    partial = path.with_name(f".partial-{os.getpid()}-{path.name}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            with open(partial, "w", encoding="utf-8", newline="") as stream:
                stream.write(text)
                stream.flush()
                os.fsync(stream.fileno())
            os.replace(partial, path)
        finally:
            partial.unlink(missing_ok=True)
        folder = os.open(path.parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)
    except OSError as error:
        raise UserError(f"{path}: cannot be written: {error.strerror}") from error


def write_json(path, document):
    write_whole(path, json.dumps(document, indent=2, sort_keys=True) + "\n")


def read_json(path):
    """A JSON file; lines that begin with // are comments, as in the presets."""
    try:
        text = pathlib.Path(path).read_text(encoding="utf-8")
        return json.loads(re.sub(r"(?m)^\s*//.*$", "", text))
    except (OSError, ValueError) as error:
        raise UserError(f"{path}: no readable JSON: {error}") from error


def read_json_object(path):
    document = read_json(path)
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


def read_tsv(path):
    """Rows of a table with a header, separated by tabs, as dictionaries; 'n/a' is an empty cell."""
    try:
        lines = pathlib.Path(path).read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise UserError(f"{path}: cannot be read: {error}") from error
    lines = [line for line in lines if line.strip()]
    if not lines:
        raise UserError(f"{path}: is empty; the first line names the columns")
    header = lines[0].split("\t")
    rows = []
    for number, line in enumerate(lines[1:], 2):
        cells = line.split("\t")
        if len(cells) > len(header):
            raise UserError(f"{path}, line {number}: {len(cells)} cells, but {len(header)} columns")
        cells += [""] * (len(header) - len(cells))
        rows.append({name: "" if cell == "n/a" else cell for name, cell in zip(header, cells)})
    return header, rows


def write_tsv(path, header, rows):
    """A table that R (read.delim) and pandas (read_csv, sep='\\t') read: missing values are n/a."""
    def cell(value):
        if value is None or value == "":
            return "n/a"
        return repr(value) if isinstance(value, float) else re.sub(r"\s+", " ", str(value))
    lines = ["\t".join(header)] + ["\t".join(cell(row.get(h)) for h in header) for row in rows]
    write_whole(path, "\n".join(lines) + "\n")
