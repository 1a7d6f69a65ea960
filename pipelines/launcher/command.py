"""The command line of pipelines/training-day."""
import argparse
import fcntl
import os
import pathlib

import jobs
import sessions
import texts
import user
import workplace
from files import UserError

ROOT = pathlib.Path(__file__).resolve().parents[2]
EPILOG = """example:
  pipelines/live-session --new ~/Acus
  pipelines/training-day ~/Acus
  pipelines/training-day --list ~/Acus
"""


def parse(arguments):
    parser = argparse.ArgumentParser(
        prog="pipelines/training-day", epilog=EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter,
        description="A window for a day of sessions: choose a trainee, press Start, and so on. It shows the next "
                    "exercise of the curriculum (curriculum.json of the workplace) and asks for consent and the "
                    "questionnaires of the study (study.json). Sessions are repeated or discarded with a reason; "
                    "none is deleted. Sessions that were left without an end, or without a report, get one.")
    parser.add_argument("workplace", nargs="?", type=pathlib.Path, default=pathlib.Path.home() / "Acus",
                        help="folder of pipelines/live-session --new; default ~/Acus")
    parser.add_argument("--list", action="store_true", help="print trainees and sessions, open no window")
    parser.add_argument("--language", choices=texts.languages(), help="words of the window; default: as LANG says")
    parser.add_argument("--demo", action="store_true", help="of every session: virtual hands repeat a recording")
    parser.add_argument("--headless", action="store_true", help="of every session: without its window")
    parser.add_argument("--duration", type=float, metavar="S", help="of every session: ends after so many seconds")
    return parser.parse_args(arguments)


def list_day(place):
    found = sessions.find(place.folder)
    codes = place.trainees(found)
    steps = place.steps(codes, found)
    for code in codes:
        following = steps[code][1]
        print(f"{code}: next: {place.exercises[following] if following else '-'}")
        for step in steps[code][0]:
            print(f"  {step.state:9} {step.trials:3} trials  {step.title}")
        for session in found:
            if session.trainee == code:
                print(f"  {session.day} {session.time}  {session.exercise}  {session.state.value}  {session.goals}"
                      f"{'  ' + session.reason if session.reason else ''}")


def lock(folder):
    """One launcher for a workplace; the lock ends with the process, however that ends."""
    stream = open(folder / ".training-day", "w", encoding="utf-8")  # pylint: disable=consider-using-with
    try:
        fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        raise UserError(f"{folder} is open in another window of pipelines/training-day; use that one") from error
    os.set_inheritable(stream.fileno(), False)
    return stream


def open_window(place, options):
    try:
        import tkinter
        import window
    except ImportError as error:
        raise UserError(f"the window needs Tk for Python: install the package python3-tk ({error})") from error
    held = lock(place.folder)
    beside = jobs.Jobs(ROOT / "pipelines/live-session", place.folder, ["--headless"] if options.headless else [],
                       demo=options.demo, duration_s=options.duration)
    try:
        shown = window.Window(place, beside, texts.Texts(options.language))
    except tkinter.TclError as error:
        raise UserError(f"there is no screen to open a window on: {error}; log in at the desktop") from error
    shown.mainloop()
    held.close()


def run(options):
    os.environ["ACUS_BIN"] = str(texts.program_folder())
    configs = pathlib.Path(os.environ.get("ACUS_CONFIGS", ROOT / "configs"))
    place = workplace.Workplace(options.workplace, texts.program_folder(), configs)
    if options.list:
        list_day(place)
    else:
        open_window(place, options)
    return 0


def main(arguments):
    return user.call("pipelines/training-day", run, parse(arguments))
