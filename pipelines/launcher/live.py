"""acus-live of the day: devices and window stay open from one session to the next."""
import json
import os
import subprocess

from files import UserError

CLOSE_S = 5.0


class Live:
    """pipelines/live-session --requests, which is started when it is needed. It has a session of its own: closing
    or killing the launcher ends no recording, only the requests; then it ends by itself."""

    def __init__(self, command, log):
        self.command = command
        self.log = log
        self.process = None
        self.begin = 0  # Of what it prints to the log.
        self._pending = b""

    def is_running(self):
        return self.process is not None and self.process.poll() is None

    def open(self):
        """Opens the devices and the window, if they are not open."""
        if self.is_running():
            return
        try:
            with open(self.log, "ab") as log:
                self.begin = log.tell()
                self.process = subprocess.Popen(self.command, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                                stderr=log, start_new_session=True)
        except OSError as error:
            raise UserError(f"{self.command[0]}: cannot be started: {error.strerror}") from error
        os.set_blocking(self.process.stdout.fileno(), False)
        self._pending = b""

    def ask(self, request):
        """Requests a session (acus-session-request); opens devices and window first if need be."""
        self.open()
        line = json.dumps({"format": "acus-session-request/1", **request}) + "\n"
        try:
            self.process.stdin.write(line.encode())
            self.process.stdin.flush()
        except BrokenPipeError:
            pass  # It has just ended; ended() says so.

    def events(self):
        """What has been printed since the last call: dictionaries with the key event."""
        if self.process is None:
            return []
        self._pending += self.process.stdout.read() or b""
        *lines, self._pending = self._pending.split(b"\n")
        found = []
        for line in lines:
            try:
                event = json.loads(line)
            except ValueError:
                continue  # Not of acus-live.
            if isinstance(event, dict) and "event" in event:
                found.append(event)
        return found

    def ended(self):
        """The exit code, once, if it has ended by itself; else None."""
        if self.process is None or self.process.poll() is None:
            return None
        code = self.process.returncode
        self._forget()
        return code

    def close(self):
        """Closes devices and window. @pre no session runs."""
        if self.process is None:
            return
        try:
            self.process.stdin.close()
        except BrokenPipeError:
            pass
        try:
            self.process.wait(CLOSE_S)
        except subprocess.TimeoutExpired:
            self.process.terminate()
            self.process.wait()
        self._forget()

    def _forget(self):
        for stream in (self.process.stdin, self.process.stdout):
            try:
                stream.close()
            except BrokenPipeError:
                pass
        self.process = None
