"""What a cohort is made from: participants, their sessions and the files of each."""
import pathlib
import re

from files import UserError, read_tsv

KINDS = ("phantom", "ct", "labels", "label_mapping", "atlas", "phases", "force_curves", "markers_ct",
         "markers_mannequin", "target", "corridor", "recording", "scenario")
SINGLE = ("phantom", "ct", "labels", "label_mapping", "atlas", "phases", "markers_ct", "markers_mannequin",
          "target", "corridor")
COLUMNS = ("participant_id", "session_id", "kind", "path", "seed", "series")
LABEL = re.compile(r"[A-Za-z0-9]+")


def _label(value, prefix, where):
    value = value.removeprefix(prefix)
    if not LABEL.fullmatch(value):
        raise UserError(f"{where}: '{prefix}{value}': letters and digits are allowed after {prefix}")
    return prefix + value


def _from_table(folder, table):
    """Yields (participant, session, kind, path or preset, seed, series) of the rows of cohort.tsv."""
    header, rows = read_tsv(table)
    for name in ("participant_id", "kind", "path"):
        if name not in header:
            raise UserError(f"{table}: column {name} is missing; there is {', '.join(header)}")
    unknown = [name for name in header if name not in COLUMNS]
    if unknown:
        raise UserError(f"{table}: unknown column {unknown[0]}; allowed: {', '.join(COLUMNS)}")
    for number, row in enumerate(rows, 2):
        where = f"{table}, line {number}"
        if row["kind"] not in KINDS:
            raise UserError(f"{where}: kind '{row['kind']}'; allowed: {', '.join(KINDS)}")
        seed = row.get("seed", "")
        if seed and not seed.isdigit():
            raise UserError(f"{where}: seed '{seed}'; allowed: whole numbers from 0")
        yield (_label(row["participant_id"], "sub-", where),
               _label(row.get("session_id") or "01", "ses-", where), row["kind"],
               row["path"], int(seed) if seed else None, row.get("series", ""), where)


def _from_layout(folder):
    """The same of the files sub-LABEL/ses-LABEL/KIND/NAME; ses-LABEL may be missing."""
    for subject in sorted(p for p in folder.glob("sub-*") if p.is_dir()):
        sessions = sorted(p for p in subject.glob("ses-*") if p.is_dir()) or [subject]
        for session in sessions:
            name = session.name if session != subject else "ses-01"
            for kind in KINDS[1:]:  # A phantom is no file.
                for path in sorted((session / kind).glob("*")):
                    if path.name.startswith(".") or (path.suffix == ".json" and kind != "scenario"):
                        continue  # A sidecar.
                    where = str(path)
                    yield (_label(subject.name, "sub-", where), _label(name, "ses-", where), kind,
                           str(path.relative_to(folder)), None, "", where)


def read_sources(folder):
    """{participant: {session: {kind: [entry]}}}; an entry has path, seed, series.

    A file cohort.tsv of the folder names every file, wherever it is; it is the only place where
    participant ids and names of files meet. Without it, the folder's own layout is read.
    @throws UserError with the place of what is wrong.
    """
    folder = pathlib.Path(folder)
    if not folder.is_dir():
        raise UserError(f"{folder}: no such folder")
    table = folder / "cohort.tsv"
    entries = _from_table(folder, table) if table.exists() else _from_layout(folder)
    people = {}
    for subject, session, kind, path, seed, series, where in entries:
        files = people.setdefault(subject, {}).setdefault(session, {})
        if kind == "phantom":
            found = path  # lumbar, liver, or one of them with a config: lumbar:FILE
        else:
            found = (folder / path).resolve()
            if kind != "scenario" and not found.exists():
                found = folder / path  # Reported by the job, so that the others go on.
        files.setdefault(kind, []).append({"path": str(found), "seed": seed, "series": series})
        if kind in SINGLE and len(files[kind]) > 1:
            raise UserError(f"{where}: a second {kind} of {subject} {session}; there may be one. "
                            "Another session (session_id) may have another")
    if not people:
        raise UserError(f"{folder}: no cohort.tsv and no sub-LABEL folders with one of "
                        f"{', '.join(KINDS)} inside")
    if (folder / "participants.tsv").exists():
        header, rows = read_tsv(folder / "participants.tsv")
        if "participant_id" not in header:
            raise UserError(f"{folder}/participants.tsv: column participant_id is missing")
        listed = {_label(r["participant_id"], "sub-", "participants.tsv") for r in rows}
        for subject in people:
            if subject not in listed:
                raise UserError(f"{folder}/participants.tsv: {subject} has files, but no row")
        for subject in listed - people.keys():
            raise UserError(f"{folder}/participants.tsv: {subject} has a row, but no files")
    return dict(sorted(people.items()))
