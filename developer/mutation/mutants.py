"""Places in C++ sources at which one token can be changed, and copies of sources that hold many mutants."""
import collections
import pathlib
import re

# What is not code: comments, strings, characters, includes.
SKIPPED = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'|^\s*#[^\n]*',
                     re.DOTALL | re.MULTILINE)
# Binary operators stand between spaces; brackets of templates do not.
SWAPS = {" + ": (" - ",), " - ": (" + ",), " * ": (" / ",), " / ": (" * ",), " < ": (" <= ", " > "),
         " <= ": (" < ",), " > ": (" >= ", " < "), " >= ": (" > ",), " == ": (" != ",), " != ": (" == ",),
         " && ": (" || ",), " || ": (" && ",), " += ": (" -= ",), " -= ": (" += ",),
         "std::min(": ("std::max(",), "std::max(": ("std::min(",), "true": ("false",), "false": ("true",),
         "std::sin(": ("std::cos(",), "std::cos(": ("std::sin(",)}
TOKEN = re.compile("|".join([*(re.escape(swap) for swap in sorted(SWAPS, key=len, reverse=True) if not swap.isalpha()),
                             r"\b(?:true|false)\b", r"(?<![\w.])\d+\.\d+(?![\w.])", r"(?<![\w.])\d+(?![\w.'])"]))
# The types of mutant.h.
OPERATORS = {(" + ", " - "): "PlusMinus", (" - ", " + "): "MinusPlus", (" * ", " / "): "TimesOver",
             (" / ", " * "): "OverTimes", (" < ", " <= "): "LessOrEqual", (" < ", " > "): "LessGreater",
             (" <= ", " < "): "AtMostLess", (" > ", " >= "): "GreaterOrEqual", (" > ", " < "): "GreaterLess",
             (" >= ", " > "): "AtLeastGreater", (" == ", " != "): "EqualNot", (" != ", " == "): "NotEqual"}
CONNECTIVES = {" && ": "AndOr", " || ": "OrAnd"}
# A number by itself: tables are needed by other initialisers.
CONSTANT = re.compile(r"(?:^|[;{}~])\s*(?:static |inline )?(constexpr) [^;(){}\[\]<]*=[^;{]*$")
OPENING, CLOSING = "([{", ")]}"

Mutant = collections.namedtuple("Mutant", "file line column offset before after")


def replacements(token):
    if token in SWAPS:
        return SWAPS[token]
    if "." in token:
        value = float(token)
        return (repr(value * 1.2) if value else "0.1",)
    return (str(int(token) + 1),)


def code_of(text):
    """The text with everything that is not code blotted out."""
    return SKIPPED.sub(lambda match: re.sub(r"[^\n]", "~", match[0]), text)


def candidates(file):
    code = code_of(file.read_text(encoding="utf-8"))
    found = []
    for match in TOKEN.finditer(code):
        line = code.count("\n", 0, match.start()) + 1
        column = match.start() - code.rfind("\n", 0, match.start())
        for after in replacements(match[0]):
            found.append(Mutant(file, line, column, match.start(), match[0], after))
    return found


def draw(modules, chance):
    """A module, and a place in it; None if the module has no place."""
    files = modules[chance.choice(sorted(modules))]
    places = [mutant for file in files for mutant in candidates(file)]
    return chance.choice(places) if places else None


def left_end(code, offset, stops):
    """Where the operand that ends at `offset` begins; None: it cannot be told from the text."""
    depth, at = 0, offset
    while at > 0:
        char = code[at - 1]
        if char == "}":
            return None
        if char in CLOSING:
            depth += 1
        elif char in OPENING:
            if depth == 0:
                return at
            depth -= 1
        elif depth == 0:
            before = code[:at]
            if char in ";,?" or before.endswith(stops) or re.search(r"\breturn$", before):
                return at
            if char == ":" and code[at - 2] != ":" and code[at] != ":":
                return at
            if char == "=" and code[at - 2] not in "=!<>" and code[at] != "=":
                return at
        at -= 1
    return None


def right_end(code, offset, stops):
    depth = 0
    for at in range(offset, len(code)):
        char = code[at]
        if char in OPENING:
            depth += 1
        elif char in CLOSING:
            if depth == 0:
                return at
            depth -= 1
        elif depth == 0 and (char in ";,?" or code[at:].startswith(stops)):
            return at
        elif depth == 0 and char == ":" and code[at - 1] != ":" and code[at + 1] != ":":
            return at
    return None


def connective(code, mutant, number):
    """The operands as functions, since && and || do not always ask for the second."""
    is_and = mutant.before == " && "
    begin = left_end(code, mutant.offset, ("||",) if is_and else ())
    end = right_end(code, mutant.offset + 4, ("&&", "||") if is_and else ("||",))
    if begin is None or end is None:
        return None
    begin += len(code[begin:]) - len(code[begin:].lstrip())
    end = len(code[:end].rstrip())
    function = "[&]() -> bool { return bool("
    return [(begin, begin, f" mutant::{CONNECTIVES[mutant.before]}<{number}>({function}"),
            (mutant.offset, mutant.offset + 4, f"); }}, {function}"), (end, end, "); })")]


def literal(code, mutant, number):
    if re.search(r"(?:\w<[^<>;()]*|\bcase |\btemplate|static_assert[^;]*)$", code[:mutant.offset][-200:]):
        return None
    end = mutant.offset + len(mutant.before)
    edits = [(mutant.offset, end, f"mutant::Value<{number}>({mutant.before}, {mutant.after})")]
    constant = CONSTANT.search(code[max(0, mutant.offset - 2000):mutant.offset])
    if constant:  # Its value is known when the program starts, not when it is compiled.
        begin = max(0, mutant.offset - 2000) + constant.start(1)
        edits.append((begin, begin + len("constexpr"), "const"))
    return edits


def edits_of(code, mutant, number):
    """Pieces of text to replace so that the source has the mutant as one of many; None: not by text."""
    end = mutant.offset + len(mutant.before)
    operator = OPERATORS.get((mutant.before, mutant.after))
    if operator:
        return [(mutant.offset, end, f"{mutant.before}mutant::{operator}<{number}>{{}}{mutant.before}")]
    if mutant.before in CONNECTIVES:
        return connective(code, mutant, number)
    if mutant.before in (" += ", " -= "):
        if "?" in code[end:code.find(";", end)]:
            return None
        return [(mutant.offset, end, f"{mutant.before}mutant::Sign<{number}>{{}} | ")]
    if mutant.before in ("std::min(", "std::max("):
        name = "Min" if mutant.before == "std::min(" else "Max"
        return [(mutant.offset, end, f"mutant::{name}<{number}>(")]
    if mutant.before in ("std::sin(", "std::cos("):
        name = "Sin" if mutant.before == "std::sin(" else "Cos"
        return [(mutant.offset, end, f"mutant::{name}<{number}>(")]
    return literal(code, mutant, number)


def with_mutants(text, numbered, header):
    """The source with all the (number, mutant), and the numbers of those that it could take. One line longer."""
    code = code_of(text)
    edits, taken = {}, []
    found = [(number, edits_of(code, mutant, number)) for number, mutant in numbered]
    # Where two begin at one place, the longer one is around the other.
    for number, wanted in sorted(filter(lambda each: each[1], found), key=lambda each: each[1][0][0] - each[1][-1][1]):
        # Two changes of one token do not go together; "const" for "constexpr" may be wanted twice.
        if any(edits.get(edit[:2], edit[2]) != edit[2] for edit in wanted if edit[0] != edit[1]):
            continue
        for begin, end, new in wanted:
            edits[begin, end] = edits[begin, end] + new if begin == end and (begin, end) in edits else new
        taken.append(number)
    for (begin, end), new in sorted(edits.items(), reverse=True):
        text = text[:begin] + new + text[end:]
    return f'#include "{pathlib.Path(header).as_posix()}"\n' + text, taken
