"""The whole run as a Workflow Run RO-Crate: profiles Process, Workflow and Provenance Run Crate 0.5."""
import datetime
import json
import mimetypes
import pathlib

import plan as plans
from files import UserError, read_json, sha256_of, write_json

PROFILES = [f"https://w3id.org/ro/wfrun/{name}/0.5" for name in ("process", "workflow", "provenance")]
CONTEXT = ["https://w3id.org/ro/crate/1.1/context",
           "https://w3id.org/ro/terms/workflow-run/context",
           {"sha256": "https://w3id.org/ro/terms/workflow-run#sha256"}]


def ref(*names):
    found = [{"@id": name} for name in names]
    return found[0] if len(found) == 1 else found


def _file(path, sha256, size=None):
    entity = {"@id": path, "@type": "File", "name": path.rpartition("/")[2], "sha256": sha256}
    if size is not None:
        entity["contentSize"] = str(size)
    kind = mimetypes.guess_type(path)[0]
    if kind:
        entity["encodingFormat"] = kind
    return entity


def _time(seconds):
    return datetime.datetime.fromtimestamp(seconds, datetime.timezone.utc).isoformat(timespec="seconds")


def _tools(rules):
    for rule in plans.RULES:
        if rule in rules:
            name, version = rules[rule]
            yield {"@id": f"#{rule}", "@type": "SoftwareApplication", "name": name,
                   "softwareVersion": version}
            yield {"@id": f"#step-{rule}", "@type": "HowToStep", "name": rule, "workExample": ref(f"#{rule}"),
                   "position": str(plans.RULES.index(rule))}


def _action(output, job, record, entities):
    """One program's run; its files go to `entities`."""
    name = f"#action-{job['id']}"
    action = {"@id": name, "@type": "CreateAction", "name": record["Description"],
              "description": " ".join(record["Command"]), "instrument": ref(f"#{job['rule']}"),
              "actionStatus": "http://schema.org/CompletedActionStatus", "object": [], "result": []}
    measured = output / "work/measured" / f"{job['id']}.json"
    if measured.exists():
        m = json.loads(measured.read_text(encoding="utf-8"))
        action["startTime"], action["endTime"] = _time(m["start_s"]), _time(m["start_s"] + m["seconds"])
    for made in record["Outputs"]:
        entities[made["path"]] = _file(made["path"], made["sha256"], made["bytes"])
        action["result"].append(ref(made["path"]))
    for used in record["Inputs"]:
        inside = not used["path"].startswith("work/") and (output / used["path"]).is_file()
        place = used["path"] if inside else f"#{used['path']}"
        if used["made_by"] and not inside:  # A folder of another job: its files.
            parent = read_json(output / used["made_by"])
            action["object"] += [ref(o["path"]) for o in parent["Outputs"] if o["path"].startswith(used["path"])]
            continue
        if place not in entities:
            kind = {"@type": "File"} if inside else {"@type": "CreativeWork"}
            entities[place] = {"@id": place, "name": used["path"].rpartition("/")[2],
                               "sha256": used["sha256"], **kind}
        action["object"].append(ref(place))
    return action


def _failed(failure):
    return {"@id": f"#action-{failure['job']}", "@type": "CreateAction", "name": failure["job"],
            "description": failure["command"], "instrument": ref(f"#{failure['rule']}"), "object": [],
            "result": [], "actionStatus": "http://schema.org/FailedActionStatus", "error": failure["message"]}


def write(output, plan, failed=()):
    """Writes ro-crate-metadata.json of all that is done, and the workflow beside it."""
    workflow = "workflow/Snakefile"
    (output / "workflow").mkdir(exist_ok=True)
    (output / workflow).write_bytes((pathlib.Path(__file__).parent / "Snakefile").read_bytes())
    entities, actions, rules = {}, [], {}
    for job in plan.jobs.values():
        path = output / (job["output"] + ".json")
        if not path.exists():
            continue
        record = read_json(path)
        rules[job["rule"]] = (record["GeneratedBy"][0]["Name"], record["GeneratedBy"][0]["Version"])
        actions.append(_action(output, job, record, entities))
        sidecar = job["output"] + ".json"
        entities[sidecar] = {**_file(sidecar, sha256_of(path)), "about": ref(f"#action-{job['id']}")}
    for failure in failed:
        rules.setdefault(failure["rule"], (plan.jobs[failure["job"]]["argv"][0], ""))
        actions.append(_failed(failure))
    times = [a[t] for a in actions for t in ("startTime", "endTime") if t in a]
    for path in sorted((output / "group").glob("*")):
        name = f"group/{path.name}"
        entities[name] = _file(name, sha256_of(path), path.stat().st_size)
    results = [p for p in entities if p.startswith("group/")]
    objects = [p for p, e in entities.items() if p.startswith("#work/")]
    run = {"@id": "#run", "@type": "CreateAction", "name": "Run of the cohort", "instrument": ref(workflow),
           "object": [ref(p) for p in objects], "result": [ref(p) for p in results]}
    engine = {"@id": "#engine-run", "@type": "OrganizeAction", "name": "Run of Snakemake",
              "instrument": ref("#snakemake"), "result": ref("#run"),
              "object": [ref(f"#control-{a['@id'][1:]}") for a in actions]}
    if times:
        for action in (run, engine):
            action["startTime"], action["endTime"] = min(times), max(times)
    controls = [{"@id": f"#control-{a['@id'][1:]}", "@type": "ControlAction", "name": "job",
                 "instrument": ref("#step-" + a["instrument"]["@id"][1:]), "object": ref(a["@id"])}
                for a in actions]
    files = [p for p, e in entities.items() if e["@type"] == "File"]
    graph = [
        {"@id": "ro-crate-metadata.json", "@type": "CreativeWork", "about": ref("./"),
         "conformsTo": ref("https://w3id.org/ro/crate/1.1", "https://w3id.org/workflowhub/workflow-ro-crate/1.0")},
        {"@id": "./", "@type": "Dataset", "name": "Cohort", "conformsTo": ref(
            *PROFILES, "https://w3id.org/workflowhub/workflow-ro-crate/1.0"),
         "description": "Prepared patients, replays and a report, made by Acus",
         "license": "not stated", "datePublished": max(times)[:10] if times else "1970-01-01",
         "hasPart": [ref(workflow), *[ref(p) for p in files]], "mainEntity": ref(workflow),
         "mentions": [ref("#run"), ref("#engine-run"), *[ref(a["@id"]) for a in actions]]},
        *[{"@id": p, "@type": "CreativeWork", "name": p.split("/")[-2].capitalize() + " Run Crate",
           "version": "0.5"} for p in PROFILES],
        {"@id": "https://w3id.org/workflowhub/workflow-ro-crate/1.0", "@type": "CreativeWork",
         "name": "Workflow RO-Crate", "version": "1.0"},
        {"@id": workflow, "@type": ["File", "SoftwareSourceCode", "ComputationalWorkflow", "HowTo"],
         "name": "pipelines/cohort", "programmingLanguage": ref("#snakemake-language"),
         "hasPart": [ref(f"#{r}") for r in plans.RULES if r in rules],
         "step": [ref(f"#step-{r}") for r in plans.RULES if r in rules]},
        {"@id": "#snakemake-language", "@type": "ComputerLanguage", "name": "Snakemake",
         "identifier": "https://w3id.org/workflowhub/workflow-ro-crate#snakemake",
         "alternateName": "snakemake"},
        {"@id": "#snakemake", "@type": "SoftwareApplication", "name": "Snakemake", "softwareVersion": "7.21"},
        *_tools(rules), run, engine, *controls, *actions, *entities.values()]
    write_json(output / "ro-crate-metadata.json", {"@context": CONTEXT, "@graph": graph})


def problems_of(path):
    """What the crate lacks of what its profiles require; empty if nothing."""
    folder = pathlib.Path(path)
    document = read_json(folder / "ro-crate-metadata.json")
    graph = document.get("@graph") if isinstance(document, dict) else None
    if not isinstance(graph, list) or not all(isinstance(e, dict) and {"@id", "@type"} <= e.keys() for e in graph):
        raise UserError(f"{folder}/ro-crate-metadata.json: is no RO-Crate (no @graph of entities with @id and "
                        "@type); pipelines/cohort INPUT OUTPUT group writes it again")
    by_id = {e["@id"]: e for e in graph}
    found = []

    def need(condition, text):
        if not condition:
            found.append(text)

    def ids(value):
        return [v["@id"] for v in (value if isinstance(value, list) else [value]) if v]

    def kinds(entity):
        return entity["@type"] if isinstance(entity["@type"], list) else [entity["@type"]]

    need(len(by_id) == len(graph), "an @id stands twice")
    root = by_id.get("./", {})
    for key in ("name", "description", "datePublished", "license", "hasPart", "mainEntity"):
        need(root.get(key), f"the root data set has no {key}")
    need(set(PROFILES) <= set(ids(root.get("conformsTo"))), "the root does not state the profiles")
    need(by_id.get("ro-crate-metadata.json", {}).get("about") == ref("./"), "no metadata descriptor")
    workflow = by_id.get(ids(root.get("mainEntity"))[0] if root.get("mainEntity") else "", {"@type": []})
    for kind in ("File", "SoftwareSourceCode", "ComputationalWorkflow"):
        need(kind in kinds(workflow), f"the main entity is no {kind}")
    need("ComputerLanguage" in kinds(by_id.get(ids(workflow.get("programmingLanguage"))[0], {"@type": []}))
         if workflow.get("programmingLanguage") else False, "the workflow has no programming language")
    mentioned = set(ids(root.get("mentions")))
    tools = set(ids(workflow.get("hasPart", [])))
    for entity in graph:
        if "CreateAction" in kinds(entity) or "OrganizeAction" in kinds(entity):
            need(entity["@id"] in mentioned, f"{entity['@id']} is not mentioned by the root")
            need(entity.get("instrument"), f"{entity['@id']} has no instrument")
        if "ControlAction" in kinds(entity):
            need("HowToStep" in kinds(by_id.get(ids(entity["instrument"])[0], {"@type": []})),
                 f"{entity['@id']}: its instrument is no step")
        if "HowToStep" in kinds(entity):
            need(set(ids(entity["workExample"])) <= tools, f"{entity['@id']} is no tool of the workflow")
        if "File" in kinds(entity) and not entity["@id"].startswith("#"):
            need((folder / entity["@id"]).is_file(), f"{entity['@id']} is not there")
            if "sha256" in entity and (folder / entity["@id"]).is_file():
                need(sha256_of(folder / entity["@id"]) == entity["sha256"], f"{entity['@id']} was changed")
            need(entity["@id"] in set(ids(root["hasPart"])), f"{entity['@id']} is no part of the root")
        for key, value in entity.items():
            for other in value if isinstance(value, list) else [value]:
                if isinstance(other, dict) and "@id" in other and not other["@id"].startswith("http"):
                    need(other["@id"] in by_id, f"{entity['@id']}: {key} {other['@id']} is not described")
    return found
