"""Random plans: walks through applicable actions, grown into trees and lanes, and then damaged now and then."""

import copy
from random import Random

from .plan import Bound, Plan, Reader
from .render import written
from .walk import OverBound, Walk
from .world import GroundAction, World, holds

# States that a plan under construction may be in.
STATES = 6


class Grower:
    """Grows random plans in one world."""

    def __init__(self, world: World, random: Random):
        self.world = world
        self.random = random
        self.last = ""
        self.actions = [action for action in world.all_actions() if action.condition is not False]
        self.sensing = [action for action in self.actions if action.senses]
        self.acting = [action for action in self.actions if not action.senses]
        self.named: dict[bool, dict[str, list[GroundAction]]] = {True: {}, False: {}}
        for action in self.actions:
            self.named[bool(action.senses)].setdefault(action.name, []).append(action)

    # --- nodes -----------------------------------------------------------------------------------------------

    def entry(self, action: GroundAction) -> dict:
        """The step of an action, with all that its call hides."""
        call = self.world.words.call_of(action.name)
        binding = dict(zip((name for name, _ in call.action.parameters), action.arguments))
        shown = ", ".join(written(self.world, binding[name]) for name in call.shown)
        entry: dict = {"call": f"{call.name}({shown})"}
        if call.hidden:
            entry["implicit"] = {name[1:]: written(self.world, binding[name]) for name in call.hidden}
        return entry

    def after(self, entries: list[dict], states: frozenset) -> tuple[frozenset, bool]:
        """The states after nodes, and if nothing is wrong with them."""
        reader = Reader(self.world, [])
        nodes = reader.nodes(entries)
        walk = Walk(Bound(Plan(nodes, reader.steps), self.world, {}))
        try:
            return walk.nodes(nodes, states), walk.result.valid
        except OverBound:
            return states, False

    def applicable(self, actions: list[GroundAction], states: frozenset) -> list[GroundAction]:
        """The actions that can be done in all of the states."""
        return [action for action in actions if all(holds(action.condition, state) for state in states)]

    def pick(self, actions: list[GroundAction]) -> GroundAction:
        """One of the actions, each name as likely as another."""
        name = self.random.choice(sorted({action.name for action in actions}))
        return self.random.choice([action for action in actions if action.name == name])

    def find(self, states: frozenset, sensing: bool) -> GroundAction | None:
        """An action that can be done in all of the states: any name is as likely as another, the last one less so."""
        by_name = self.named[sensing]
        names = self.random.sample(sorted(by_name), len(by_name))
        if self.last in names and self.random.random() < 0.8:
            names.remove(self.last)
            names.append(self.last)
        idle = None
        for name in names:
            for action in self.random.sample(by_name[name], len(by_name[name])):
                if all(holds(action.condition, state) for state in states):
                    if sensing or any(self.world.apply(action, state) != state for state in states):
                        return action
                    idle = action
                    break
        return idle

    def step(self, states: frozenset, sensing: bool = False) -> dict | None:
        """A step that can be done, and mostly one that changes something."""
        action = self.find(states, sensing)
        if action is None:
            return None
        self.last = action.name
        return self.entry(action)

    # --- lists -----------------------------------------------------------------------------------------------

    def steps(self, states: frozenset, length: int) -> tuple[list[dict], frozenset]:
        """Steps one after the other; a step that breaks an `always` rule is mostly not taken."""
        entries: list[dict] = []
        for _ in range(length):
            entry = self.step(states)
            if entry is None:
                break
            after, fine = self.after([entry], states)
            if fine or self.random.random() < 0.1:
                entries.append(entry)
                states = after
        return entries, states

    def closing(self, states: frozenset, depth: int = 4, nodes: int = 40) -> list[dict]:
        """A few steps after which the `end` rules are kept, if there are any nearby."""
        waiting = [(states, [])]
        seen = {states}
        while waiting and nodes:
            now, done = waiting.pop(0)
            if not any(self.world.broken("end", state) for state in now):
                return [self.entry(action) for action in done]
            if len(done) == depth:
                continue
            nodes -= 1
            options = self.applicable(self.acting, now)
            self.random.shuffle(options)
            for action in options:
                after = frozenset(self.world.apply(action, state) for state in now)
                if after not in seen and not any(
                    self.world.newly_broken(state, self.world.apply(action, state)) for state in now
                ):
                    seen.add(after)
                    waiting.append((after, [*done, action]))
        return []

    def flat(self) -> list[dict]:
        """A list of steps; the end is mostly one that keeps the rules."""
        entries, states = self.steps(frozenset([self.world.initial]), self.random.randint(1, 8))
        return entries + self.closing(states)

    # --- trees -----------------------------------------------------------------------------------------------

    def fact(self, states: frozenset) -> tuple | None:
        """A fact that an environment can say: mostly one that has to do with the states."""
        some = self.random.choice(sorted(states, key=sorted))
        said = sorted(self.world.written(some))
        if said and self.random.random() < 0.6:
            return self.random.choice(said)
        return self.fact_of(self.world, self.random)

    @staticmethod
    def fact_of(world: World, random: Random) -> tuple | None:
        """Any fact that an environment can say."""
        word = random.choice(sorted(world.words.states.values(), key=lambda word: word.name))
        choices = [world.of_type(kind) for _, kind in world.words.pddl.predicates[word.predicate]]
        if any(not names for names in choices):
            return None
        return (word.predicate, *(random.choice(names) for names in choices))

    def ask(self, states: frozenset) -> dict:
        """A condition that asks for a state, or one that senses."""
        for _ in range(5):
            fact = self.fact(states)
            if fact is None:
                break
            words = [word for word in self.world.words.states.values() if word.predicate == fact[0]]
            walk = Walk(Bound(Plan([], []), self.world, {}))
            if words and (all(walk.known(fact, state) for state in states) or self.random.random() < 0.1):
                word = words[0]
                binding = dict(zip(word.terms, fact[1:]))
                arguments = [written(self.world, binding[name]) for name in ["?self", *word.parameters]]
                return {"call": f"{word.name}({', '.join(arguments)})"}
        return {"all": []}

    def condition(self, states: frozenset, depth: int) -> dict:
        """A condition of calls with `not`, `and` and `or`."""
        kind = self.random.random()
        if depth and kind < 0.12:
            return {"not": self.condition(states, depth)}
        if depth and kind < 0.32:
            parts = [self.condition(states, depth - 1) for _ in range(self.random.randint(2, 3))]
            return {self.random.choice(["all", "any"]): parts}
        if kind < 0.75 and self.sensing:
            entry = self.step(states, sensing=True)
            if entry is not None:
                return entry
        return self.ask(states)

    def node(self, states: frozenset, depth: int) -> dict | None:
        """A random node, not yet tried."""
        kind = self.random.random()
        if depth == 0 or kind < 0.5:
            return self.step(states)
        if kind < 0.6:
            return self.step(states, sensing=True)
        if kind < 0.82:
            return self.branch(states, depth)
        body, _ = self.steps(states, self.random.randint(1, 2))
        if kind < 0.92:
            if self.random.random() < 0.2:
                body, _ = self.nodes(states, 2, depth - 1)
            return {"while": self.condition(states, 1), "do": body}
        if self.random.random() < 0.3:
            body, _ = self.nodes(states, 2, depth - 1)
        return {"repeat": self.random.choice([0, 1, 2, 2, 3, 5, 50, 1001]), "do": body}

    def branch(self, states: frozenset, depth: int) -> dict:
        """A branch whose sides are grown in the states that come to them."""
        condition = self.condition(states, 2)
        reader = Reader(self.world, [])
        walk = Walk(Bound(Plan([], []), self.world, {}))
        truths = walk.condition(reader.condition(condition), states)
        then, _ = self.nodes(truths[True] or states, self.random.randint(0, 3), depth - 1)
        other, _ = self.nodes(truths[False] or states, self.random.randint(0, 3), depth - 1)
        return {"if": condition, "then": then, **({"else": other} if other else {})}

    def nodes(self, states: frozenset, length: int, depth: int) -> tuple[list[dict], frozenset]:
        """Nodes one after the other; what is wrong is mostly thrown away."""
        entries: list[dict] = []
        tries = 0
        while len(entries) < length and tries < 2 * length + 2:
            tries += 1
            entry = self.node(states, depth)
            if entry is None or "all': []" in str(entry):
                continue
            after, fine = self.after([entry], states)
            if len(after) > STATES or not after or not (fine or self.random.random() < 0.04):
                continue
            entries.append(entry)
            states = after
        return entries, states

    def tree(self) -> list[dict]:
        """A tree of steps."""
        states = frozenset([self.world.initial])
        entries: list[dict] = []
        if self.random.random() < 0.5:
            entries, states = self.steps(states, self.random.randint(1, 4))
        more, states = self.nodes(states, self.random.randint(1, 5), 2)
        return entries + more + self.closing(states)

    # --- lanes -----------------------------------------------------------------------------------------------

    def lanes(self) -> list[dict]:
        """Steps of a walk as lanes, with syncs at some of the places where somebody else goes on."""
        entries = self.flat_of_two()
        density = self.random.choice([0.0, 0.3, 0.6, 1.0, 1.0])
        nodes: list[dict] = []
        stretch: list[tuple[str, dict]] = []

        def close() -> None:
            if len({actor for actor, _ in stretch}) > 1:
                nodes.append(self.parallel(stretch, density))
            else:
                nodes.extend(entry for _, entry in stretch)
            stretch.clear()

        for actor, entry in entries:
            if actor is None:
                close()
                nodes.append(entry)
            else:
                stretch.append((actor, entry))
        close()
        return nodes

    def flat_of_two(self) -> list[tuple[str | None, dict]]:
        """A walk, each step with its actor."""
        states = frozenset([self.world.initial])
        entries: list[dict] = []
        for _ in range(self.random.randint(2, 6)):
            more, states = self.steps(states, self.random.randint(1, 2))
            entries += more
        entries += self.closing(states)
        return [(self.actor(entry), entry) for entry in entries]

    def actor(self, entry: dict) -> str | None:
        """The one that does a step."""
        reader = Reader(self.world, [])
        step = reader.step(entry)
        if step is None or step.call.actor is None:
            return None
        return step.choices[[name for name, _ in step.call.action.parameters].index(step.call.actor)][0]

    def parallel(self, stretch: list[tuple[str, dict]], density: float) -> dict:
        """Lanes from a stretch of steps."""
        lanes: dict[str, list] = {actor: [] for actor in sorted({actor for actor, _ in stretch})}
        before = stretch[0][0]
        for number, (actor, entry) in enumerate(stretch):
            if actor != before and self.random.random() < density:
                for steps in lanes.values():
                    steps.append({"sync": f"s{number}"})
            before = actor
            lanes[actor].append(entry)
        return {"parallel": [{"lane": actor, "do": steps} for actor, steps in lanes.items()]}

    # --- damage ----------------------------------------------------------------------------------------------

    def damaged(self, nodes: list[dict]) -> list[dict]:
        """The nodes with one thing changed."""
        nodes = copy.deepcopy(nodes)
        lists = [part for part in blocks(nodes) if part]
        if not lists or not self.world.all_actions():
            return nodes
        part = self.random.choice(lists)
        place = self.random.randrange(len(part))
        kind = self.random.randrange(6)
        if kind == 0:
            del part[place]
        elif kind == 1 and len(part) > 1:
            other = self.random.randrange(len(part))
            part[place], part[other] = part[other], part[place]
        elif kind == 2:
            part.insert(place, copy.deepcopy(part[place]))
        elif kind == 3:
            part.insert(place, self.entry(self.pick(self.world.all_actions())))
        elif kind == 4 and "call" in part[place]:
            part[place] = self.entry(self.pick(self.world.all_actions()))
        else:
            self.other_argument(part[place])
        return nodes

    def other_argument(self, node: dict) -> None:
        """Puts another entity in the place of one of a step's arguments."""
        names = [written(self.world, name) for name in self.world.types]
        if "call" not in node:
            return
        if node.get("implicit"):
            key = self.random.choice(sorted(node["implicit"]))
            node["implicit"][key] = self.random.choice(names)
            return
        found = [name for name in names if name.startswith("<") and name in node["call"]]
        if found:
            others = [name for name in names if name.startswith("<")]
            node["call"] = node["call"].replace(self.random.choice(found), self.random.choice(others))


def blocks(nodes: list[dict]) -> list[list[dict]]:
    """All lists of nodes in a plan."""
    found = [nodes]
    for node in nodes:
        for key in ("then", "else", "do"):
            if key in node:
                found += blocks(node[key])
        for lane in node.get("parallel", []):
            found.append(lane["do"])
    return found


def hide(nodes: list[dict], random: Random, share: float) -> None:
    """Leaves out what calls can hide."""
    for part in blocks(nodes):
        for node in part:
            for entry in [node, *senses_in(node.get("if")), *senses_in(node.get("while"))]:
                for key in list(entry.get("implicit", {})):
                    if random.random() < share:
                        del entry["implicit"][key]
                if entry.get("implicit") == {}:
                    del entry["implicit"]


def senses_in(condition: dict | None) -> list[dict]:
    """The calls in a condition."""
    if condition is None:
        return []
    if "call" in condition:
        return [condition]
    parts = [condition["not"]] if "not" in condition else condition.get("all", condition.get("any", []))
    return [call for part in parts for call in senses_in(part)]
