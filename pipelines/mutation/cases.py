"""The test cases of a build, and which mutants each of them reaches."""
import json
import os
import pathlib
import signal
import subprocess
import threading
import time

MOST = 65536  # kMost of mutant.h.
REACHED, IMPOSSIBLE = 1, 2


class Case:
    def __init__(self, described):
        properties = {entry["name"]: entry["value"] for entry in described.get("properties", [])}
        self.name = described["name"]
        self.command = described.get("command", [])
        self.labels = properties.get("LABELS", [])
        self.folder = properties.get("WORKING_DIRECTORY", ".")
        self.environment = dict(entry.split("=", 1) for entry in properties.get("ENVIRONMENT", []))
        self.will_fail = properties.get("WILL_FAIL", False)
        self.prepares = "FIXTURES_SETUP" in properties
        self.limit_s = float(properties.get("TIMEOUT", 300.0))
        self.seconds = 0.0
        self.reached = b""
        self.turn = threading.Lock()  # A case writes into a folder of its own.

    def run(self, limit_s, **environment):
        """Does it pass? None: it does not end in time."""
        given = {**os.environ, "OPENBLAS_NUM_THREADS": "1", **self.environment, **environment}
        with self.turn, subprocess.Popen(self.command, cwd=self.folder, env=given, stdin=subprocess.DEVNULL,
                                         stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                         start_new_session=True) as process:
            try:
                return (process.wait(timeout=limit_s) == 0) != self.will_fail
            except subprocess.TimeoutExpired:
                return None
            finally:
                try:
                    os.killpg(process.pid, signal.SIGKILL)
                except ProcessLookupError:
                    pass

    def explore(self, folder):
        """Runs without a mutant. @return does it pass?"""
        file = pathlib.Path(folder) / f"{threading.get_ident()}.reached"
        file.write_bytes(bytes(MOST))
        begin = time.monotonic()
        passed = self.run(self.limit_s, MUTANT_REACHED=str(file))
        self.seconds = time.monotonic() - begin
        self.reached = file.read_bytes()
        file.unlink()
        return passed is True


def read_cases(build, labels):
    # CTest's exit code says whether all programs are built: those that are not have no command.
    described = subprocess.run(["ctest", "--test-dir", str(build), "--show-only=json-v1"], check=False,
                               capture_output=True, text=True).stdout
    cases = [Case(entry) for entry in json.loads(described)["tests"]]
    return [case for case in cases if case.command and set(labels) & set(case.labels)]
