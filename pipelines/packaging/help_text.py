"""What programs and workflows print with --help, as data."""
import dataclasses
import os
import re
import subprocess

ITEM = re.compile(r"^ {2,4}(?P<term>[^\s].*?)(?: {2,}(?P<text>.*))?$")
HEADING = re.compile(r"^(\[?)([A-Z][A-Za-z ]*|positional arguments|options|\[Option Group: .*\])(:|\])$")
CHOICES = re.compile(r"\{([^{}]+)\}")


@dataclasses.dataclass
class Item:
    term: str
    text: str = ""

    def options(self):
        """["-o", "--output"] of "-o,--output TEXT REQUIRED"."""
        return re.findall(r"(?<![\w-])--?[A-Za-z][\w-]*", re.split(r"\s(?![-\s])", self.term)[0])

    def choices(self):
        found = CHOICES.search(self.term)
        return re.split(r"[,|]", found.group(1)) if found else []


@dataclasses.dataclass
class Help:
    """One command: `name` as it is typed, words apart."""

    name: str
    summary: str = ""
    usage: list = dataclasses.field(default_factory=list)
    text: list = dataclasses.field(default_factory=list)      # Paragraphs before the options.
    sections: list = dataclasses.field(default_factory=list)  # (heading, [Item]), in order.
    example: list = dataclasses.field(default_factory=list)
    subcommands: list = dataclasses.field(default_factory=list)

    def items(self):
        return [item for heading, items in self.sections for item in items if heading != "Subcommands"]


def text_of(arguments):
    environment = {**os.environ, "COLUMNS": "100"}
    run = subprocess.run([*map(str, arguments), "--help"], capture_output=True, text=True, check=True,
                         env=environment)
    return run.stdout


def parse(name, text):
    found = Help(name)
    paragraph, items, in_usage, in_example = [], None, False, False

    def end_paragraph():
        if paragraph:
            found.text.append(" ".join(paragraph))
            paragraph.clear()

    for line in text.splitlines():
        bare = line.strip()
        if in_example or re.fullmatch(r"example:?", bare, re.IGNORECASE):
            if in_example:
                found.example.append(line)
            in_example = True
        elif re.match(r"usage: ", line, re.IGNORECASE):
            end_paragraph()
            found.usage.append(line[7:])
            in_usage = True
        elif in_usage and line.startswith(" "):
            found.usage[-1] += " " + bare
        elif not bare:
            end_paragraph()
            in_usage = False
        elif HEADING.match(bare) and not line.startswith("    "):
            end_paragraph()
            heading = HEADING.match(bare).group(2).removeprefix("[Option Group: ")
            items = []
            found.sections.append((heading, items))
        elif line.startswith(" " * 8) and items:
            items[-1].text = (items[-1].text + " " + bare).strip()
        elif ITEM.match(line) and line.startswith("  "):
            if items is None:
                items = []
                found.sections.append(("Options", items))
            match = ITEM.match(line)
            items.append(Item(match.group("term"), match.group("text") or ""))
        else:
            in_usage = False
            paragraph.append(bare)
    end_paragraph()
    found.summary = found.text[0].split(". ")[0].rstrip(".:") if found.text else ""
    return found


def of_program(path, name):
    """With its subcommands."""
    found = parse(name, text_of([path]))
    for heading, items in found.sections:
        if heading == "Subcommands":
            for item in items:
                word = item.term.split()[0]
                found.subcommands.append(parse(f"{name} {word}", text_of([path, word])))
    return found
