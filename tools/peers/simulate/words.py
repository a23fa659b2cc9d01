"""Reader for domain.toml: how environments and plans write what domain.pddl is about, and what plans keep to."""

import re
import tomllib
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

from . import pddl

ROOT = Path(__file__).resolve().parents[3]
SHIPPED = ROOT / "crates/longstep-model/domains"
CALL = re.compile(r"^\s*([\w-]+)\s*\((.*)\)\s*$", re.S)


def split_call(text: str) -> tuple[str, list[str]]:
    """Name and arguments of `name(argument, argument)`."""
    match = CALL.match(text)
    if not match:
        raise ValueError(f"no call: {text}")
    return match[1], [part.strip() for part in match[2].split(",") if part.strip()]


@dataclass
class StateWord:
    """A word of an environment's entries and the fact that it stands for."""

    name: str
    parameters: list[str]
    predicate: str
    terms: tuple[str, ...]


@dataclass
class Call:
    """How plans write an action."""

    name: str
    shown: list[str]
    action: pddl.Action
    object: str | None
    actor: str | None
    senses: list[tuple[str, tuple[str, ...]]]

    @property
    def hidden(self) -> list[str]:
        """The parameters that the call does not show."""
        return [name for name, _ in self.action.parameters if name not in self.shown]


@dataclass
class Rule:
    """A rule of the domain, with the variables of its outermost `forall` apart from the rest."""

    name: str
    holds: str
    variables: list[tuple[str, str]]
    condition: tuple
    unless: list[str]


@dataclass
class Goal:
    """A goal word."""

    form: str
    parameters: list[tuple[str, str]]
    condition: tuple
    offered: tuple | None
    subject: int | None
    group: str | None = None

    def about(self, arguments: tuple[str, ...]) -> tuple[str, ...]:
        """The arguments for which the goal sets rules aside: its subject, or all of them."""
        return arguments if self.subject is None else (arguments[self.subject],)


@dataclass
class NumberWord:
    """A word of an environment's entries for a numeric function, with its range in millionths."""

    name: str
    says: str
    least: int | None
    most: int | None


@dataclass
class Words:
    """A domain: its PDDL and the words for it."""

    pddl: pddl.Pddl
    asset_type: str
    object_type: str
    states: dict[str, StateWord]
    properties: dict[str, list[tuple[bool, str, tuple[str, ...]]]]
    derivations: list[dict]
    defaults: list[tuple[tuple[bool, str, tuple[str, ...]], tuple]]
    calls: dict[str, Call]
    rules: list[Rule]
    goals: dict[str, Goal]
    assumed: set[str]
    complete: set[str]
    events: set[str]
    lexicon: dict[str, list[str]]
    changing: set[str] = field(default_factory=set)
    numbers: dict[str, NumberWord] = field(default_factory=dict)
    sentences: dict[str, tuple[str, str]] = field(default_factory=dict)
    retries: dict[str, int] = field(default_factory=dict)

    def call_of(self, action: str) -> Call:
        """The call that stands for an action."""
        return next(call for call in self.calls.values() if call.action.name == action)


def literal(text: str) -> tuple[bool, str, tuple[str, ...]]:
    """Sign, predicate and terms of a fact or of its opposite."""
    tree = pddl.parse_sexpr(text)
    if tree[0] == "not":
        return (False, tree[1][0], tuple(tree[1][1:]))
    return (True, tree[0], tuple(tree[1:]))


def condition(text: str) -> tuple:
    """A condition from its text."""
    return pddl.parse_condition(pddl.parse_sexpr(text))


def read_rule(entry: dict) -> Rule:
    """A `[[rule]]`; each binding of its outermost quantifiers is kept or broken by itself.

    `(not (exists ..))` is `(forall .. (not ..))`, and foralls that stand directly in each other are one.
    """
    inner, positive = condition(entry["condition"]), True
    variables: list[tuple[str, str]] = []
    while inner[0] == "not" or inner[0] == ("forall" if positive else "exists"):
        if inner[0] == "not":
            inner, positive = inner[1], not positive
        else:
            variables, inner = variables + inner[1], inner[2]
    inner = inner if positive else ("not", inner)
    return Rule(entry["name"], entry["holds"], variables, inner, entry.get("unless", []))


def read_derivation(entry: dict) -> dict:
    """A `[[derive]]` with its conditions and facts read."""
    read = dict(entry, facts=[literal(fact) for fact in entry["facts"]])
    if "when" in entry:
        read["when"] = condition(entry["when"])
    return read


def read_call(entry: dict, action: pddl.Action) -> Call:
    """An `[[action]]`."""
    name, shown = split_call(entry["call"])
    senses = [literal(fact)[1:] for fact in entry.get("senses", [])]
    return Call(name, shown, action, entry.get("object"), entry.get("actor"), senses)


def read_numbers(toml: dict, parsed: pddl.Pddl) -> dict[str, NumberWord]:
    """The words for numeric functions, by word."""
    told = {entry["name"]: entry for entry in toml.get("number", [])}
    found = {}
    for name in parsed.functions:
        entry = told.get(name, {})
        limits = [None if key not in entry else pddl.millionths(str(entry[key])) for key in ("min", "max")]
        found[entry.get("word", name)] = NumberWord(name, entry.get("says", name), *limits)
    return found


def read(domain_text: str, words_text: str) -> Words:
    """A domain from the texts of its two files."""
    parsed = pddl.parse_domain(domain_text)
    toml = tomllib.loads(words_text)
    states = {}
    for entry in toml.get("state", []):
        name, parameters = split_call(entry["word"])
        _, predicate, terms = literal(entry["fact"])
        states[name] = StateWord(name, ["?" + part.strip("<>") for part in parameters], predicate, terms)
    properties = {entry["word"]: [literal(fact) for fact in entry["facts"]] for entry in toml.get("property", [])}
    calls = {}
    for entry in toml.get("action", []):
        call = read_call(entry, parsed.actions[entry["name"]])
        calls[call.name] = call
    goals = {}
    for entry in toml.get("goal", []):
        parameters = pddl.typed_list(entry["parameters"].split())
        offered = condition(entry["offered"]) if "offered" in entry else None
        names = [name for name, _ in parameters]
        subject = names.index(entry["subject"]) if entry.get("subject") in names else None
        goals[entry["form"]] = Goal(entry["form"], parameters, condition(entry["condition"]), offered, subject, entry.get("exclusive"))
    predicates = toml.get("predicate", [])
    defaults = [(literal(entry["fact"]), condition(entry.get("when", "(and)"))) for entry in toml.get("default", [])]
    words = Words(
        pddl=parsed,
        asset_type=toml["environment"]["assets"],
        object_type=toml["environment"]["objects"],
        states=states,
        properties=properties,
        derivations=[read_derivation(entry) for entry in toml.get("derive", [])],
        defaults=defaults,
        calls=calls,
        rules=[read_rule(entry) for entry in toml.get("rule", [])],
        goals=goals,
        assumed={entry["name"] for entry in predicates if entry.get("unknown") == "assume"},
        complete={entry["name"] for entry in predicates if entry.get("complete")},
        events={entry["name"] for entry in predicates if entry.get("event")},
        lexicon=toml.get("lexicon", {}),
        numbers=read_numbers(toml, parsed),
        sentences={entry["name"]: (entry["says"], entry["denies"]) for entry in predicates if "denies" in entry},
        retries={entry["name"]: entry.get("retries", 2) for entry in toml.get("action", [])},
    )
    for call in calls.values():
        words.changing |= pddl.changed_predicates(call.action.effect)
        words.changing |= {predicate for predicate, _ in call.senses}
    return words


@lru_cache(maxsize=64)
def load(domain: str) -> Words:
    """A shipped domain by its name, or any by its folder."""
    folder = SHIPPED / domain if (SHIPPED / domain).is_dir() else Path(domain)
    return read((folder / "domain.pddl").read_text(), (folder / "domain.toml").read_text())
