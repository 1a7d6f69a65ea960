"""The test cases of a build, and which mutants each of them reaches."""
import json
import os
import pathlib
import re
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

    def explore(self, folder, store, limit_s):
        """Runs without a mutant, unless the store has what came of it. @return does it pass in time?"""
        if store and store.recall(self):
            return True
        file = pathlib.Path(folder) / f"{threading.get_ident()}.reached"
        file.write_bytes(bytes(MOST))
        begin = time.monotonic()
        passed = self.run(min(self.limit_s, limit_s), MUTANT_REACHED=str(file))
        self.seconds = time.monotonic() - begin
        self.reached = file.read_bytes()
        file.unlink()
        if passed and store:
            store.remember(self)
        return passed is True


class Store:
    """What cases reached, for as long as their programs stay the same."""

    def __init__(self, folder):
        self.build = pathlib.Path(folder)
        self.folder = self.build / "explored"
        self.folder.mkdir(exist_ok=True)
        self.newest = max((path.stat().st_mtime_ns for path in (self.build / "bin").glob("*")), default=0)

    def stamp(self, case):
        program = pathlib.Path(case.command[0])
        own = program.is_relative_to(self.build) and program.exists()
        return str(program.stat().st_mtime_ns if own else self.newest)

    def file(self, case):
        return self.folder / (re.sub(r"\W", "_", case.name) + ".json")

    def recall(self, case):
        if not self.file(case).exists():
            return False
        kept = json.loads(self.file(case).read_text(encoding="utf-8"))
        if kept["stamp"] != self.stamp(case):
            return False
        reached = bytearray(MOST)
        for state in (REACHED, IMPOSSIBLE):
            for number in kept[str(state)]:
                reached[number] = state
        case.reached, case.seconds = bytes(reached), kept["seconds"]
        return True

    def remember(self, case):
        kept = {"stamp": self.stamp(case), "seconds": case.seconds}
        for state in (REACHED, IMPOSSIBLE):
            kept[str(state)] = [number for number, value in enumerate(case.reached) if value == state]
        self.file(case).write_text(json.dumps(kept), encoding="utf-8")


def read_cases(build, labels):
    # CTest's exit code says whether all programs are built: those that are not have no command.
    described = subprocess.run(["ctest", "--test-dir", str(build), "--show-only=json-v1"], check=False,
                               capture_output=True, text=True).stdout
    cases = [Case(entry) for entry in json.loads(described)["tests"]]
    return [case for case in cases if case.command and set(labels) & set(case.labels)]
