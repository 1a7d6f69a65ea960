"""The sessions of a workplace, as its folders show them: nothing else is kept, so nothing else can be lost."""
import dataclasses
import datetime
import enum
import json
import os
import pathlib
import re

from files import UserError, read_json_object, write_whole

# TIME_EXERCISE, or TIME.N_EXERCISE for the next ones of the same second: pipelines/live-session.
NAME = re.compile(r"(\d{4}-\d{2}-\d{2})_(\d{2}-\d{2}-\d{2})(?:\.\d+)?_(.+)")
CODE = re.compile(r"[A-Za-z0-9_-]+")


class State(enum.Enum):
    RUNNING = "running"
    NO_END = "no_end"  # Killed, or the power failed: recorded, not summarized.
    NO_REPORT = "no_report"
    DONE = "done"
    RECOVERED = "recovered"  # Without an end, reported later.
    DISCARDED = "discarded"


@dataclasses.dataclass(frozen=True)
class Session:
    folder: pathlib.Path
    trainee: str
    exercise: str
    day: str
    time: str
    state: State
    reason: str = ""  # Why it was discarded.
    goals: str = ""  # Met and all, such as 5/7.

    @property
    def report(self):
        return self.folder / "report" / "report.html"


def check_code(code):
    if not CODE.fullmatch(code):
        raise UserError(f"The code '{code}' may only hold letters from a to z and A to Z, digits, '-' and '_'. A code, not a name.")


def folders_in_use(root):
    """Folders below root in which a running process of this user has a file open."""
    found = set()
    for link in pathlib.Path("/proc").glob("[0-9]*/fd/*"):
        try:
            target = os.readlink(link)
        except OSError:
            continue  # It has ended, or belongs to another user.
        if target.startswith(f"{root}/"):
            found.add(pathlib.Path(target).parent)
    return found


def goals_of(folder):
    """Goals met, as text; nothing without a report that can be read."""
    try:
        goals = read_json_object(folder / "report" / "training.json")["goals"]
        return f"{sum(bool(goal['met']) for goal in goals)}/{len(goals)}"
    except (UserError, KeyError, TypeError):
        return ""


def state_of(folder, in_use):
    if (folder / "discarded.json").exists():
        return State.DISCARDED
    ended = (folder / "summary.json").exists()
    if (folder / "report" / "training.json").exists():
        return State.DONE if ended else State.RECOVERED
    if ended:
        return State.NO_REPORT
    return State.RUNNING if folder in in_use else State.NO_END


def find(workplace):
    """All sessions of a workplace, oldest first. Folders without a recording are no sessions."""
    root = (pathlib.Path(workplace) / "sessions").resolve()
    files = [(file.parent, NAME.fullmatch(file.parent.name)) for file in root.glob("*/*/session.json")]
    in_use = None
    found = []
    for folder, name in files:
        if not name:
            continue
        if in_use is None and not (folder / "summary.json").exists():
            in_use = folders_in_use(root)
        state = state_of(folder, in_use or set())
        reason = ""
        if state is State.DISCARDED:
            try:
                reason = str(read_json_object(folder / "discarded.json").get("reason", ""))
            except UserError:
                pass  # That the file is there is what counts.
        found.append(Session(folder, folder.parent.name, name[3], name[1], name[2].replace("-", ":"), state, reason,
                             goals_of(folder)))
    return sorted(found, key=lambda session: (session.day, session.time, session.folder.name))


def make_folder(workplace, trainee, exercise, now=None):
    """The folder of a new session, made in one call: two starts in one second get two folders."""
    begun = (now or datetime.datetime.now()).strftime("%Y-%m-%d_%H-%M-%S")
    for number in range(1, 101):
        name = begun if number == 1 else f"{begun}.{number}"
        folder = pathlib.Path(workplace).resolve() / "sessions" / trainee / f"{name}_{exercise}"
        try:
            folder.mkdir(parents=True)
            return folder
        except FileExistsError:
            continue
        except OSError as error:
            raise UserError(f"{folder}: cannot be made: {error.strerror}") from error
    raise UserError(f"{folder}: is there already, as are 99 others of this second; try again")


def to_finish(sessions):
    """Those that lack a report: recorded without one, or left without an end."""
    return [session for session in sessions if session.state in (State.NO_REPORT, State.NO_END)]


def discard(session, reason, now=None):
    """Marks a session: it stays where it is, and counts nowhere. @throws UserError without a reason."""
    reason = reason.strip()
    if not reason:
        raise UserError("A session is discarded with a reason.")
    if session.state is State.RUNNING:
        raise UserError("A running session cannot be discarded; end it first.")
    if session.state is State.DISCARDED:
        raise UserError(f"This session was discarded already: {session.reason}")
    now = now or datetime.datetime.now()
    write_whole(session.folder / "discarded.json",
                json.dumps({"format": "acus-discarded/1", "reason": reason,
                            "time": now.isoformat(timespec="seconds")}, indent=2, ensure_ascii=False) + "\n")
