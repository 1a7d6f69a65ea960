"""Messages of Snakemake as a person wants them: done, failed, left, time to go."""
import json
import os
import time

from wording import duration

_state = {"begin": time.monotonic(), "done": 0, "failed": set(), "last": 0.0, "names": {},
          "seconds_done": 0.0}
# {"todo": {job: predicted seconds}, "quiet": bool}, and where to write.
with open(os.environ["ACUS_PROGRESS"], encoding="utf-8") as _stream:
    _plan = json.load(_stream)
_out = os.fdopen(int(os.environ["ACUS_PROGRESS_TO"]), "w", closefd=False)


def _line():
    todo = _plan["todo"]
    total = sum(todo.values()) or 1.0
    without = sum(todo[n] for n in _blocked() | _state["failed"])
    left = max(0.0, total - _state["seconds_done"] - without)
    elapsed = time.monotonic() - _state["begin"]
    to_go = ""
    if _state["done"] and _state["seconds_done"] > 0:
        to_go = f", {duration(elapsed * left / _state['seconds_done'])} to go"
    failed = len(_state["failed"])
    missing = len(todo) - _state["done"] - failed - len(_blocked())
    return f"{_state['done']} done, {failed} failed, {missing} left{to_go}"


def _blocked():
    """Jobs that wait for one that failed."""
    out = set()
    for name, parents in _plan["parents"].items():  # In an order in which parents come first.
        if any(p in out or p in _state["failed"] for p in parents):
            out.add(name)
    return out


def _name(message):
    wildcards = message.get("wildcards") or {}
    return str(wildcards.get("job", "")).rpartition(".")[0]


def log_handler(message):
    level = message["level"]
    if level == "job_info":
        name = _name(message)
        _state["names"][message["jobid"]] = name
        if name in _plan["titles"]:
            print("== {}\n   {}".format(*_plan["titles"][name]), file=_out, flush=True)
    elif level == "job_finished":
        name = _state["names"].get(message["jobid"], "")
        if name in _plan["todo"]:
            _state["done"] += 1
            _state["failed"].discard(name)
            _state["seconds_done"] += _plan["todo"][name]
    elif level == "job_error":
        name = _state["names"].get(message.get("jobid"), "")
        if name:
            _state["failed"].add(name)
    elif level == "error" and "Traceback" in str(message.get("msg", "")):
        print(message["msg"], file=_out, flush=True)
    now = time.monotonic()
    if level in ("job_finished", "job_error") and not _plan["quiet"] and (
            now - _state["last"] > 1.0 or _state["done"] + len(_state["failed"]) == len(_plan["todo"])):
        _state["last"] = now
        print(_line(), file=_out, flush=True)
