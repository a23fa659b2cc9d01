"""Truth for an observer who does not know everything: True, False, or None."""

from ..numbers import decide, fluents, in_range


def truth(ground, view) -> bool | None:
    """The truth of a ground condition; `view` has `fact` for facts and `numbers` with `get`, which may be unsure."""
    if ground is True or ground is False:
        return ground
    head, rest = ground
    if head == "is":
        return view.fact(rest)
    if head == "not":
        known = view.fact(rest)
        return None if known is None else not known
    if head in ("and", "or"):
        deciding = head == "or"
        unsure = False
        for part in rest:
            known = truth(part, view)
            if known is deciding:
                return deciding
            unsure |= known is None
        return None if unsure else not deciding
    if head == "misses":
        known = truth(rest, view)
        return None if known is None else not known
    return in_range(rest, view.numbers) if head == "range" else decide(head, rest, view.numbers)


def keys_of(ground) -> set[tuple]:
    """The facts and numbers that a ground condition reads."""
    if ground is True or ground is False:
        return set()
    head, rest = ground
    if head in ("is", "not"):
        return {rest}
    if head in ("and", "or"):
        return set().union(*map(keys_of, rest))
    if head == "range":
        return {("#", rest[0])}
    if head == "misses":
        return keys_of(rest)
    return {("#", key) for key in fluents(rest[1]) | fluents(rest[2])}
