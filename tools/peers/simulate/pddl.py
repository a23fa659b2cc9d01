"""Reader for the PDDL that domains are written in: typing, ADL conditions, conditional and quantified effects."""

import re
from decimal import Decimal
from dataclasses import dataclass, field

# A condition or an effect is a nested tuple whose first entry says what it is:
#   ("and", [..]) ("or", [..]) ("not", c) ("forall", [(variable, type)], c) ("exists", ..) ("initially", c)
#   ("=", term, term) ("atom", predicate, terms) ("compare", sign, expression, expression)
#   effects: ("and", [..]) ("forall", variables, e) ("when", c, e) ("add", predicate, terms) ("delete", predicate, terms)
#            ("increase" | "decrease" | "assign", name, terms, expression)
# An expression is ("number", millionths), ("fluent", name, terms) or (sign, expression, expression).
NUMBER = re.compile(r"^-?\d+(\.\d+)?$")
COMPARISONS = ("<", "<=", ">=", ">")
CHANGES = ("increase", "decrease", "assign")
TOKEN = re.compile(r";[^\n]*|[()]|[^\s();]+")


def parse_sexpr(text: str):
    """Nested lists of lower-case words for one s-expression."""
    stack: list[list] = [[]]
    for token in TOKEN.findall(text):
        if token.startswith(";"):
            continue
        if token == "(":
            stack.append([])
        elif token == ")":
            done = stack.pop()
            stack[-1].append(done)
        else:
            stack[-1].append(token)
    if len(stack) != 1 or len(stack[0]) != 1:
        raise ValueError("parentheses do not match, or there is not one expression")
    return stack[0][0]


def typed_list(words: list[str], default: str = "object") -> list[tuple[str, str]]:
    """Pairs of name and type from `a b - t c`."""
    pairs, waiting, rest = [], [], list(words)
    while rest:
        word = rest.pop(0)
        if word == "-":
            kind = rest.pop(0)
            pairs += [(name, kind) for name in waiting]
            waiting = []
        else:
            waiting.append(word)
    return pairs + [(name, default) for name in waiting]


def parse_condition(tree) -> tuple:
    """A condition from an s-expression."""
    if not tree:
        return ("and", [])
    head = tree[0]
    if head in ("and", "or"):
        return (head, [parse_condition(part) for part in tree[1:]])
    if head == "not":
        return ("not", parse_condition(tree[1]))
    if head == "imply":
        return ("or", [("not", parse_condition(tree[1])), parse_condition(tree[2])])
    if head in ("forall", "exists"):
        return (head, typed_list(tree[1]), parse_condition(tree[2]))
    if head == "initially":
        return ("initially", parse_condition(tree[1]))
    if head in COMPARISONS or (head == "=" and any(is_numeric(part) for part in tree[1:])):
        return ("compare", head, parse_expression(tree[1]), parse_expression(tree[2]))
    if head == "=":
        return ("=", tree[1], tree[2])
    return ("atom", head, tuple(tree[1:]))


def is_numeric(tree) -> bool:
    """True for an expression with a value, as opposed to a variable or a name."""
    return isinstance(tree, list) or NUMBER.match(tree) is not None


def millionths(text: str) -> int:
    """A decimal number in millionths."""
    return int(Decimal(text) * 1_000_000)


def parse_expression(tree) -> tuple:
    """A numeric expression from an s-expression."""
    if isinstance(tree, str):
        return ("number", millionths(tree))
    if tree[0] in ("+", "-", "*", "/"):
        return (tree[0], parse_expression(tree[1]), parse_expression(tree[2]))
    return ("fluent", tree[0], tuple(tree[1:]))


def parse_effect(tree) -> tuple:
    """An effect from an s-expression."""
    if not tree:
        return ("and", [])
    head = tree[0]
    if head == "and":
        return ("and", [parse_effect(part) for part in tree[1:]])
    if head == "forall":
        return ("forall", typed_list(tree[1]), parse_effect(tree[2]))
    if head == "when":
        return ("when", parse_condition(tree[1]), parse_effect(tree[2]))
    if head == "not":
        return ("delete", tree[1][0], tuple(tree[1][1:]))
    if head in CHANGES:
        return (head, tree[1][0], tuple(tree[1][1:]), parse_expression(tree[2]))
    return ("add", head, tuple(tree[1:]))


def changed_predicates(effect: tuple) -> set[str]:
    """The predicates and functions that an effect can change."""
    if effect[0] == "and":
        return set().union(*map(changed_predicates, effect[1]))
    if effect[0] in ("forall", "when"):
        return changed_predicates(effect[2])
    return {effect[1]}


@dataclass
class Action:
    """An action of a domain."""

    name: str
    parameters: list[tuple[str, str]]
    condition: tuple
    effect: tuple


@dataclass
class Pddl:
    """A domain file: types with their parents, constants, predicates with typed parameters, actions."""

    name: str = ""
    parents: dict[str, str] = field(default_factory=dict)
    constants: list[tuple[str, str]] = field(default_factory=list)
    predicates: dict[str, list[tuple[str, str]]] = field(default_factory=dict)
    functions: dict[str, list[tuple[str, str]]] = field(default_factory=dict)
    actions: dict[str, Action] = field(default_factory=dict)

    def type_names(self) -> set[str]:
        """The names of all types."""
        return {"object", *self.parents, *self.parents.values()}

    def is_a(self, kind: str, wanted: str) -> bool:
        """True if every entity of type `kind` is of type `wanted`."""
        while kind != wanted and kind in self.parents:
            kind = self.parents[kind]
        return kind == wanted or wanted == "object"


def parse_domain(text: str) -> Pddl:
    """A domain from the text of domain.pddl."""
    pddl = Pddl()
    for section in parse_sexpr(text)[1:]:
        head = section[0]
        if head == "domain":
            pddl.name = section[1]
        elif head == ":types":
            pddl.parents = {name: parent for name, parent in typed_list(section[1:]) if name != parent}
        elif head == ":constants":
            pddl.constants = typed_list(section[1:])
        elif head == ":predicates":
            pddl.predicates = {entry[0]: typed_list(entry[1:]) for entry in section[1:]}
        elif head == ":functions":
            pddl.functions = {entry[0]: typed_list(entry[1:]) for entry in section[1:] if isinstance(entry, list)}
        elif head == ":action":
            parts = dict(zip(section[2::2], section[3::2]))
            condition = parse_condition(parts.get(":precondition", []))
            effect = parse_effect(parts.get(":effect", []))
            name = section[1]
            pddl.actions[name] = Action(name, typed_list(parts.get(":parameters", [])), condition, effect)
    return pddl
