"""Random planning tasks in PDDL: costs, steps that cost nothing, conditional effects that interact, numbers, goals with an
order and constraints. The texts of a task; its meaning is in task_machine.py.

Conditions and effects are nested tuples:
  ("fact", name, term, ..) ("not", c) ("and", c, ..) ("or", c, ..) ("forall" or "exists", ((variable, type), ..), c)
  ("=", term, term) ("compare", sign, e, e); expressions: ("number", n) ("fluent", name, term, ..) ("+" or "-", e, e)
  effects: ("set", holds, name, term, ..) ("when", c, e) ("forall", ((variable, type), ..), e) ("and", e, ..)
  ("assign" or "increase" or "decrease", name, terms, e)
"""

import itertools
from dataclasses import dataclass

# The objects that actions may name; every task has them.
CONSTANTS = ("v0", "r0", "r1")


@dataclass(frozen=True)
class Action:
    """An action; `cost` is an expression over numbers that do not change, or None."""

    name: str
    parameters: tuple
    condition: tuple
    effects: tuple
    cost: tuple | None


@dataclass(frozen=True)
class Task:
    """A task. With `stages`, the goal is a list of stages of goals, and there may be constraints; else one condition."""

    objects: tuple
    predicates: tuple
    functions: tuple
    actions: tuple
    facts: frozenset
    numbers: tuple
    goal: tuple = ("and",)
    stages: tuple = ()
    constraints: tuple = ()
    costs: bool = False

    def of_type(self, kind: str) -> list[str]:
        """The objects of a type."""
        return [name for name, own in self.objects if own == kind]

    def bindings(self, variables: tuple) -> list[dict]:
        """Every way to bind variables to objects of their types."""
        names = [name for name, _ in variables]
        return [dict(zip(names, choice)) for choice in itertools.product(*(self.of_type(kind) for _, kind in variables))]

    def has_costs(self) -> bool:
        """True if some action has a cost; a domain in which none has counts steps."""
        return self.costs and any(action.cost is not None for action in self.actions)

    # --- PDDL ------------------------------------------------------------------------------------------------------

    def domain_text(self) -> str:
        """The text of the domain."""
        functions = "".join(f" ({name}{typed(kinds)})" for name, kinds in self.functions)
        functions += " (total-cost)" if self.has_costs() else ""
        predicates = "".join(f" ({name}{typed(kinds)})" for name, kinds in self.predicates)
        lines = [
            "(define (domain drawn) (:requirements :adl :numeric-fluents :action-costs)",
            "(:types vat rung)",
            f"(:constants {declared(tuple(own for own in self.objects if own[0] in CONSTANTS))})",
            f"(:predicates{predicates})",
            *([f"(:functions{functions})"] if functions else []),
        ]
        for action in self.actions:
            effects = [text(effect) for effect in action.effects]
            if self.costs and action.cost is not None:
                effects.append(f"(increase (total-cost) {text(action.cost)})")
            lines.append(f"(:action {action.name} :parameters ({declared(action.parameters)})")
            lines.append(f"  :precondition {text(action.condition)}\n  :effect (and {' '.join(effects)}))")
        return "\n".join(lines) + ")\n"

    def problem_text(self) -> str:
        """The text of the problem."""
        init = [f"({' '.join(fact)})" for fact in sorted(self.facts)]
        init += [f"(= ({' '.join(fluent)}) {number})" for fluent, number in self.numbers]
        objects = declared(tuple(own for own in self.objects if own[0] not in CONSTANTS))
        metric = "(:metric minimize (total-cost))" if self.has_costs() else ""
        return (
            f"(define (problem one) (:domain drawn) (:objects {objects})\n"
            f"(:init {' '.join(init)})\n(:goal {text(self.goal)}) {metric})\n"
        )

    def goal_text(self) -> str | None:
        """The goal with its order and constraints as `longstep solve --goal` reads it; None for a goal in PDDL."""
        if not self.stages:
            return None
        stages = " then ".join(" & ".join(goal.text for goal in stage) for stage in self.stages)
        return " & ".join([stages, *(word + written for word, written, _ in self.constraints)])

    def request(self, plans: list) -> dict:
        """The task as the batch program reads it, with plans to verify."""
        request = {"command": "task", "domain": self.domain_text(), "problem": self.problem_text()}
        goal = self.goal_text()
        return {**request, **({"goal": goal} if goal else {}), "plans": [plan_text(plan) for plan in plans]}


@dataclass(frozen=True)
class Goal:
    """A goal of a stage: its words, and the conditions that it stands for, one for each member of `all`."""

    text: str
    conditions: tuple


def typed(kinds: tuple) -> str:
    """Declared parameters."""
    return "".join(f" ?{'ab'[place]} - {kind}" for place, kind in enumerate(kinds))


def declared(names: tuple) -> str:
    """A typed list."""
    return " ".join(f"{name} - {kind}" for name, kind in names)


def plan_text(plan: list) -> str:
    """The steps as planners write them."""
    return "".join(f"({' '.join(step)})\n" for step in plan)


def text(part: tuple) -> str:
    """A condition, an effect or an expression in PDDL."""
    head, *rest = part
    if head in ("fact", "fluent"):
        return f"({' '.join(rest)})"
    if head == "number":
        return str(rest[0])
    if head == "set":
        return f"({' '.join(rest[1:])})" if rest[0] else f"(not ({' '.join(rest[1:])}))"
    if head in ("forall", "exists"):
        return f"({head} ({declared(rest[0])}) {text(rest[1])})"
    if head == "=":
        return f"(= {rest[0]} {rest[1]})"
    if head == "compare":
        sign = f"({'=' if rest[0] == '!=' else rest[0]} {text(rest[1])} {text(rest[2])})"
        return f"(not {sign})" if rest[0] == "!=" else sign
    if head in ("assign", "increase", "decrease"):
        return f"({head} ({' '.join((rest[0], *rest[1]))}) {text(rest[2])})"
    return f"({head} {' '.join(text(own) for own in rest)})"


def changes(effect: tuple) -> set[str]:
    """The predicates that an effect can change."""
    if effect[0] == "set":
        return {effect[2]}
    return set().union(*(changes(part) for part in effect[1:] if isinstance(part, tuple) and part and isinstance(part[0], str)))


def in_words(condition: tuple) -> str:
    """A fact or a comparison in the words of `longstep solve --goal`."""
    if condition[0] == "compare":
        _, sign, left, right = condition
        return f"{in_words(left)} {sign} {right[1] if right[0] == 'number' else in_words(right)}"
    return f"{condition[1]}({', '.join(condition[2:])})"


def with_member(condition: tuple, member: str) -> tuple:
    """The condition with a member in the place of the first vat."""
    if condition[0] == "compare":
        return (*condition[:2], with_member(condition[2], member), condition[3])
    return tuple(member if term == "v0" else term for term in condition)
