"""A random run before it begins: world, plan, purpose, settings, faults, and the person."""

import json
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from random import Random

from .. import groups, words
from ..cases import SCENES
from ..numbers import State
from ..plans import Grower
from . import make, robot
from .drawing import Drawer
from .judge import Settings
from .purpose import Purpose, StateView, Tracker, Wanted, find_plan, plan_faults
from .world import NumberAction, NumberWorld

# Runs in one world.
PER_WORLD = 6
SHIPPED = ["household", "virtualhome"]


@dataclass
class Person:
    """How a person answers."""

    refuses: float = 0.0
    leaves: float = 0.0
    answers_wrong: float = 0.0


@dataclass
class Scenario:
    """Everything that a run is drawn from."""

    seed: int
    domain: str
    environment: dict
    world: NumberWorld
    entries: make.Entries
    steps: list[NumberAction]
    plan: dict
    goal: str | None
    rules: list[str]
    purpose: Purpose
    settings: Settings
    faults: robot.Plan
    person: Person
    crashes: float
    signal: float
    direct: bool
    reports: list[str]

    def command(self) -> dict:
        """The command that begins the run."""
        return {
            "begin": {
                "domain": self.domain,
                "environment": self.environment,
                "plan": json.dumps(self.plan),
                "goal": self.goal,
                "rules": self.rules,
                "settings": self.settings.as_json(),
                "robot": self.robot(),
                "direct": self.direct,
            }
        }

    def robot(self) -> dict:
        """The robot's description."""
        return {"name": "judged", "reports": self.reports, "parallel": 1}


@lru_cache(maxsize=16)
def world_of(domain: str, environment: str) -> tuple[NumberWorld, make.Entries]:
    """A world with what can be said of it."""
    world = NumberWorld(words.load(domain), json.loads(environment))
    return world, make.Entries(world)


class Source:
    """The runs of one seed: one domain, one world, several plans."""

    def __init__(self, seed: int, folder: Path):
        self.seed, self.random, self.folder = seed, Random(seed), folder

    def runs(self):
        """The scenarios of the seed."""
        random = self.random
        if random.random() < 0.2:
            domain = random.choice(SHIPPED)
            environment = SCENES[domain](random)
        else:
            domain = str(make.write(self.folder / f"domain-{self.seed}", random))
            environment = make.environment(random, words.load(domain))
        world, entries = world_of(domain, json.dumps(environment))
        if world.broken("start", world.initial):
            return
        for number in range(PER_WORLD):
            scenario = self.scenario(number, domain, environment, world, entries)
            if scenario is not None:
                yield scenario

    def scenario(self, number: int, domain: str, environment: dict, world: NumberWorld, entries) -> Scenario | None:
        """One scenario."""
        random = self.random
        steps, states = self.walk(world)
        if not steps:
            return None
        if random.random() < 0.2:
            steps = self.damaged(world, steps)
        drawer = Drawer(world, random)
        goal, purpose = self.purpose(world, drawer, steps, states)
        if purpose is None:
            return None
        if random.random() < 0.75 and plan_faults(purpose, steps, world.initial, strict=False):
            return None
        rules = []
        for _ in range(random.choice([0, 0, 0, 0, 1, 2])):
            rule = drawer.constraint(states, steps)
            if rule is not None:
                rule.standing = True
                rules.append(rule.text)
                purpose = replace(purpose, constraints=[*purpose.constraints, rule])
        if goal is not None and random.random() < 0.25:
            found = find_plan(purpose, world.initial, purpose_start(purpose), set(), 120)
            if isinstance(found, list) and found:
                steps = found
        # The purpose comes with the command or with the plan file; a goal of the command replaces that of the file.
        file = self.plan_file(world, steps)
        given, kept = [], []
        for rule in rules:
            (given if random.random() < 0.5 else kept).append(rule)
        told = {"rules": kept} if kept else {}
        flag = goal
        if goal is not None and random.random() < 0.5:
            told["goal"], flag = goal, None
        elif goal is not None and random.random() < 0.3:
            other = self.purpose(world, drawer, steps, states)[0]
            told |= {"goal": other} if other else {}
        if told:
            file["purpose"] = told
        reports = [name for name in self.reportable(world) if random.random() < 0.5]
        return Scenario(
            seed=self.seed,
            domain=domain,
            environment=environment,
            world=world,
            entries=entries,
            steps=steps,
            plan=file,
            goal=flag,
            rules=given,
            purpose=purpose,
            settings=self.settings(),
            faults=robot.draw(random, len(steps)),
            person=Person(*random.choice([(0, 0, 0), (0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.2)])),
            crashes=random.choice([0, 0, 0, 0.02, 0.1]),
            signal=random.choice([0, 0, 0, 0, 0.03]),
            direct=random.random() < 0.25,
            reports=reports,
        )

    def reportable(self, world: NumberWorld) -> list[str]:
        """The predicates that a robot may report: changed by actions, without words, and no events."""
        own = world.words
        said = {word.predicate for word in own.states.values()}
        told = {predicate for call in own.calls.values() for predicate, _ in call.senses}
        names = [name for name, declared in own.pddl.predicates.items() if declared]
        return [name for name in names if name in own.changing - said - own.events - told]

    def settings(self) -> Settings:
        """Random settings."""
        random = self.random
        return Settings(
            approval=random.choice(["never", "never", "changes", "each-step"]),
            watch=random.choice(["each-step", "each-step", "on-failure"]),
            trust=random.choice(["observed", "observed", "promised"]),
            changes=random.choice([8, 8, 8, 1, 2, 0]),
        )

    def walk(self, world: NumberWorld) -> tuple[list[NumberAction], list[State]]:
        """Applicable steps, one after the other, most of which change something and keep the rules."""
        random = self.random
        actions = [own for own in world.all_actions() if own.condition is not False and not own.senses]
        state, steps, states = world.initial, [], [world.initial]
        for _ in range(random.choice([1, 2, 2, 3, 3, 4, 5, 7])):
            names = sorted({own.name for own in actions})
            random.shuffle(names)
            for name in names:
                own = [action for action in actions if action.name == name]
                random.shuffle(own)
                found = None
                for action in own[:12]:
                    if world.applicable(action, state):
                        after = world.apply(action, state)
                        if after.key() != state.key() and not world.newly_broken(state, after):
                            found = (action, after)
                            break
                if found:
                    break
            else:
                break
            steps.append(found[0])
            state = found[1]
            states.append(state)
        return steps, states

    def damaged(self, world: NumberWorld, steps: list[NumberAction]) -> list[NumberAction]:
        """The steps with one left out, exchanged, added or replaced."""
        random, steps = self.random, list(steps)
        actions = [own for own in world.all_actions() if own.condition is not False and not own.senses]
        kind, place = random.randrange(4), random.randrange(len(steps))
        if kind == 0 and len(steps) > 1:
            del steps[place]
        elif kind == 1 and len(steps) > 1:
            other = random.randrange(len(steps))
            steps[place], steps[other] = steps[other], steps[place]
        elif kind == 2:
            steps.insert(place, random.choice(actions))
        else:
            steps[place] = random.choice(actions)
        return steps

    def purpose(self, world, drawer: Drawer, steps, states) -> tuple[str | None, Purpose | None]:
        """A purpose with its text; None for the changes of the plan itself."""
        random = self.random
        if random.random() < 0.2:
            return None, changes_of(world, steps)
        wanted = states if random.random() < 0.85 else [world.initial, None]
        try:
            stages = drawer.stages(wanted)
        except groups.Refused:
            return None, None
        if not stages:
            return None, None
        constraints = []
        for _ in range(random.choice([0, 0, 0, 1, 1, 2])):
            own = drawer.constraint(states, steps)
            if own is not None:
                constraints.append(own)
        purpose = Purpose(world, stages, constraints)
        return purpose.text(), purpose

    def plan_file(self, world: NumberWorld, steps: list[NumberAction]) -> dict:
        """The plan as a file, with all arguments."""
        grower = Grower.entry
        nodes = [grower(_Holder(world), action) for action in steps]
        return {"task_cohesion": {"task_tree": nodes}}


class _Holder:
    """What the writer of steps needs."""

    def __init__(self, world):
        self.world = world


def purpose_start(purpose: Purpose):
    """The progress before anything was achieved."""
    return Tracker(purpose, strict=True).start(StateView(purpose.world.initial))


def changes_of(world: NumberWorld, steps: list[NumberAction]) -> Purpose | None:
    """The purpose of a plan without one: the changes that it brings about, numbers included."""
    state = world.initial
    for action in steps:
        if not world.applicable(action, state):
            return Purpose(world, [[]], [], made=True)
        state = world.apply(action, state)
    parts = []
    for key in world.subjects:
        if key[0] == "#":
            before, after = world.initial.numbers.get(key[1]), state.numbers.get(key[1])
            if before != after:
                condition = ("compares", ("=", ("fluent", key[1]), ("number", after)))
                parts.append(Wanted(f"{key[1]} = {after}", condition))
        elif (key in world.initial) != (key in state):
            parts.append(Wanted(str(key), ("is" if key in state else "not", key)))
    # A strict reading has the facts that nothing shows, too.
    hidden = [("is" if key in state else "not", key) for key in sorted(world.initial ^ state) if key not in world.subjects]
    return Purpose(world, [parts], [], made=True, hidden=hidden)


