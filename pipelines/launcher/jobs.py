"""What runs beside the window: one session at a time, and one report at a time behind it."""
import os
import re
import subprocess

import live
import sessions
from files import UserError, read_json_object


# Not what the shell says of a program that was killed.
ERROR = re.compile(r"(acus-[a-z]+|pipelines/live-session): (?!warning|line \d)")


class Jobs:
    """Starts pipelines/live-session: one for all sessions, and one for each report. Processes have a session of
    their own: closing or killing the launcher ends no recording. What they print goes to launcher.log in the
    workplace."""

    def __init__(self, live_session, folder, options, demo=False, duration_s=None):
        """options: of pipelines/live-session --requests, such as --headless. demo: virtual hands repeat what was
        recorded with the patient. duration_s: of every session."""
        self.live_session = str(live_session)
        self.folder = folder
        self.options = list(options)
        self.demo = demo
        self.duration_s = duration_s
        self.log = folder / "launcher.log"
        self.live = live.Live([self.live_session, "--text", "--requests", *self.options, str(folder)], self.log)
        self.session = None  # The folder of the one that runs.
        self.waiting = None  # The request for it, while the devices are checked.
        self.check = None
        self.report = None
        self.reported = None  # The folder of the running report.
        self.queue = []
        self.failed = {}  # Folder: what was printed. Not tried again by itself.

    def _start(self, words, before=()):
        try:
            with open(self.log, "ab") as log:
                begin = log.tell()
                process = subprocess.Popen([*before, self.live_session, "--text", *map(str, words), str(self.folder)],
                                           stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True)
        except OSError as error:
            raise UserError(f"{self.live_session}: cannot be started: {error.strerror}") from error
        process.begin = begin
        return process

    def _said(self, begin):
        """What a process printed from its first error message on, at most five lines; without that, nothing."""
        with open(self.log, "rb") as log:
            log.seek(begin)
            lines = log.read()[-4000:].decode(errors="replace").replace("\r", "\n").strip().splitlines()
        errors = [place for place, line in enumerate(lines) if ERROR.match(line)]
        return "\n".join(lines[errors[0]:][-5:]) if errors else ""

    def start_session(self, trainee, exercise, trial=1, limit_s=None, left_handed=False, caption=""):
        """trial: which one of this exercise it is for the trainee. caption: below the exercise's name."""
        if self.session is not None:
            raise UserError("A session is running; end it first.")
        sessions.check_code(trainee)
        request = {"exercise": str(self.folder / "exercises" / f"{exercise}.json"), "trial": trial,
                   "left_handed": left_handed, "caption": caption, "scenario": str(self._scenario_of(exercise)),
                   "duration_s": (self.duration_s if self.duration_s is not None else limit_s) or 0.0}
        if self.demo:
            request["hand"] = str(self._recorded())
        self.session = sessions.make_folder(self.folder, trainee, exercise)
        request["output"] = str(self.session)
        if self.check is not None:
            self.waiting = request
        else:
            self.live.ask(request)

    def _scenario_of(self, exercise):
        """That of the exercise's file, if it is there; else that of the workplace."""
        file = self.folder / "exercises" / f"{exercise}.json"
        named = str(read_json_object(file).get("scenario", ""))
        own = (file.parent / named).resolve()
        return own if named and own.is_file() else self.folder / "scenario.json"

    def _recorded(self):
        found = sorted((self.folder / "patient" / "sessions").glob("*"))
        if not found:
            raise UserError(f"There is no recorded session in {self.folder}/patient/sessions.")
        return found[0]

    def start_check(self):
        """Checks files, patient, registration and devices, and runs the devices for a second. Then they are opened
        for the sessions."""
        if self.session is None and self.check is None:
            self.live.close()
            headless = [word for word in self.options if word == "--headless"]
            self.check = self._start(["--check", "--duration", "1", *headless])

    def finish(self, found):
        """Puts sessions that lack a report into the queue; again is no harm. While a session runs here, one
        without an end may be that one."""
        for session in sessions.to_finish(found):
            if self.session is not None and session.state is sessions.State.NO_END:
                continue
            if session.folder not in (*self.queue, *self.failed, self.reported):
                self.queue.append(session.folder)

    def remake_progress(self, session):
        """After a session was discarded: the trainee's progress without it."""
        self.queue.append(session.folder)

    @property
    def num_reports(self):
        return len(self.queue) + (self.report is not None)

    def poll(self):
        """What has ended since the last call: ("session" | "check" | "report", exit code, last lines)."""
        ended = [*self._poll_live(), *self._poll_check(), *self._poll_report()]
        if self.report is None and self.queue:
            self.reported = self.queue.pop(0)
            # A session that runs meanwhile has the processor first.
            self.report = self._start(["--report", self.reported], before=idle())
        return ended

    def close(self):
        """@pre no session runs."""
        self.live.close()

    def _poll_live(self):
        ended = []
        for event in self.live.events():
            if event["event"] in ("ended", "refused") and self.session is not None:
                ended.append(self._end_session(event["code"], event["message"] if event["code"] else ""))
        begin, code = self.live.begin, self.live.ended()
        if code is not None and self.session is not None:
            ended.append(self._end_session(code, self._said(begin)))
        return ended

    def _end_session(self, code, said):
        folder, self.session = self.session, None
        if not (folder / "session.json").exists():
            try:
                folder.rmdir()  # It did not begin.
            except OSError:
                pass
        return "session", code, said

    def _poll_check(self):
        if self.check is None or self.check.poll() is None:
            return []
        process, self.check = self.check, None
        request, self.waiting = self.waiting, None
        if request is not None:
            self.live.ask(request)
        elif process.returncode == 0:
            self.live.open()
        return [("check", process.returncode, self._said(process.begin))]

    def _poll_report(self):
        if self.report is None or self.report.poll() is None:
            return []
        process, self.report = self.report, None
        said = self._said(process.begin)
        if process.returncode != 0:
            self.failed[self.reported] = said
        self.reported = None
        return [("report", process.returncode, said)]


def idle():
    """Words before a command that runs only where nothing else wants to."""
    return ("chrt", "--idle", "0") if os.path.exists("/usr/bin/chrt") else ("nice", "-n", "19")
