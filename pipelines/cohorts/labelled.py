"""The labelled images of a cohort's replays as one data set, split by participant."""
from files import UserError, read_json, sha256_of_text, write_json

NAMES = ("train", "validation", "test")


def shares_of(text):
    """[0.7, 0.15, 0.15] of "0.7,0.15,0.15"."""
    try:
        shares = [float(word) for word in text.split(",")]
    except ValueError:
        shares = []
    if len(shares) != 3 or not all(0 <= s <= 1 for s in shares) or abs(sum(shares) - 1) > 1e-6:
        raise UserError(f"--splits {text}: give the shares of train, validation and test, which add up "
                        "to 1, such as 0.7,0.15,0.15")
    return shares


def split(people, shares, seed):
    """Participants by split: shuffled by the seed, numbers by the shares, at least one for each share
    above 0 as far as there are participants."""
    order = sorted(people, key=lambda one: sha256_of_text(f"{seed} {one}"))
    sizes = [0, 0, 0]
    for n in sorted(range(3), key=lambda n: -shares[n])[:len(order)]:
        sizes[n] = 1 if shares[n] > 0 else 0
    while sum(sizes) < len(order):
        sizes[max(range(3), key=lambda n: shares[n] * len(order) - sizes[n])] += 1
    ends = [sum(sizes[:n + 1]) for n in range(3)]
    return {name: sorted(order[end - size:end]) for name, size, end in zip(NAMES, sizes, ends)}


def write(output, runs, shares, seed):
    """Writes group/labelled.json for the replays that have labelled images."""
    rows = []
    for run in runs:
        document = output / run["run"] / "labelled/labelled.json"
        if document.exists():
            rows.append((run, read_json(document)))
    splits = split({run["participant_id"] for run, _ in rows}, shares, seed)
    split_of = {one: name for name, people in splits.items() for one in people}
    classes = {c["value"]: c for _, document in rows for c in document["classes"]}
    sequences = [{"folder": f"{run['run']}/labelled", "patient": run["participant_id"],
                  "split": split_of[run["participant_id"]], "session": run["session_id"],
                  "files": document["files"], "frames": document["frames"]} for run, document in rows]
    frames = {name: sum(s["frames"] for s in sequences if s["split"] == name) for name in NAMES}
    write_json(output / "group/labelled.json", {
        "format": "acus-dataset-manifest/1", "seed": seed, "splits": splits, "frames": frames,
        "classes": [classes[value] for value in sorted(classes)], "sequences": sequences})
