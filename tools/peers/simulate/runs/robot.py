"""The real world of a run, and a robot in it that fails, lies, sees partly and dies."""

from dataclasses import dataclass, field
from random import Random

from ..numbers import MILLION, State
from ..render import written
from ..world import GroundAction
from .make import Entries
from .world import NumberWorld

# Faults of a step. `half` is half of the effects; with `-silent` the robot says that the step was done.
STEP_FAULTS = [
    "fails", "fails-half", "fails-whole", "no-effect", "half-silent", "wrong-entity", "slips", "late", "dies-before", "dies-within", "dies-after",
    "times-out", "breaks-protocol", "refuses-step",
]
# Faults of the world: somebody changes something before, during or after a step.
WORLD_FAULTS = ["moved", "number-changed", "undone", "changed-before-the-start"]
# Faults of a look.
LOOK_FAULTS = ["lies", "stale", "no-facts", "one-missing", "look-dies", "garbage"]
# How a robot sees through the whole run.
SIGHTS = ["all", "all", "all", "random", "fixed", "nothing", "no-facts"]


class Died(Exception):
    """The robot fails in this way: `gone`, `timed-out`, `protocol`."""


@dataclass
class Plan:
    """The faults of a run: what happens at which order and at which look."""

    sight: str = "all"
    steps: dict[int, str] = field(default_factory=dict)
    looks: dict[int, str] = field(default_factory=dict)
    between: dict[int, str] = field(default_factory=dict)
    ticks: int = 0


class Robot:
    """A robot in its world."""

    def __init__(self, world: NumberWorld, entries: Entries, faults: Plan, random: Random, reports: set[str]):
        self.world, self.entries, self.faults, self.random = world, entries, faults, random
        self.reports = reports
        self.state: State = world.initial
        self.before: State = world.initial
        self.orders = self.looks = 0
        self.happened: list[str] = []
        self.fixed = {name for name in entries.entities if random.random() < 0.6}
        self.last: dict | None = None
        self.waiting: list[tuple[State, State]] = []
        # Facts and numbers that somebody changed, or that came late.
        self.changed: set[tuple] = set()
        if faults.between.get(0):
            self.meddle(faults.between[0])

    # --- the world ------------------------------------------------------------------------------------------

    def keys(self) -> list[tuple]:
        """The facts and numbers that may change."""
        changing = self.world.words.changing
        return [key for key in self.entries.visible if (key[1][0] if key[0] == "#" else key[0]) in changing]

    def set(self, key: tuple, value) -> None:
        """Changes one fact or number of the world."""
        if key[0] == "#":
            numbers = dict(self.state.numbers)
            numbers[key[1]] = value
            self.state = State.of(self.state, numbers)
        else:
            facts = self.state | {key} if value else self.state - {key}
            self.state = State.of(facts, self.state.numbers)

    def meddle(self, kind: str) -> None:
        """Somebody changes something."""
        keys = self.keys()
        if not keys:
            return
        numbers = [key for key in keys if key[0] == "#" and key[1] in self.state.numbers]
        facts = [key for key in keys if key[0] != "#"]
        self.happened.append(kind)
        if kind == "undone":
            # What the last step changed is as before.
            last = [key for key in keys if self.value(key, self.before) != self.value(key, self.state)]
            if last:
                key = self.random.choice(sorted(last, key=str))
                value = self.value(key, self.before)
                if value is not None:
                    self.set(key, value)
                    self.changed.add(key)
                return
        if kind == "number-changed" and numbers:
            key = self.random.choice(sorted(numbers))
            self.set(key, self.state.numbers[key[1]] + self.random.choice([-2, -1, 1, 2]) * MILLION)
        elif facts and self.random.random() < 0.6 and self.exchange(facts):
            return
        elif facts:
            key = self.random.choice(sorted(facts))
            self.set(key, key not in self.state)
        else:
            return
        self.changed.add(key)

    def exchange(self, facts: list[tuple]) -> bool:
        """Puts one entity in the place of another in a fact of two, as somebody who moves an object; false without such a fact."""
        known = set(facts)
        pairs = sorted(key for key in facts if len(key) == 3 and key in self.state)
        if not pairs:
            return False
        old = self.random.choice(pairs)
        others = sorted(key for key in known if key[:2] == old[:2] and key not in self.state)
        if not others:
            return False
        new = self.random.choice(others)
        for key in (old, new):
            self.set(key, key == new)
            self.changed.add(key)
        return True

    @staticmethod
    def value(key: tuple, state: State):
        """The value of a fact or a number."""
        return state.numbers.get(key[1]) if key[0] == "#" else key in state

    # --- orders ---------------------------------------------------------------------------------------------

    def perform(self, action: GroundAction) -> tuple[str, object]:
        """Does a step; returns `("done", None)` or `("failed", reason)`. Raises `Died`."""
        self.orders += 1
        kind = self.faults.steps.get(self.orders)
        if self.faults.between.get(self.orders) and self.random.random() < 0.5:
            self.meddle(self.faults.between.pop(self.orders))
        if kind is not None:
            self.happened.append(kind)
        self.before = before = self.state
        after = self.world.apply(action, before) if self.world.applicable(action, before) else None
        result: tuple[str, object] = ("done", None) if after is not None else ("failed", "the robot cannot do that here")
        after = before if after is None else after
        if kind in ("fails", "no-effect", "dies-before", "refuses-step"):
            after = before
        elif kind in ("fails-half", "half-silent", "dies-within"):
            after = self.half(before, after)
        elif kind == "wrong-entity":
            after = self.elsewhere(action, before)
        if kind == "late" and after is not before:
            self.waiting.append((before, after))
            after = before
        self.state = after
        if kind == "slips":
            self.meddle("moved")
        if self.faults.between.get(self.orders):
            self.meddle(self.faults.between.pop(self.orders))
        if kind in ("fails", "fails-half", "fails-whole"):
            result = ("failed", "it did not work")
        if kind in ("dies-before", "dies-within", "dies-after"):
            raise Died("gone")
        if kind == "times-out":
            raise Died("timed-out")
        if kind == "breaks-protocol":
            raise Died("protocol")
        if kind == "refuses-step":
            raise Died("rejected")
        return result

    def half(self, before: State, after: State) -> State:
        """Some of the differences between two states."""
        facts = set(before)
        for fact in sorted(before ^ after):
            if self.random.random() < 0.5:
                facts ^= {fact}
        numbers = {key: self.random.choice([own, after.numbers.get(key, own)]) for key, own in before.numbers.items()}
        return State.of(facts, numbers)

    def elsewhere(self, action: GroundAction, before: State) -> State:
        """The state after the same action on other entities."""
        others = [own for own in self.world.all_actions() if own.name == action.name and own.arguments != action.arguments]
        self.random.shuffle(others)
        for own in others:
            if own.condition is not False and self.world.applicable(own, before):
                return self.world.apply(own, before)
        return before

    def arrive(self) -> None:
        """Effects that come late come now."""
        for before, after in self.waiting:
            for fact in before ^ after:
                self.set(fact, fact in after)
                self.changed.add(fact)
            for key, own in after.numbers.items():
                if before.numbers.get(key) != own:
                    self.set(("#", key), own)
                    self.changed.add(("#", key))
        self.waiting = []

    # --- looks ----------------------------------------------------------------------------------------------

    def look(self) -> dict:
        """An observation, true or not. Raises `Died`."""
        self.looks += 1
        kind = self.faults.looks.get(self.looks)
        if kind is not None:
            self.happened.append(kind)
        if kind == "look-dies":
            raise Died("gone")
        if kind == "stale" and self.last is not None:
            seen = self.last
        else:
            seen = self.statements(kind)
        self.last = seen
        self.arrive()
        return seen

    def statements(self, kind: str | None) -> dict:
        """What the robot says that it sees."""
        random, state = self.random, self.state
        visible = list(self.entries.entities)
        if self.faults.sight == "random":
            visible = [name for name in visible if random.random() < 0.6]
        elif self.faults.sight == "fixed":
            visible = [name for name in visible if name in self.fixed]
        elif self.faults.sight == "nothing":
            visible = []
        if kind == "one-missing" and visible:
            visible.remove(random.choice(visible))
        if kind == "lies":
            keys = [key for key in self.keys() if key[0] != "#" or key[1] in state.numbers]
            if keys:
                key = random.choice(sorted(keys, key=str))
                truth = self.state
                self.set(key, self.state.numbers[key[1]] + MILLION if key[0] == "#" else key not in self.state)
                state, self.state = self.state, truth
        seen: dict = {"states": {written(self.world, name): self.entries.statements(name, state) for name in visible}}
        if self.faults.sight not in ("nothing", "no-facts") and kind != "no-facts":
            facts = self.entries.statements(None, state)
            for predicate in self.reports:
                for fact in sorted(own for own in state if own[0] == predicate):
                    inner = ", ".join(written(self.world, name) for name in fact[1:])
                    facts.append(f"{predicate}({inner})")
            if facts or None in self.entries.keys or self.reports:
                seen["facts"] = facts
        if kind == "garbage":
            seen["states"]["<nobody_77>"] = ["lit()"]
        return seen


def draw(random: Random, steps: int, quiet: float = 0.2) -> Plan:
    """The faults of a run of about so many steps."""
    plan = Plan(sight=random.choice(SIGHTS), ticks=random.choice([0, 0, 0, 1, 2]))
    if random.random() < quiet:
        return plan
    for _ in range(random.choice([1, 1, 2, 3])):
        kind, place = random.random(), random.randint(1, max(2, steps + 1))
        if kind < 0.5:
            plan.steps[place] = random.choice(STEP_FAULTS[:8] if random.random() < 0.75 else STEP_FAULTS)
        elif kind < 0.75:
            plan.between[random.randint(0, max(2, steps + 1))] = random.choice(WORLD_FAULTS[:3])
        else:
            plan.looks[place] = random.choice(LOOK_FAULTS if random.random() < 0.8 else LOOK_FAULTS[:2])
    return plan


def action_of(world: NumberWorld, order: dict):
    """The ground action of an order as a robot receives it."""
    return world.action(order["action"], tuple(name.strip("<>") for name in order["arguments"]))

