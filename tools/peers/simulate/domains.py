"""Random domains: complete folders as `longstep domain new` makes them, with ADL conditions, rules and sensing."""

from pathlib import Path
from random import Random

from .pddl import parse_effect, parse_sexpr

KINDS = ["thing", "spot", "piece"]
STATIC_ONE, STATIC_TWO = ["sturdy", "hollow"], ["linked", "facing"]
FLUENT_ONE = ["lit", "sealed", "warm", "tagged"]
FLUENT_TWO = ["docked", "tied"]
SILENT, EVENT = ["poised", "ready"], ["rung", "shaken"]
SENSED = [["pure", "murky"], ["small", "medium", "large"]]
ACTIONS = ["carve", "fold", "grind", "hoist", "join", "knead"]
LOOKS = ["probe", "gauge"]


class Maker:
    """Makes one random domain."""

    def __init__(self, random: Random, sensing: bool):
        self.random = random
        self.static: dict[str, list[str]] = {}
        self.fluent: dict[str, list[str]] = {}
        self.silent: dict[str, list[str]] = {}
        self.events: dict[str, list[str]] = {}
        self.outcomes: list[tuple[str, list[str], str]] = []
        self.constant = random.random() < 0.3
        self.assumed: set[str] = set()
        for name in random.sample(STATIC_ONE, random.randint(0, 2)):
            self.static[name] = [self.kind()]
        if random.random() < 0.5:
            self.static[random.choice(STATIC_TWO)] = [self.kind(), self.kind()]
        for name in random.sample(FLUENT_ONE, random.randint(1, 3)):
            self.fluent[name] = [self.kind()]
        for name in random.sample(FLUENT_TWO, random.randint(0, 2)):
            self.fluent[name] = [self.kind(), self.kind()]
        for name in random.sample(SILENT, random.randint(0, 1)):
            self.silent[name] = [self.kind()] if random.random() < 0.6 else []
        for name in random.sample(EVENT, random.randint(0, 1)):
            self.events[name] = [self.kind()]
        if sensing:
            for look, group in zip(LOOKS, random.sample(SENSED, random.randint(1, 2))):
                self.outcomes.append((look, group, self.kind()))
        # Events that an action brings about; a predicate that nothing does is an event to nobody.
        self.brought_about: set[str] = set()
        self.fresh = 0
        self.settled = False

    def kind(self) -> str:
        """A type."""
        return self.random.choice(KINDS)

    @property
    def predicates(self) -> dict[str, list[str]]:
        """All predicates with the types of their parameters."""
        told = {name: [kind] for _, group, kind in self.outcomes for name in group}
        return {**self.static, **self.fluent, **self.silent, **self.events, **told}

    # --- conditions and effects ------------------------------------------------------------------------------

    def variable(self) -> str:
        """A variable that nothing else is called."""
        self.fresh += 1
        return f"?v{self.fresh}"

    def terms(self, kinds: list[str], scope: dict[str, str]) -> str | None:
        """Terms of given types; None if the scope has none."""
        found = []
        for kind in kinds:
            fitting = [name for name, own in scope.items() if own == kind or kind == "thing"]
            if self.constant and kind in ("thing", "spot") and self.random.random() < 0.08:
                fitting = ["hub"]
            if not fitting:
                return None
            found.append(self.random.choice(fitting))
        return " ".join(found)

    def atom(self, scope: dict[str, str], positive: bool, changing: bool = False) -> str | None:
        """An atom over the scope; outcomes of sensing only where they are not denied."""
        told = {name for _, group, _ in self.outcomes for name in group}
        allowed = {name: kinds for name, kinds in self.predicates.items() if positive or name not in told}
        if changing:
            allowed = {name: kinds for name, kinds in allowed.items() if name not in self.static and name not in told}
        options = []
        for name, kinds in sorted(allowed.items()):
            terms = self.terms(kinds, scope)
            if terms is not None:
                options.append(f"({name} {terms})" if terms else f"({name})")
        return self.random.choice(options) if options else None

    def condition(self, scope: dict[str, str], depth: int, positive: bool = True, past: bool = False) -> str:
        """A condition; `past` allows `(initially ...)`."""
        kind = self.random.random()
        if depth > 0 and kind < 0.2:
            head = self.random.choice(["and", "or"])
            parts = [self.condition(scope, depth - 1, positive, past) for _ in range(2)]
            return f"({head} {' '.join(parts)})"
        if depth > 0 and kind < 0.3:
            first = self.condition(scope, depth - 1, not positive, past)
            return f"(imply {first} {self.condition(scope, depth - 1, positive, past)})"
        if depth > 0 and kind < 0.55:
            variable, own = self.variable(), self.kind()
            inner = self.condition({**scope, variable: own}, depth - 1, positive, past)
            return f"({self.random.choice(['forall', 'exists'])} ({variable} - {own}) {inner})"
        if depth > 0 and kind < 0.65:
            return f"(not {self.condition(scope, depth - 1, not positive, past)})"
        if past and kind < 0.8 and depth > 0:
            return f"(initially {self.condition(scope, depth - 1, positive)})"
        if kind > 0.92 and len(scope) > 1:
            return f"(= {' '.join(self.random.sample(sorted(scope), 2))})"
        made = self.atom(scope, positive)
        if made is None:
            variable, own = self.variable(), self.kind()
            made = self.atom({**scope, variable: own}, positive)
            if made is None:
                return "(and)"
            made = f"(exists ({variable} - {own}) {made})"
        negated = self.random.random() < 0.4 and positive is not None
        if negated and self.deniable(made):
            return f"(not {made})"
        return made

    def deniable(self, made: str) -> bool:
        """True for a condition that may be denied: it asks for no outcome."""
        return not any(f"({name} " in made for _, group, _ in self.outcomes for name in group)

    def effect(self, scope: dict[str, str], depth: int = 2) -> str | None:
        """One effect: an atom or its opposite, under a condition or for all entities of a type."""
        kind = self.random.random()
        if depth and kind < 0.2:
            variable, own = self.variable(), self.kind()
            inner = self.effect({**scope, variable: own}, depth - 1)
            return inner and f"(forall ({variable} - {own}) {inner})"
        if depth and kind < 0.45:
            inner = self.effect(scope, depth - 1)
            return inner and f"(when {self.condition(scope, 2)} {inner})"
        if self.outcomes and kind < 0.55:
            return self.unsettled(scope)
        made = self.atom(scope, True, changing=True)
        if made is None:
            return None
        name = made.strip("()").split()[0]
        return f"(not {made})" if name not in self.events and self.random.random() < 0.45 else made

    def unsettled(self, scope: dict[str, str]) -> str | None:
        """An effect that takes all outcomes of one sensing action away, or settles which one holds."""
        _, group, kind = self.random.choice(self.outcomes)
        term = self.terms([kind], scope)
        if term is None:
            return None
        # One effect of an action at most says which outcome holds, so that never two do.
        kept = self.random.choice(group) if self.random.random() < 0.3 and not self.settled else None
        self.settled |= kept is not None
        return "(and " + " ".join(f"({n} {term})" if n == kept else f"(not ({n} {term}))" for n in group) + ")"

    # --- the two files ----------------------------------------------------------------------------------------

    def make(self) -> tuple[str, str]:
        """The texts of domain.pddl and domain.toml."""
        pddl, actions, toml = [], [], []
        for name in self.random.sample(ACTIONS, self.random.randint(2, 5)):
            self.action(name, pddl, actions)
        for look, group, kind in self.outcomes:
            self.look(look, group, kind, pddl, actions)
        self.words_of_predicates(toml)
        toml += actions
        self.rules(toml)
        self.goals(toml)
        return self.header() + "\n" + "\n".join(pddl) + ")\n", "\n".join(toml) + "\n"

    def header(self) -> str:
        """The beginning of domain.pddl."""
        declared = []
        for name, kinds in self.predicates.items():
            declared.append(f"({name}" + "".join(f" ?{'ab'[n]} - {kind}" for n, kind in enumerate(kinds)) + ")")
        constants = "  (:constants hub - spot)\n" if self.constant else ""
        return (
            "(define (domain made)\n  (:requirements :strips :typing :negative-preconditions "
            ":disjunctive-preconditions :quantified-preconditions :conditional-effects :equality)\n"
            f"  (:types spot piece - thing)\n{constants}  (:predicates {' '.join(declared)})"
        )

    def words_of_predicates(self, toml: list[str]) -> None:
        """The words for predicates, states and properties."""
        toml.append('name = "made"\nabout = "A domain made at random."\n[environment]\nassets = "spot"\nobjects = "piece"')
        for name, kinds in self.predicates.items():
            about = " and ".join("{" + "ab"[n] + "}" for n in range(len(kinds))) or "it"
            toml.append(f'[[predicate]]\nname = "{name}"\nsays = "{about} is {name}"\ndenies = "{about} is not {name}"')
            if name in self.brought_about:
                toml.append("event = true")
            if name in self.static and len(kinds) == 1 and self.random.random() < 0.3:
                toml.append('unknown = "assume"')
                self.assumed.add(name)
        told = {name: [kind] for _, group, kind in self.outcomes for name in group}
        for name, kinds in {**self.fluent, **told, **self.static}.items():
            if len(kinds) == 1 and name in self.static:
                toml.append(f'[[property]]\nword = "{name.upper()}"\nfacts = ["({name} ?self)"]')
                if name in self.assumed:
                    toml.append(f'[[property]]\nword = "NOT_{name.upper()}"\nfacts = ["(not ({name} ?self))"]')
            elif len(kinds) == 1:
                toml.append(f'[[state]]\nword = "{name}()"\nfact = "({name} ?self)"\nmeans = "It is {name}."')
            else:
                order = ["?self", "?other"] if self.random.random() < 0.7 else ["?other", "?self"]
                toml.append(f'[[state]]\nword = "{name}(<other>)"\nfact = "({name} {" ".join(order)})"')
                toml.append(f'means = "It is {name} with <other>."')

    def action(self, name: str, pddl: list[str], toml: list[str]) -> None:
        """An action with random conditions and effects."""
        self.settled = False
        scope = {f"?{letter}": self.kind() for letter in "pqr"[: self.random.choice([0, 1, 1, 2, 2, 2, 3])]}
        parts = [self.condition(scope, self.random.randint(0, 3)) for _ in range(self.random.choice([0, 1, 1, 2]))]
        effects = [made for _ in range(self.random.randint(1, 3)) if (made := self.effect(scope))]
        if not effects:
            fluent, kinds = self.random.choice(sorted(self.fluent.items()))
            bound = [f"?{letter}" for letter in "xy"[: len(kinds)]]
            declared = " ".join(f"{variable} - {kind}" for variable, kind in zip(bound, kinds))
            effects = [f"(forall ({declared}) ({fluent} {' '.join(bound)}))"]
        self.brought_about |= {event for event in self.events if self.adds(event, effects)}
        parameters = " ".join(f"{variable} - {kind}" for variable, kind in scope.items())
        pddl.append(
            f"  (:action {name}\n    :parameters ({parameters})\n    :precondition (and {' '.join(parts)})\n"
            f"    :effect (and {' '.join(effects)}))"
        )
        hidden = [variable for variable in scope if self.random.random() < 0.2]
        shown = ", ".join(variable for variable in scope if variable not in hidden)
        says = f"{name} " + " ".join("{" + variable[1:] + "}" for variable in scope)
        toml.append(f'[[action]]\nname = "{name}"\ncall = "{name}({shown})"\nsays = "{says.strip()}"\nmeans = "To {name}."')
        if hidden and self.random.random() < 0.4:
            toml.append(f'object = "{hidden[0]}"')

    def adds(self, event: str, effects: list[str]) -> bool:
        """True if effects make an event true."""

        def look(effect: tuple) -> bool:
            if effect[0] == "and":
                return any(map(look, effect[1]))
            return look(effect[2]) if effect[0] in ("forall", "when") else effect[:2] == ("add", event)

        return any(look(parse_effect(parse_sexpr(effect))) for effect in effects)

    def look(self, name: str, group: list[str], kind: str, pddl: list[str], toml: list[str]) -> None:
        """A sensing action."""
        needs = self.condition({"?p": kind}, 1) if self.random.random() < 0.5 else "(and)"
        pddl.append(f"  (:action {name}\n    :parameters (?p - {kind})\n    :precondition {needs}\n    :effect (and))")
        senses = ", ".join(f'"({outcome} ?p)"' for outcome in group)
        toml.append(f'[[action]]\nname = "{name}"\ncall = "{name}(?p)"\nsenses = [{senses}]')
        toml.append(f'says = "{name} {{p}}"\nmeans = "To {name}."')

    def rules(self, toml: list[str]) -> None:
        """Rules of all sorts, mostly `always` and `end`."""
        sorts = [sort for sort, share in (("always", 0.6), ("end", 0.6), ("tidy", 0.3), ("always", 0.2)) if
                 self.random.random() < share]
        for number, sort in enumerate(sorts):
            scope = {f"?{letter}": self.kind() for letter in "ab"[: self.random.randint(0, 2)]}
            inner = self.condition(scope, 2, past=True)
            declared = " ".join(f"{variable} - {kind}" for variable, kind in scope.items())
            whole = f"(forall ({declared}) {inner})" if scope else inner
            says = " and ".join("{" + variable[1:] + "}" for variable in scope) or "something"
            toml.append(f'[[rule]]\nname = "rule-{number}"\nholds = "{sort}"\ncondition = "{whole}"')
            toml.append(f'says = "{says} must keep to rule {number}"')

    def goals(self, toml: list[str]) -> None:
        """A goal for every predicate that an environment can say, and one with a random condition."""
        for name, kinds in self.fluent.items():
            parameters = [f"?{'ab'[n]} - {kind}" for n, kind in enumerate(kinds)]
            self.goal(f"{name}ness", parameters, f"({name} {' '.join('?' + 'ab'[n] for n in range(len(kinds)))})", toml)
            self.goal(f"un{name}ness", parameters, f"(not ({name} {' '.join('?' + 'ab'[n] for n in range(len(kinds)))}))", toml)
        own = self.kind()
        self.goal("mixture", [f"?a - {own}"], self.condition({"?a": own}, 3, past=True), toml)

    def goal(self, word: str, parameters: list[str], condition: str, toml: list[str]) -> None:
        """One goal word."""
        braces = ", ".join("{" + parameter.split()[0][1:] + "}" for parameter in parameters)
        toml.append(f'[[goal]]\nform = "{word}({braces})"\nparameters = "{" ".join(parameters)}"')
        toml.append(f'condition = "{condition}"\nsubject = "?a"\nsays = "{braces} has {word}"\nmeans = "To have {word}."')


GOAL_PROMPT = """You say which goals are wanted.
{% for goal in goals -%}
- {{ goal.form }}: {{ goal.means }}
{% endfor %}
"""
EXAMPLES = """[[example]]
objects = { trumpet = "" }
places = { den = "" }
instruction = "Sing"
answer = "question: What is it that I should do?"
"""


def write(folder: Path, random: Random, sensing: bool) -> Path:
    """Writes a random domain into a folder."""
    domain, words = Maker(random, sensing).make()
    (folder / "prompt").mkdir(parents=True, exist_ok=True)
    (folder / "domain.pddl").write_text(domain)
    (folder / "domain.toml").write_text(words)
    (folder / "prompt" / "goal.md").write_text(GOAL_PROMPT)
    (folder / "prompt" / "examples.toml").write_text(EXAMPLES)
    return folder
