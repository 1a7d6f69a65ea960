# The runs of one sweep of acus-tradeoff, as many at a time as --cores or a cluster profile allows.
# Started by pipelines/sweep, which writes the configuration:
#   command   what runs the sweep, a list: acus-tradeoff scene SCENARIO SESSION ...
#   folder    of the sweep, absolute
#   cases     name of each case: that of the case which makes its reference, or ""
#   start     folder in which the user called: paths of the command are relative to it
import shlex

COMMAND = shlex.join(config["command"])
FOLDER = config["folder"]
START = shlex.quote(config["start"])
CASES = config["cases"]


def run_file(case):
    return f"{FOLDER}/runs/{case}.json"


wildcard_constraints:
    case=r"[A-Za-z0-9._-]+",


rule all:
    input:
        [run_file(case) for case in CASES],


# A run that is there is kept: its age says nothing, its content is looked at when all is collected.
rule run:
    input:
        lambda wildcards: [ancient(run_file(r)) for r in [CASES[wildcards.case]] if r],
    output:
        FOLDER + "/runs/{case}.json",
    shell:
        "cd {START} && {COMMAND} --quiet --case {wildcards.case}"
