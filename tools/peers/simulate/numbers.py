"""Numbers of a world: exact decimals with six places, as docs/reference/domains.md has them. A value is in millionths."""

from fractions import Fraction

MILLION = 10**6
# Millionths that a number holds at most.
MOST = 2**63 - 1
# The value of a number that an observer cannot be sure of; None is a number that does not exist.
UNSURE = object()
COMPARISONS = {
    "<": lambda left, right: left < right,
    "<=": lambda left, right: left <= right,
    "=": lambda left, right: left == right,
    "!=": lambda left, right: left != right,
    ">=": lambda left, right: left >= right,
    ">": lambda left, right: left > right,
}


class State(frozenset):
    """The facts that hold, with the numbers beside them."""

    numbers: dict

    @staticmethod
    def of(facts, numbers: dict) -> "State":
        """A state; the numbers are not changed afterwards."""
        state = State(facts)
        state.numbers = numbers
        return state

    def key(self) -> tuple:
        """A key that two equal states share."""
        return frozenset(self), frozenset(self.numbers.items())


def nearest(value: Fraction) -> int:
    """The nearest whole number; halves go away from zero."""
    size = (2 * abs(value.numerator) + value.denominator) // (2 * value.denominator)
    return size if value >= 0 else -size


def decimal(value: int) -> str:
    """A number as environments write it."""
    sign, size = ("-" if value < 0 else ""), abs(value)
    return f"{sign}{size // MILLION}.{size % MILLION:06}".rstrip("0").rstrip(".")


def value(expression: tuple, numbers) -> int | None | object:
    """The value of a ground expression; `numbers` has a method `get`."""
    head = expression[0]
    if head == "number":
        return expression[1]
    if head == "unknown":
        return None
    if head == "fluent":
        return numbers.get(expression[1])
    left, right = value(expression[1], numbers), value(expression[2], numbers)
    if left is None or right is None or (head == "/" and right == 0):
        return None
    if left is UNSURE or right is UNSURE:
        return UNSURE
    if head == "+":
        result = left + right
    elif head == "-":
        result = left - right
    else:
        result = nearest(Fraction(left * right, MILLION) if head == "*" else Fraction(left * MILLION, right))
    return result if abs(result) <= MOST else None


def with_values(comparison: tuple, numbers) -> tuple:
    """A comparison with the values of its numbers in place of them."""
    sign, *sides = comparison
    values = [value(side, numbers) for side in sides]
    return (sign, *(("unknown",) if own is None else ("number", own) for own in values))


def decide(head: str, comparison: tuple, numbers) -> bool | None:
    """The truth of `compares` or `fails`: both are false of a number that does not exist, and None of an unsure one."""
    sign, left, right = comparison
    left, right = value(left, numbers), value(right, numbers)
    if left is None or right is None:
        return False
    if left is UNSURE or right is UNSURE:
        return None
    return COMPARISONS[sign](left, right) == (head == "compares")


def in_range(limits: tuple, numbers) -> bool | None:
    """True for a number within its range, and for one that does not exist."""
    key, least, most = limits
    found = numbers.get(key)
    if found is UNSURE:
        return None
    return found is None or ((least is None or found >= least) and (most is None or found <= most))


def fluents(expression: tuple) -> set[tuple]:
    """The numbers that an expression reads."""
    if expression[0] in ("number", "unknown"):
        return set()
    return {expression[1]} if expression[0] == "fluent" else fluents(expression[1]) | fluents(expression[2])
