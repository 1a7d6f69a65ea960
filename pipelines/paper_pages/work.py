"""Whether two runs do the same work: a word that follows from what each does, never one that is written down."""

TOLERANCE = 0.1  # Of a number: less is the same.


def number_of(value):
    """A number, or None for words."""
    if isinstance(value, bool):
        return None
    try:
        return float(value)
    except (TypeError, ValueError):
        return None


def difference(what, theirs, ours):
    """("same" | "more" | "less" | "other" | "unknown", words)."""
    if theirs is None or str(theirs).strip() in ("", "not given"):
        return "unknown", f"{what}: {ours}, the paper gives none"
    a, b = number_of(theirs), number_of(ours)
    if a is not None and b is not None and a > 0:
        if abs(b - a) <= TOLERANCE * a:
            return "same", ""
        return ("more" if b > a else "less"), f"{what}: {shown(b)} for {shown(a)}"
    if str(theirs) == str(ours):
        return "same", ""
    return "other", f"{what}: {ours} for {theirs}"


def shown(number):
    return f"{number:,.0f}" if abs(number) >= 1000 and number == int(number) else f"{number:.4g}"


def verdict(parts):
    """`parts`: what -> (the paper's, ours). "the same", "more", "less", or "other", and how they differ. More: more in
    some respects and less in none. A respect that differs in kind, or that the paper does not give, makes it other."""
    kinds, words = set(), []
    for what, (theirs, ours) in parts.items():
        kind, text = difference(what, theirs, ours)
        kinds.add(kind)
        if text:
            words.append(text)
    kinds.discard("same")
    if not kinds:
        return "the same"
    word = kinds.pop() if len(kinds) == 1 else "other"
    return f"{'other' if word == 'unknown' else word}: {'; '.join(words)}"
