"""Random cases of each class, several in one world."""

import copy
import json
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from random import Random

from . import domains, groups, hidden, plans, render, scenes, words
from .plan import read
from .walk import OverBound
from .world import World

CLASSES = ["flat", "tree", "lanes", "hidden", "claims", "domain", "solve", "order", "groups"]
# How often each class comes when all are asked for.
SHARES = {"flat": 18, "tree": 24, "lanes": 10, "hidden": 16, "claims": 14, "domain": 14, "solve": 4, "order": 4, "groups": 4}
# Cases in one world, and worlds in one random domain.
PER_WORLD, PER_DOMAIN = 5, 2
SCENES = {
    "household": lambda random: scenes.household(random, dual=False),
    "household-checks": scenes.checks,
    "household-dual": lambda random: scenes.household(random, dual=True),
    "virtualhome": scenes.virtualhome,
    str(words.ROOT / "examples/greenhouse"): scenes.greenhouse,
}


@lru_cache(maxsize=8)
def shared_world(domain: str, environment: str, faults: frozenset) -> World:
    """The world of an environment."""
    return World(words.load(domain), json.loads(environment), faults)


@dataclass
class Case:
    """One thing to be judged by both: a plan in a world, or goals in a world."""

    kind: str
    seed: int
    domain: str
    environment: dict
    file: dict = field(default_factory=dict)
    script: bool = False
    goals: list[tuple[str, tuple[str, ...]]] = field(default_factory=list)
    # The numbers of the goals that begin a stage, and constraints: "never" or "always" with a goal, "untouched" with a name.
    stages: list[int] = field(default_factory=list)
    constraints: list[tuple] = field(default_factory=list)

    def world(self, faults: frozenset = frozenset()) -> World:
        """The world of the case; cases in one environment share it."""
        return shared_world(self.domain, json.dumps(self.environment), faults)

    def request(self) -> dict:
        """The case as the batch program reads it."""
        common = {"domain": self.domain, "environment": self.environment}
        if self.goals:
            return {"command": "solve", **common, "goal": " & ".join(self.parts())}
        return {"command": "verify", **common, "plan": render.plan_text(self.file, self.world(), self.script)}

    def parts(self) -> list[str]:
        """The parts of the goal in the words of `longstep solve --goal`."""
        parts = []
        for number, goal in enumerate(self.goals):
            parts.append(("then " if number in self.stages else "") + self.goal_text(*goal))
        for word, subject in self.constraints:
            written = self.argument_text(subject) if word == "untouched" else self.goal_text(*subject)
            parts.append(f"untouched({written})" if word == "untouched" else f"{word} {written}")
        return parts

    def goal_text(self, form: str, arguments: tuple[str, ...]) -> str:
        """A goal in the words of `longstep solve --goal`."""
        text, ambiguous = form, groups.is_overloaded(self.world(), form)
        for (name, _), value in zip(words.load(self.domain).goals[form].parameters, arguments):
            text = text.replace("{" + name[1:] + "}", self.argument_text(value, ambiguous))
        return text

    def argument_text(self, value, ambiguous: bool = False) -> str:
        """An entity, or a group, in the words of `longstep solve --goal`."""
        is_group = isinstance(value, groups.Group)
        return value.text(self.world(), ambiguous) if is_group else render.written(self.world(), value)

    def changed(self, **parts) -> "Case":
        """The case with some of its parts replaced."""
        return replace(copy.deepcopy(self), **parts)


def steps_of(nodes: list[dict]) -> list[str] | None:
    """The calls of a list of steps that hide nothing that has to be given; None for anything else."""
    if all(set(node) == {"call"} for node in nodes):
        return [node["call"] for node in nodes]
    return None


def plan_file(nodes: list[dict], random: Random, objects: list[str] | None = None) -> dict:
    """A plan file; a list of plain steps becomes a sequence now and then."""
    cohesion: dict = {}
    sequence = steps_of(nodes)
    if sequence is not None and random.random() < 0.6:
        cohesion["task_sequence"] = sequence
    else:
        cohesion["task_tree"] = nodes
    if objects:
        if len(objects) == 1 and "task_sequence" in cohesion:
            cohesion["object_name"] = objects[0]
        else:
            cohesion["object_names"] = objects
    return {"task_cohesion": cohesion}


class Source:
    """Random cases from one seed; the seed of a batch brings the same batch again."""

    def __init__(self, seed: int, folder: Path, kinds: list[str]):
        self.seed = seed
        self.random = Random(seed)
        self.folder = folder
        self.kinds = kinds

    def batch(self) -> list[Case]:
        """The cases of this seed: one class, one domain, one or more worlds."""
        kind = self.random.choices(self.kinds, [SHARES[name] for name in self.kinds])[0]
        if kind == "domain" or (kind in ("solve", "order", "groups") and self.random.random() < 0.5):
            folder = self.folder / f"domain-{self.seed}"
            domain = str(domains.write(folder, self.random, sensing=kind == "domain" and self.random.random() < 0.5))
            return [case for _ in range(PER_DOMAIN) for case in self.in_world(kind, domain, scenes.any_domain)]
        domain = self.domain_for(kind)
        return list(self.in_world(kind, domain, lambda random, _: SCENES[domain](random)))

    def domain_for(self, kind: str) -> str:
        """A shipped domain for a class."""
        if kind == "lanes":
            return "household-dual"
        if kind in ("tree", "hidden"):
            return self.random.choice(["household-checks", "household-checks", "household", "household-dual", "virtualhome"])
        if kind == "claims" and self.random.random() < 0.4:
            return "household-checks"
        return self.random.choice(list(SCENES))

    def in_world(self, kind: str, domain: str, scene) -> Iterator[Case]:
        """Cases of a class in one random world."""
        loaded = words.load(domain)
        environment = scene(self.random, loaded)
        if kind == "groups":
            environment = json.loads(groups.several(json.dumps(environment), environment["objects"], self.random))
        world = shared_world(domain, json.dumps(environment), frozenset())
        if world.broken("start", world.initial):
            return
        if kind in ("solve", "order", "groups"):
            yield from self.goals(kind, domain, environment, world)
            return
        grower = plans.Grower(world, self.random)
        for _ in range(PER_WORLD if kind != "hidden" else 3):
            case = self.case(kind, domain, environment, grower)
            if case is not None:
                yield case

    def case(self, kind: str, domain: str, environment: dict, grower: plans.Grower) -> Case | None:
        """A case with a plan."""
        random = self.random
        if kind == "lanes":
            nodes = grower.lanes()
        elif kind == "flat" or (kind in ("hidden", "claims", "domain") and random.random() < 0.55):
            nodes = grower.flat()
        else:
            nodes = grower.tree()
        if not nodes:
            return None
        if random.random() < 0.35:
            nodes = grower.damaged(nodes)
        if not nodes:
            return None
        objects = None
        if kind == "hidden" or (kind in ("claims", "domain") and random.random() < 0.25):
            objects = self.hide(nodes, grower.world)
        file = plan_file(nodes, random, objects)
        case = Case(kind, self.seed, domain, environment, file, random.random() < 0.4)
        if kind == "claims" or (kind in ("hidden", "domain") and random.random() < 0.3):
            self.claim(case, grower.world)
        return case

    def hide(self, nodes: list[dict], world: World) -> list[str] | None:
        """Hides arguments, all or some; the objects are told where the plan has any."""
        handled: list[str] = []
        for step in read({"task_cohesion": {"task_tree": nodes}}, world).steps:
            if step is not None and step.call.object:
                parameters = [name for name, _ in step.call.action.parameters]
                value = step.choices[parameters.index(step.call.object)][0]
                if value is not None and f"<{value}>" not in handled:
                    handled.append(f"<{value}>")
        plans.hide(nodes, self.random, self.random.choice([0.5, 1.0, 1.0]))
        return handled if handled and self.random.random() < 0.7 else None

    def claim(self, case: Case, world: World) -> None:
        """Adds a claim: the environment after one of the endings, as it is or damaged."""
        endings = self.endings(case, world)
        facts = set(world.written(self.random.choice(endings)))
        if len(endings) > 1 and self.random.random() < 0.5:
            # A little of each ending: no single one may be as claimed.
            facts |= set(world.written(self.random.choice(endings)))
        for _ in range(self.random.choice([0, 0, 1, 2])):
            self.damage_claim(facts, world)
        claim = render.environment_of(world, facts)
        if self.random.random() < 0.4:
            for key in ("asset_states", "object_states"):
                for name in list(claim[key]):
                    if self.random.random() < 0.4:
                        del claim[key][name]
        case.file["environment_after"] = claim

    def endings(self, case: Case, world: World) -> list[frozenset]:
        """The last states of a plan, or the first one where nothing better is known."""
        try:
            plan = read(case.file, world)
            if plan.issues:
                return [world.initial]
            arguments = hidden.find(plan, world, None) if any(step.open for step in plan.steps) else {}
            if arguments is None:
                return [world.initial]
            endings = hidden.simulate(plan, world, arguments).endings
        except (OverBound, hidden.Undecided):
            return [world.initial]
        return sorted(endings, key=sorted) or [world.initial]

    def grouped(self, grouper: groups.Grouper, word: str, subject):
        """The subject of a constraint with groups."""
        if word == "untouched":
            return grouper.group(subject)
        return grouper.goal(subject)

    def damage_claim(self, facts: set, world: World) -> None:
        """Takes a fact out of a claim, puts one in, or moves one elsewhere."""
        fact = plans.Grower.fact_of(world, self.random)
        kind = self.random.random()
        if facts and kind < 0.6:
            gone = self.random.choice(sorted(facts))
            facts.discard(gone)
            if kind < 0.4 and len(gone) == 3:
                [_, (_, kind_of)] = world.words.pddl.predicates[gone[0]]
                facts.add((gone[0], gone[1], self.random.choice(world.of_type(kind_of))))
        elif fact is not None:
            facts.add(fact)

    def goals(self, kind: str, domain: str, environment: dict, world: World) -> Iterator[Case]:
        """Goals that make sense here, alone and in pairs."""
        options = []
        for form, goal in world.words.goals.items():
            for binding in world.bindings(goal.parameters):
                if goal.offered is None or world.truth(goal.offered, binding, world.initial):
                    options.append((form, tuple(binding.values())))
        self.random.shuffle(options)
        for number in range(min(3, len(options))):
            chosen = options[number : number + (2 if self.random.random() < 0.3 else 1)]
            if kind == "solve":
                yield Case(kind, self.seed, domain, environment, goals=chosen)
                continue
            chosen = [self.random.choice(options) for _ in range(self.random.choice([1, 2, 2, 3]))]
            stages = [at for at in range(1, len(chosen)) if self.random.random() < 0.7]
            if any(chosen[at] in chosen[:at] and at not in stages for at in range(len(chosen))):
                continue
            constraints = []
            for _ in range(self.random.choice([0, 0, 1, 1, 2])):
                word = self.random.choice(["never", "never", "always", "untouched"])
                entities = [name for name in world.types if name not in dict(world.words.pddl.constants)]
                constraints.append((word, self.random.choice(entities if word == "untouched" else options)))
            if kind == "groups":
                grouper = groups.Grouper(world, self.random)
                chosen = [grouper.goal(goal) for goal in chosen]
                constraints = [(word, self.grouped(grouper, word, subject)) for word, subject in constraints]
            yield Case(kind, self.seed, domain, environment, goals=chosen, stages=stages, constraints=constraints)

