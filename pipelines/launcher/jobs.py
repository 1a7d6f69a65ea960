"""What runs beside the window: one session at a time, and one report at a time behind it."""
import os
import re
import subprocess

import sessions
from files import UserError


# Not what the shell says of a program that was killed.
ERROR = re.compile(r"(acus-[a-z]+|pipelines/live-session): (?!warning|line \d)")


class Jobs:
    """Starts pipelines/live-session. Processes have a session of their own: closing or killing the launcher ends
    no recording. What they print goes to launcher.log in the workplace."""

    def __init__(self, live_session, folder, options):
        self.live_session = str(live_session)
        self.folder = folder
        self.options = list(options)  # Of every session, such as --headless.
        self.log = folder / "launcher.log"
        self.session = None
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

    def _said(self, process):
        """What a process printed from its first error message on, at most five lines; without that, nothing."""
        with open(self.log, "rb") as log:
            log.seek(process.begin)
            lines = log.read()[-4000:].decode(errors="replace").replace("\r", "\n").strip().splitlines()
        errors = [place for place, line in enumerate(lines) if ERROR.match(line)]
        return "\n".join(lines[errors[0]:][-5:]) if errors else ""

    def start_session(self, trainee, exercise, limit_s=None, left_handed=False):
        if self.session is not None:
            raise UserError("A session is running; end it first.")
        sessions.check_code(trainee)
        words = ["--no-report", "--trainee", trainee, "--exercise", exercise]
        if left_handed:
            words.append("--left-handed")
        if limit_s is not None:
            words += ["--duration", f"{limit_s:g}"]
        self.session = self._start([*words, *self.options])  # The last --duration counts.

    def start_check(self):
        """Checks files, patient, registration and devices, and runs the devices for a second."""
        if self.session is None and self.check is None:
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
        ended = []
        for kind in ("session", "check", "report"):
            process = getattr(self, kind)
            if process is None or process.poll() is None:
                continue
            setattr(self, kind, None)
            said = self._said(process)
            if kind == "report":
                if process.returncode != 0:
                    self.failed[self.reported] = said
                self.reported = None
            ended.append((kind, process.returncode, said))
        if self.report is None and self.queue:
            self.reported = self.queue.pop(0)
            # A session that runs meanwhile has the processor first.
            self.report = self._start(["--report", self.reported], before=idle())
        return ended


def idle():
    """Words before a command that runs only where nothing else wants to."""
    return ("chrt", "--idle", "0") if os.path.exists("/usr/bin/chrt") else ("nice", "-n", "19")
