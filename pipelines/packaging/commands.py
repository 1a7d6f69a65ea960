"""The commands that an installation has: programs, and workflows as `acus NAME`."""
import os
import re
import subprocess

import help_text


def listed(acus):
    """Names of programs and of workflows, as `acus --help` has them."""
    names, kind = {"Programs": [], "Workflows": []}, None
    text = subprocess.run([str(acus), "--help"], capture_output=True, text=True, check=True).stdout
    for line in text.splitlines():
        heading = re.match(r"(Programs|Workflows)\b.*:$", line)
        if heading:
            kind = heading.group(1)
        elif kind and line.startswith("  "):
            names[kind].append(line.split()[0])
        else:
            kind = None
    return names["Programs"], names["Workflows"]


def all_commands(programs, workflows):
    """Help of every command; workflows under the name that `acus` gives them."""
    os.environ["ACUS_BIN"] = str(programs)
    names, workflow_names = listed(programs / "acus")
    yield help_text.of_program(programs / "acus", "acus")
    for name in names:
        yield help_text.of_program(programs / f"acus-{name}", f"acus-{name}")
    for name in workflow_names:
        text = help_text.text_of([workflows / name]).replace("pipelines/", "acus ")
        yield help_text.parse(f"acus {name}", text.replace(str(workflows.parent), ""))
