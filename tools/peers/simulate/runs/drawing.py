"""Random purposes: goals that a walk through a world achieves in their order, and constraints that it mostly keeps."""

from .. import groups
from ..numbers import MILLION, State, decimal
from ..order import bound
from ..render import written
from ..world import holds
from .purpose import Constraint, Wanted
from .world import NumberAction, NumberWorld


class Drawer:
    """Draws purposes for a world."""

    def __init__(self, world: NumberWorld, random):
        self.world, self.random = world, random
        self.options = []
        for form, goal in world.words.goals.items():
            for binding in world.bindings(goal.parameters):
                if goal.offered is None or world.truth(goal.offered, binding, world.initial):
                    self.options.append((form, tuple(binding.values())))
        self.keys = [key[1] for key in world.subjects if key[0] == "#"]

    def goal(self, form: str, arguments: tuple) -> list[Wanted]:
        """A goal, or the goals for which one with a group stands."""
        world = self.world
        text = form
        for (name, _), own in zip(world.words.goals[form].parameters, arguments):
            shown = own.text(world, groups.is_overloaded(world, form)) if isinstance(own, groups.Group) else written(world, own)
            text = text.replace("{" + name[1:] + "}", shown)
        found = []
        for place, goal in enumerate(groups.goals_of(world, form, arguments)):
            plain = [own for _, own in goal[0].goals] if isinstance(goal[0], groups.Choice) else [goal]
            # One text stands for all goals of a group.
            found.append(Wanted(text if place == 0 else "", bound(world, *goal), plain))
        return found

    def comparison(self, state: State) -> Wanted | None:
        """A comparison that a state satisfies."""
        known = [key for key in self.keys if key in state.numbers]
        if not known:
            return None
        key = self.random.choice(known)
        own = state.numbers[key]
        sign, other = self.random.choice([("=", own), (">=", own), ("<=", own), (">", own - MILLION), ("<", own + MILLION)])
        word = next(word for word, number in self.world.words.numbers.items() if number.name == key[0])
        inner = f"({', '.join(written(self.world, name) for name in key[1:])})" if key[1:] else ""
        condition = ("compares", (sign, ("fluent", key), ("number", other)))
        return Wanted(f"{word}{inner} {sign} {decimal(other)}", condition)

    def part(self, state: State | None, before: State | None) -> list[Wanted]:
        """A part that holds in a state, and mostly not in one before it; any part without a state."""
        random = self.random
        if random.random() < 0.3 and self.keys:
            own = self.comparison(state or self.world.initial)
            if own is not None and (before is None or not holds(own.condition, before) or random.random() < 0.2):
                return [own]
        options = random.sample(self.options, min(len(self.options), 25))
        fitting = []
        for goal in options:
            condition = bound(self.world, *goal)
            if state is None or holds(condition, state):
                changed = before is None or not holds(condition, before)
                fitting.append((not changed, goal))
        fitting.sort(key=lambda own: own[0] and random.random() < 0.9)
        if not fitting:
            return []
        form, arguments = fitting[0][1]
        if random.random() < 0.12:
            grouper = groups.Grouper(self.world, random)
            try:
                form, grouped = grouper.goal((form, arguments))
                return self.goal(form, grouped)
            except groups.Refused:
                pass
        return self.goal(form, arguments)

    def stages(self, states: list[State | None]) -> list[list[Wanted]]:
        """One stage for each state, or for a few of them."""
        random = self.random
        count = random.choice([1, 1, 1, 1, 2, 2, 3])
        places = sorted(random.sample(range(1, len(states)), min(count - 1, max(0, len(states) - 2)))) + [len(states) - 1]
        stages, before = [], states[0]
        for place in places:
            stage: list[Wanted] = []
            for _ in range(random.choice([1, 1, 1, 2])):
                for part in self.part(states[place], before):
                    if part.text not in [own.text for own in stage] or not part.text:
                        stage.append(part)
            if stage and stage[0].text:
                stages.append(stage)
            before = states[place]
        return stages

    def constraint(self, states: list[State], steps: list[NumberAction]) -> Constraint | None:
        """A constraint, mostly one that a list of steps keeps."""
        random, world = self.random, self.world
        kind = random.random()
        if kind < 0.25:
            entities = [name for name in world.types if name not in dict(world.words.pddl.constants)]
            entity = random.choice(entities)
            return Constraint("untouched", f"untouched({written(world, entity)})", entity=entity)
        if kind < 0.4:
            actions = [own for own in world.all_actions() if own.condition is not False]
            if not actions:
                return None
            action = random.choice(actions)
            call = world.words.call_of(action.name)
            if call.hidden or not action.arguments:
                return None
            arguments = tuple("_" if random.random() < 0.4 else own for own in action.arguments)
            shown = ", ".join(own if own == "_" else written(world, own) for own in arguments)
            return Constraint("never", f"never {call.name}({shown})", call=(action.name, arguments))
        word = random.choice(["never", "never", "always"])
        if random.random() < 0.3 and self.keys:
            own = self.comparison(random.choice(states))
        else:
            options = self.goal(*random.choice(self.options)) if self.options else []
            own = options[0] if options else None
        if own is None:
            return None
        return Constraint(word, f"{word} {own.text}", condition=own.condition, goals=own.goals)
