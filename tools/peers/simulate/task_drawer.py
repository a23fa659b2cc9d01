"""Random planning tasks."""

import itertools
from dataclasses import dataclass, field, replace
from random import Random

from .task_machine import OPERATORS, Machine
from .tasks import Action, Goal, Task, changes, in_words, with_member

SIGNS = sorted(OPERATORS)
# The predicates that say on which rung a vat is.
COUNTERS = {"on", "fit", "held"}
# Tasks that are drawn until one has a state so many steps away, among so many states.
TRIES, DEEP, STATES = 20, 5, 1_500
# Goals of which the one that takes the most steps is taken.
GOALS = 12


@dataclass
class Drawer:
    """Draws random tasks."""

    random: Random
    costs: bool = True
    numeric: bool = True
    fresh: int = 0
    predicates: dict = field(default_factory=dict)
    # Actions that move counters, with flags that follow them and that other actions require.
    chained: bool = False

    def chance(self, share: float) -> bool:
        """True in a share of the cases."""
        return self.random.random() < share

    def task(self) -> tuple[Task, list]:
        """A task with plans to verify; most are hard for what their actions are."""
        deep = self.chance(0.6)
        for _ in range(TRIES if deep else 1):
            task = self.candidate()
            machine = Machine(task)
            steps = machine.distances(STATES) if deep else {}
            if max(steps.values(), default=0) >= DEEP:
                task = self.with_distant_goal(task, machine, steps)
                break
        else:
            task = self.with_goal(task, machine)
        machine = Machine(task)
        return task, [self.walk(machine, self.random.randint(1, 5))[0] for _ in range(2)]

    def candidate(self) -> Task:
        """A task."""
        random = self.random
        self.costs, self.numeric, self.fresh = self.chance(0.75), self.chance(0.5), 0
        self.chained = self.chance(0.6)
        vats = tuple((f"v{number}", "vat") for number in range(random.choice([1, 2, 2, 2, 3])))
        rungs = tuple((f"r{number}", "rung") for number in range(random.choice([2, 3, 3, 4])))
        kinds = {"lit": ("vat",), "wet": ("vat",), "shut": ("vat",), "on": ("vat", "rung"), "fit": ("vat", "rung"), "held": ("vat", "rung"),
                 "tied": ("vat", "vat"), "rain": (), "ready": ()}  # fmt: skip
        chosen = random.sample(sorted(kinds), random.randint(2, 5))
        if self.chained:
            flags = [name for name in sorted(kinds) if kinds[name] in ((), ("vat",))]
            chosen = random.sample(flags, 3) + random.sample(sorted(COUNTERS), random.choice([1, 2, 2, 3]))
        elif self.chance(0.6) and "on" not in chosen:
            chosen.append("on")
        self.predicates = {name: kinds[name] for name in chosen}
        predicates = (*self.predicates.items(), ("above", ("rung", "rung")))
        functions = (("level", ("vat",)), ("charge", ())) if self.numeric else ()
        functions += (("rate", ("vat",)),) if self.costs else ()
        facts = {("above", rungs[place + 1][0], rungs[place][0]) for place in range(len(rungs) - 1)}
        for name, own in self.predicates.items():
            if name in COUNTERS:
                # Mostly a counter: one rung for each vat.
                facts |= {(name, vat, random.choice(rungs)[0] if self.chance(0.3) else "r0") for vat, _ in vats if self.chance(0.9)}
            else:
                choices = itertools.product(*([n for n, k in vats + rungs if k == kind] for kind in own))
                facts |= {(name, *choice) for choice in choices if self.chance(0.3)}
        numbers = tuple(
            ((name, *choice), random.randint(0, 2 if name != "rate" else 3))
            for name, own in functions
            for choice in itertools.product(*([n for n, _ in vats] for _ in own))
        )
        actions = tuple(self.action(f"do{number}") for number in range(random.randint(2, 5)))
        task = Task(vats + rungs, predicates, functions, actions, frozenset(facts), numbers, costs=self.costs)
        return task

    # --- actions ---------------------------------------------------------------------------------------------------

    def action(self, name: str) -> Action:
        """A random action."""
        parameters = tuple((f"?{'xyz'[place]}", self.random.choice(["vat", "vat", "vat", "rung"]))
                           for place in range(self.random.choice([0, 1, 1, 1, 2])))  # fmt: skip
        scope = dict(parameters)
        if self.chained:
            return self.link(name, parameters, scope)
        condition = ("and", *(self.condition(scope, 1) for _ in range(self.random.choice([0, 1, 1, 2]))))
        effects = tuple(own for _ in range(self.random.randint(1, 4)) if (own := self.effect(scope, 2)) is not None)
        if not effects:
            effects = (("set", True, *self.atom(scope)[1:]),)
        return Action(name, parameters, condition, effects, self.cost(scope))

    def link(self, name: str, parameters: tuple, scope: dict) -> Action:
        """An action that requires a flag, moves counters, and sets flags by where these are."""
        if self.chance(0.15):
            effects = [("set", True, *self.flag(scope)[1:]) for _ in range(2)]
            return Action(name, parameters, ("and",), tuple(effects), self.cost(scope))
        required = [self.flag(scope)] if self.chance(0.85) else []
        effects = []
        for counter in self.counters():
            if self.chance(0.75):
                effects.append(self.counter(scope, counter, required))
        if self.chance(0.5) or not effects:
            effects.append(("set", self.chance(0.8), *self.flag(scope)[1:]))
        return Action(name, parameters, ("and", *required), tuple(effects), self.cost(scope))

    def cost(self, scope: dict) -> tuple | None:
        """A cost, which may be zero; None for an action without one."""
        if not self.costs or self.chance(0.2):
            return None
        vats = [name for name, kind in scope.items() if kind == "vat"]
        if vats and self.chance(0.25):
            return ("fluent", "rate", self.random.choice(vats))
        return ("number", self.random.choice([0, 0, 1, 1, 2, 3, 5]))

    def variable(self) -> str:
        """A variable that nothing else is called."""
        self.fresh += 1
        return f"?v{self.fresh}"

    def term(self, kind: str, scope: dict) -> str:
        """A term of a type: a variable of the scope, or else an object that every task has."""
        fitting = [name for name, own in scope.items() if own == kind]
        return self.random.choice(fitting) if fitting and not self.chance(0.12) else {"vat": "v0", "rung": "r1"}[kind]

    def atom(self, scope: dict) -> tuple:
        """A fact."""
        name, kinds = self.random.choice(sorted(self.predicates.items()))
        return ("fact", name, *(self.term(kind, scope) for kind in kinds))

    def fluent(self, scope: dict) -> tuple:
        """A number that changes."""
        return ("fluent", "charge") if self.chance(0.3) else ("fluent", "level", self.term("vat", scope))

    def counters(self) -> list[str]:
        """The predicates that say on which rung a vat is."""
        return sorted(COUNTERS & set(self.predicates))

    def flag(self, scope: dict) -> tuple:
        """A fact that is no counter, if there is one."""
        names = [name for name in sorted(self.predicates) if name not in self.counters()]
        if not names:
            return self.atom(scope)
        name = self.random.choice(names)
        return ("fact", name, *(self.term(kind, scope) for kind in self.predicates[name]))

    def condition(self, scope: dict, depth: int) -> tuple:
        """A condition."""
        kind = self.random.random()
        if depth and kind < 0.15:
            return ("and" if self.chance(0.5) else "or", *(self.condition(scope, depth - 1) for _ in range(2)))
        if depth and kind < 0.3:
            variable, own = self.variable(), self.random.choice(["vat", "rung"])
            return ("forall" if self.chance(0.5) else "exists", ((variable, own),), self.condition({**scope, variable: own}, depth - 1))
        if self.numeric and kind < 0.5:
            other = self.fluent(scope) if self.chance(0.3) else ("number", self.random.randint(0, 3))
            return ("compare", self.random.choice(SIGNS), self.fluent(scope), other)
        if kind > 0.95 and len(scope) > 1:
            one, two = self.random.sample(sorted(scope), 2)
            return ("=", one, two) if self.chance(0.3) else ("not", ("=", one, two))
        atom = self.atom(scope)
        return ("not", atom) if self.chance(0.4) else atom

    def effect(self, scope: dict, depth: int) -> tuple | None:
        """An effect."""
        kind = self.random.random()
        if kind < 0.22 and self.counters():
            return self.counter(scope, self.random.choice(self.counters()), [])
        if kind < 0.4 and self.numeric:
            return self.change(scope)
        if depth and kind < 0.6:
            inner = self.effect(scope, depth - 1)
            return inner and ("when", self.condition(scope, 1), inner)
        if depth and kind < 0.75:
            variable, own = self.variable(), self.random.choice(["vat", "rung"])
            inner = self.effect({**scope, variable: own}, depth - 1)
            return inner and ("forall", ((variable, own),), inner)
        return ("set", self.chance(0.6), *self.atom(scope)[1:])

    def counter(self, scope: dict, name: str, required: list) -> tuple:
        """Moves a vat one rung up or down, with what may come with it; a flag that is required is lost often."""
        vat, old, new = self.term("vat", scope), self.variable(), self.variable()
        steps = ("above", new, old) if self.chance(0.5) else ("above", old, new)
        when = ("and", ("fact", name, vat, old), ("fact", *steps))
        done = [("set", False, name, vat, old), ("set", True, name, vat, new)]
        if not self.chained and self.chance(0.3):
            done.append(("set", self.chance(0.5), *self.atom({**scope, old: "rung"})[1:]))
        self.random.shuffle(done)
        parts = [("forall", ((old, "rung"), (new, "rung")), ("when", when, ("and", *done)))]
        # Flags that depend on the rung before the step.
        for _ in range(self.random.choice([0, 1, 1, 2] if self.chained else [0, 0, 1])):
            other = self.variable()
            tests = [("=", other, self.random.choice(["r0", "r1"])), ("fact", "above", other, "r0"), ("fact", "above", "r1", other)]
            reached = ("and", ("fact", name, vat, other), self.random.choice(tests))
            made = ("set", self.chance(0.5), *self.flag(scope)[1:])
            if required and self.chance(0.4):
                made = ("set", False, *required[0][1:])
            parts.append(("forall", ((other, "rung"),), ("when", reached, made)))
        return ("and", *parts) if len(parts) > 1 else parts[0]

    def change(self, scope: dict) -> tuple:
        """Changes a number; mostly within bounds."""
        fluent = self.fluent(scope)
        kind = self.random.choice(["assign", "increase", "increase", "decrease"])
        value = ("number", self.random.randint(0, 3) if kind == "assign" else self.random.randint(1, 2))
        if kind == "assign" and self.chance(0.2):
            value = self.fluent(scope)
        made = (kind, fluent[1], fluent[2:], value)
        if kind == "assign":
            return made
        bound = ("compare", "<", fluent, ("number", self.random.randint(2, 4)))
        if kind == "decrease":
            bound = ("compare", ">", fluent, ("number", self.random.randint(-1, 1)))
        return ("when", bound, made)

    # --- goals -----------------------------------------------------------------------------------------------------

    def walk(self, machine: Machine, length: int) -> tuple[list, tuple]:
        """A random plan, mostly of possible steps, and the state after them."""
        state, plan = machine.start, []
        for _ in range(length):
            possible = [(words, after) for words, _, after in machine.steps if after(*state) not in (None, state)]
            if not possible or self.chance(0.08):
                if machine.steps:
                    plan.append(self.random.choice(machine.steps)[0])
                break
            words, after = self.random.choice(possible)
            plan.append(words)
            state = after(*state)
        return plan, state

    def with_goal(self, task: Task, machine: Machine) -> Task:
        """The task with a goal: what a walk changed, or what chance brings."""
        if self.chance(0.4):
            return self.with_stages(task, machine)
        if self.chance(0.35):
            return replace(task, goal=("and", *(self.condition({}, 2) for _ in range(self.random.randint(1, 2)))))
        _, state = self.walk(machine, self.random.randint(2, 8))
        changed = self.changed(machine, state)
        if not changed:
            return replace(task, goal=("and", self.condition({}, 2)))
        return replace(task, goal=("and", *self.random.sample(changed, min(len(changed), self.random.randint(1, 3)))))

    def with_distant_goal(self, task: Task, machine: Machine, steps: dict) -> Task:
        """The task with a goal that takes many steps."""
        states = sorted(steps, key=lambda state: (steps[state], state))
        far = states[-max(1, len(states) // 5) :]
        goals = []
        for _ in range(GOALS):
            literals = self.literals(machine, self.random.choice(far))
            chosen = self.random.sample(literals, min(len(literals), self.random.randint(1, 3)))
            goal = ("and", *chosen)
            holds = machine.condition(goal)
            goals.append((min(count for state, count in steps.items() if holds(*state)), len(goals), goal))
        return replace(task, goal=max(goals)[2])

    def literals(self, machine: Machine, state: tuple) -> list[tuple]:
        """Conditions that hold in a state, about what actions may change."""
        facts, numbers = state
        found = []
        for fact, place in sorted(machine.bits.items()):
            if fact[0] != "above":
                found.append(("fact", *fact) if facts >> place & 1 else ("not", ("fact", *fact)))
        for fluent, place in sorted(machine.places.items()):
            if fluent[0] != "rate":
                sign = self.random.choice(["=", ">=", "<="])
                found.append(("compare", sign, ("fluent", *fluent), ("number", numbers[place])))
        return found

    def changed(self, machine: Machine, state: tuple) -> list[tuple]:
        """Conditions that hold in a state and not at first."""
        (facts, numbers), (first, before) = state, machine.start
        found = []
        for fact, place in sorted(machine.bits.items()):
            if (facts ^ first) >> place & 1:
                found.append(("fact", *fact) if facts >> place & 1 else ("not", ("fact", *fact)))
        for fluent, place in sorted(machine.places.items()):
            if numbers[place] != before[place]:
                sign = self.random.choice(["=", ">=" if numbers[place] > before[place] else "<="])
                found.append(("compare", sign, ("fluent", *fluent), ("number", numbers[place])))
        return found

    def with_stages(self, task: Task, machine: Machine) -> Task:
        """The task with a goal in words: stages and constraints."""
        stages = []
        _, state = self.walk(machine, self.random.randint(2, 8))
        likely = [own for own in self.changed(machine, state) if own[0] != "not"]
        for _ in range(self.random.choice([1, 2, 2, 2, 3])):
            stage: list[Goal] = []
            known: set = set()
            for _ in range(self.random.choice([1, 1, 2])):
                goal = self.plain(self.random.choice(likely)) if likely and self.chance(0.5) else self.goal(task)
                if not known & set(goal.conditions):
                    known |= set(goal.conditions)
                    stage.append(goal)
            stages.append(tuple(stage))
        constraints = tuple(self.constraint(task) for _ in range(self.random.choice([0, 0, 1, 1, 2])))
        return replace(task, stages=tuple(stages), constraints=constraints)

    def plain(self, condition: tuple) -> Goal:
        """A fact or a comparison as a goal."""
        return Goal(in_words(condition), (condition,))

    def single(self, task: Task, vat: str) -> tuple:
        """A fact about a vat or nothing, or a comparison."""
        objects = {"vat": [vat], "rung": task.of_type("rung")}
        if self.numeric and self.chance(0.4):
            left = ("fluent", "level", vat)
            other = self.random.choice(task.of_type("vat"))
            right = ("fluent", "level", other) if self.chance(0.3) and other != vat else ("number", self.random.randint(0, 3))
            return ("compare", self.random.choice(SIGNS), left, right)
        # A fact without arguments that no action changes is no goal.
        changed = set().union(*(changes(effect) for action in task.actions for effect in action.effects))
        names = [name for name, kinds in sorted(self.predicates.items()) if kinds or name in changed]
        if not names:
            return ("fact", "above", "r1", "r0")
        name = self.random.choice(names)
        return ("fact", name, *(self.random.choice(objects[kind]) for kind in self.predicates[name]))

    def goal(self, task: Task) -> Goal:
        """A goal, which may be for a group."""
        vats = task.of_type("vat")
        if self.chance(0.7):
            return self.plain(self.single(task, self.random.choice(vats)))
        # The members stand for one vat in the goal.
        sample = self.single(task, "v0")
        if sample.count("v0") != 1 and not (sample[0] == "compare" and sample[3][0] == "number"):
            return self.plain(sample)
        each = [with_member(sample, vat) for vat in vats]
        number = self.random.randint(1, len(vats))
        group = self.random.choice(["all vat", "all vats", "any vat", f"{number} of vat", f"exactly {number} of vat"])
        written = in_words(with_member(sample, group))
        if group.startswith("all"):
            return Goal(written, tuple(each))
        if group.startswith("any"):
            return Goal(written, (("or", *each),))
        counts = [("and", *chosen) for chosen in itertools.combinations(each, number)]
        more = [("and", *chosen) for chosen in itertools.combinations(each, number + 1)]
        condition = ("or", *counts)
        return Goal(written, (("and", condition, ("not", ("or", *more))) if "exactly" in group else condition,))

    def constraint(self, task: Task) -> tuple:
        """A constraint: its word, the rest of its words, and its conditions or the entity."""
        if self.chance(0.3):
            entity = self.random.choice([name for name, _ in task.objects])
            return "untouched", f"({entity})", entity
        condition = self.single(task, self.random.choice(task.of_type("vat")))
        return self.random.choice(["never ", "never ", "always "]), in_words(condition), (condition,)
