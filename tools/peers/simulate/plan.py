"""Reader for plan files in JSON: a list of steps or a tree, with its words resolved against a world."""

import itertools
from dataclasses import dataclass, field

from .words import Call, split_call
from .world import GroundAction, World


@dataclass
class Step:
    """A step with the values that its parameters can have: one for what is given, several for what is hidden."""

    number: int
    call: Call
    choices: list[list[str]]
    lane: str | None = None

    @property
    def open(self) -> bool:
        """True if an argument is left open."""
        return any(len(values) != 1 for values in self.choices)

    def bindings(self) -> list[tuple[str, ...]]:
        """Every choice of arguments."""
        return list(itertools.product(*self.choices))


# Nodes: ("step", Step) ("if", condition, then, else) ("while", condition, body) ("repeat", count, body)
#        ("parallel", [(actor, [("step", Step) | ("sync", name)])])
# Conditions: ("sense", Step) ("ask", number, fact) ("not", c) ("all", [..]) ("any", [..])


@dataclass
class Plan:
    """A plan whose words were resolved."""

    nodes: list
    steps: list[Step]
    issues: list[str] = field(default_factory=list)
    handled: list[str] = field(default_factory=list)


class Reader:
    """Resolves a plan file's words."""

    def __init__(self, world: World, objects: list[str]):
        self.world = world
        self.objects = objects
        self.steps: list[Step] = []
        self.issues: list[str] = []

    def entity(self, text: str) -> str | None:
        """The entity or constant that an argument names."""
        name = text.strip("<>\"'")
        if name in self.world.types:
            return name
        self.issues.append("unknown_entity")
        return None

    def step(self, entry: dict, lane: str | None = None) -> Step | None:
        """A step; None if its words mean nothing."""
        name, arguments = split_call(entry["call"])
        call = self.world.words.calls.get(name)
        number = len(self.steps) + 1
        if call is None:
            self.issues.append("unknown_action")
            call_step = None
        else:
            call_step = self.resolved(number, call, arguments, entry.get("implicit", {}), lane)
        self.steps.append(call_step)
        return call_step

    def resolved(self, number: int, call: Call, arguments: list[str], implicit: dict, lane: str | None) -> Step | None:
        """A step of a known action."""
        if len(arguments) != len(call.shown):
            self.issues.append("wrong_arguments")
            return None
        given = dict(zip(call.shown, arguments))
        for name, value in implicit.items():
            given["?" + name] = value
        if set(given) - {name for name, _ in call.action.parameters}:
            self.issues.append("unknown_parameter")
            return None
        choices = []
        for parameter, kind in call.action.parameters:
            allowed = self.world.of_type(kind)
            if parameter in given:
                value = self.entity(given[parameter])
                if value is not None and value not in allowed:
                    self.issues.append("wrong_type")
                choices.append([value])
            elif parameter == call.object and self.objects:
                choices.append([name for name in allowed if name in self.objects])
            elif parameter == call.actor and lane is not None:
                choices.append([lane])
            else:
                choices.append(allowed)
        return Step(number, call, choices, lane)

    def condition(self, entry: dict):
        """A condition."""
        if "not" in entry:
            return ("not", self.condition(entry["not"]))
        for key in ("all", "any"):
            if key in entry:
                return (key, [self.condition(part) for part in entry[key]])
        name, arguments = split_call(entry["call"])
        call = self.world.words.calls.get(name)
        if call is not None:
            if not call.senses:
                self.issues.append("not_sensing")
            return ("sense", self.step(entry))
        word = self.world.words.states.get(name)
        if word is None or len(arguments) not in (len(word.parameters), len(word.parameters) + 1):
            self.issues.append("unknown_condition")
            return ("all", [])
        names = [self.entity(argument) for argument in arguments]
        if len(names) == len(word.parameters):
            # "Where the plan handles one thing, expired() is about that."
            if len(self.objects) != 1:
                self.issues.append("unknown_condition")
                return ("all", [])
            names.insert(0, self.objects[0])
        binding = dict(zip(["?self", *word.parameters], names))
        fact = (word.predicate, *(binding.get(term, term) for term in word.terms))
        if None not in names and not self.world.fits(fact):
            self.issues.append("wrong_type")
        return ("ask", len(self.steps), fact)

    def nodes(self, entries: list[dict], lane: str | None = None) -> list:
        """A list of nodes."""
        return [node for entry in entries if (node := self.node(entry, lane)) is not None]

    def node(self, entry: dict, lane: str | None):
        """A node; None for a remark."""
        if "remark" in entry:
            return None
        if "call" in entry:
            return ("step", self.step(entry, lane))
        if "if" in entry:
            condition = self.condition(entry["if"])
            return ("if", condition, self.nodes(entry["then"]), self.nodes(entry.get("else", [])))
        if "while" in entry:
            return ("while", self.condition(entry["while"]), self.nodes(entry["do"]))
        if "repeat" in entry:
            return ("repeat", entry["repeat"], self.nodes(entry["do"]))
        if "sync" in entry:
            return ("sync", entry["sync"])
        return ("parallel", [(each["lane"], self.nodes(each["do"], each["lane"])) for each in entry["parallel"]])


def read(file: dict, world: World) -> Plan:
    """A plan from a plan file."""
    cohesion = file["task_cohesion"]
    objects = [name.strip("<>") for name in cohesion.get("object_names", [])]
    if cohesion.get("object_name"):
        objects.append(cohesion["object_name"].strip("<>"))
    reader = Reader(world, objects)
    entries = cohesion.get("task_tree")
    if entries is None:
        entries = [{"call": call} for call in cohesion["task_sequence"]]
    nodes = reader.nodes(entries)
    return Plan(nodes, reader.steps, reader.issues, objects)


@dataclass
class Bound:
    """A plan with arguments for its steps; steps may be left out that are not decided yet."""

    plan: Plan
    world: World
    arguments: dict[int, tuple[str, ...]]

    def action(self, step: Step) -> GroundAction | None:
        """The step's action; None while its arguments are open."""
        arguments = self.arguments.get(step.number)
        if arguments is None:
            if step.open:
                return None
            arguments = tuple(values[0] for values in step.choices)
        return self.world.action(step.call.action.name, arguments)
