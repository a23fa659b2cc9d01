"""Purposes: goals with stages and constraints, as docs/reference/goals.md has them."""

from dataclasses import dataclass, field
from functools import cached_property

from ..numbers import State
from ..order import bound
from ..search import at_end
from ..world import complement, holds, join
from .view import keys_of, truth
from .world import NumberAction, NumberWorld

# States of one search; a question that needs more is not decided.
STATES = 1_500
# States among which an example is looked for in which two parts of a goal hold.
WITNESSES = 300
# States from which a step is looked for that achieves one part and leaves another false.
ANEW = 60


@dataclass
class Wanted:
    """A part of a goal: its text, its ground condition, and the plain goals in it (for rules that these set aside)."""

    text: str
    condition: object
    goals: list[tuple] = field(default_factory=list)


@dataclass
class Constraint:
    """`never` or `always` with a condition, `untouched` with an entity, or `never` with an action and its arguments."""

    word: str
    text: str
    condition: object = None
    entity: str | None = None
    call: tuple | None = None
    goals: list[tuple] = field(default_factory=list)
    # True for a rule, which outlasts the goal and sets no other rule aside.
    standing: bool = False

    def forbids(self, action: NumberAction) -> bool:
        """True for a step that the constraint excludes by its name and arguments."""
        if self.word == "untouched":
            return self.entity in action.arguments
        if self.call is None:
            return False
        name, arguments = self.call
        pairs = zip(arguments, action.arguments)
        return name == action.name and all(wanted in ("_", own) for wanted, own in pairs)


@dataclass
class Purpose:
    """Stages of wanted parts, and constraints; `made` for a purpose that is the changes of a plan.

    `hidden` are changes that nothing shows: a strict reading asks for them too.
    """

    world: NumberWorld
    stages: list[list[Wanted]]
    constraints: list[Constraint]
    made: bool = False
    anew: dict = field(default_factory=dict)
    hidden: list = field(default_factory=list)

    def text(self) -> str:
        """The purpose in the goal language."""
        stages = [" & ".join(part.text for part in stage if part.text) for stage in self.stages]
        return " & ".join([" then ".join(stages), *(own.text for own in self.constraints)])

    @cached_property
    def kept(self) -> list:
        """The conditions that a step may not break: name and condition."""
        rules = [(f"rule {name}", own) for name, _, own in self.world.rules["always"]]
        for own in self.constraints:
            if own.condition is not None:
                rules.append((own.text, own.condition if own.word == "always" else complement(own.condition)))
        return rules

    def at_end(self) -> list:
        """The rules for the end: those that the goals do not set aside, without the tidy ones for the changes of a plan."""
        if self.made:
            return [own for _, _, own in self.world.rules["end"]]
        spoken = [goal for stage in self.stages for part in stage for goal in part.goals]
        # What has always to be so sets rules aside too.
        spoken += [goal for own in self.constraints if own.word == "always" and not own.standing for goal in own.goals]
        return at_end(self.world, spoken)

    def parts(self) -> list[tuple[int, Wanted]]:
        """All parts with their stages."""
        return [(number, part) for number, stage in enumerate(self.stages) for part in stage]

    def is_kept(self, number: int, part: Wanted) -> bool:
        """True for a part that has to hold at the end: one of the last stage, or one that no later one excludes.

        A part does not exclude another if a state that can be reached satisfies both, unless the domain says that it does.
        """
        later = [other for following in self.stages[number + 1 :] for other in following]
        groups = self.groups_of(part)
        if any(groups & self.groups_of(other) for other in later):
            return False
        if not all(self.together(part.condition, other.condition) for other in later):
            return False
        # A group to choose from is given up too if later goals leave too few members.
        members = [bound(self.world, form, arguments) for form, arguments in part.goals]
        lost = [own for own in members if len(members) > 1 and any(not self.together(own, other.condition) for other in later)]
        return not lost or self.together(part.condition, *map(complement, lost))

    def together(self, *conditions) -> bool:
        """True if a state that can be reached satisfies all conditions."""
        wanted = join("and", list(conditions))
        return any(holds(wanted, own) for own in self.reachable())

    def groups_of(self, part: Wanted) -> set[tuple]:
        """The groups of goals of the domain in which a part is, each with the first argument."""
        goals = self.world.words.goals
        return {(goals[form].group, *arguments[:1]) for form, arguments in part.goals if goals[form].group}

    def is_anew(self, number: int, place: int) -> bool:
        """True for a part of a later stage to which no exception can apply.

        It does not hold from the beginning, and there is a step which achieves the stage before it and after which it does not hold.
        """
        key = (number, place)
        if key not in self.anew:
            part, before = self.stages[number][place].condition, self.stages[number - 1]
            self.anew[key] = not holds(part, self.world.initial) and len(before) == 1 and self.is_free(part, before[0].condition)
        return self.anew[key]

    def is_free(self, part, before) -> bool:
        """True if some step achieves `before` and leaves `part` false."""
        wanted = join("and", [before, complement(part)])
        # Events count from the beginning of their stage, which no single state shows.
        if any(key[0] in self.world.words.events for key in keys_of(wanted)):
            return False
        actions = [action for action in self.world.all_actions() if action.condition is not False]
        for state in self.reachable()[:ANEW]:
            if holds(before, state):
                continue
            for action in actions:
                after = self.world.successor(action, state)
                if after is not None and holds(wanted, after):
                    return True
        return False

    def missing(self, state: State) -> list[Wanted]:
        """The parts that have to hold at the end and do not hold in a state."""
        false = [(number, part) for number, part in self.parts() if not holds(part.condition, state)]
        return [part for number, part in false if self.is_kept(number, part)]

    def reachable(self) -> list[State]:
        """States that can be reached from the beginning, up to a bound."""
        if self.world.reached is None:
            self.world.reached = reach(self.world, self.world.initial)
        return self.world.reached


def reach(world: NumberWorld, start: State) -> list[State]:
    """The states that can be reached, up to a bound."""
    actions = [action for action in world.all_actions() if action.condition is not False]
    seen, waiting = {start.key()}, [start]
    for state in waiting:
        if len(waiting) >= WITNESSES:
            break
        for action in actions:
            after = world.successor(action, state)
            if after is not None and after.key() not in seen and not world.newly_broken(state, after):
                seen.add(after.key())
                waiting.append(after)
    return waiting


# --- progress through the stages ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Progress:
    """The stage, which of its parts are achieved, which may count, and the events since the stage began."""

    stage: int = 0
    done: frozenset = frozenset()
    open: frozenset = frozenset()
    events: frozenset = frozenset()


class Tracker:
    """Follows the stages of a purpose.

    A strict tracker counts only what every reading of the pages counts: each part has to become true after its stage has begun.
    A lenient one asks for this where no exception of docs/reference/goals.md can apply.
    """

    def __init__(self, purpose: Purpose, strict: bool):
        self.purpose, self.strict = purpose, strict
        self.happening = purpose.world.words.events

    def start(self, view) -> Progress:
        """The progress in the first state."""
        return self.on(Progress(open=frozenset(range(len(self.purpose.stages[0]))) if self.purpose.stages else frozenset()), view)

    def on(self, progress: Progress, view, events: frozenset = frozenset()) -> Progress:
        """The progress in the next state, after these events."""
        stages = self.purpose.stages
        stage, done, counting = progress.stage, progress.done, progress.open
        since = progress.events | events
        while stage < len(stages):
            parts = stages[stage]
            own = view.with_events(since, self.happening) if stage else view
            known = [truth(part.condition, own) for part in parts]
            true = {place for place, truth_now in enumerate(known) if truth_now is True}
            # A strict reading looks once, when the stage begins.
            counting |= frozenset() if self.strict and stage else self.countable(known)
            done |= {place for place in true if place in counting or not self.is_anew(stage, place)}
            if len(done) < len(parts):
                break
            stage, done, since = stage + 1, frozenset(), frozenset()
            if stage < len(stages):
                own = view.with_events(since, self.happening)
                counting = self.countable([truth(part.condition, own) for part in stages[stage]])
        return Progress(stage, frozenset(done), frozenset(counting), since)

    def countable(self, known: list[bool | None]) -> frozenset:
        """The parts that count when they become true: false ones, and for a lenient tracker those that are unsure."""
        return frozenset(place for place, now in enumerate(known) if now is False or (now is None and not self.strict))

    def is_anew(self, stage: int, place: int) -> bool:
        """True for a part that has to become true after its stage has begun."""
        return self.strict or (stage > 0 and self.purpose.is_anew(stage, place))

    def is_complete(self, progress: Progress) -> bool:
        """True after the last stage."""
        return progress.stage == len(self.purpose.stages)


def events_of(world: NumberWorld, action: NumberAction, state: State) -> frozenset:
    """The events that a step brings about."""
    facts = (fact for when, sign, fact in action.effects if sign and holds(when, state))
    return frozenset(fact for fact in facts if fact[0] in world.words.events)


# --- verdicts -------------------------------------------------------------------------------------------------------


def untouched_changed(purpose: Purpose, entity: str, before: State, after: State, strict: bool = False) -> bool:
    """True if a step changes what every reading counts as the place or the state of an entity; for a strict verdict, what any does."""
    world = purpose.world
    if strict:
        changed = {key for key, own in after.numbers.items() if before.numbers.get(key) != own} | (before ^ after)
        return any(entity in key[1:] for key in changed)
    for key, subject in world.subjects.items():
        if subject != entity or (key[0] != "#" and key[1] != entity):
            continue
        if key[0] == "#":
            if before.numbers.get(key[1]) != after.numbers.get(key[1]):
                return True
        elif (key in before) != (key in after):
            return True
    return False


def step_faults(purpose: Purpose, action: NumberAction, state: State, strict: bool = False) -> list[str]:
    """The faults of a step in a state: its precondition, constraints and rules that it breaks."""
    world = purpose.world
    after = world.successor(action, state)
    if after is None:
        return ["precondition"]
    faults = [f"forbidden by {own.text}" for own in purpose.constraints if own.forbids(action)]
    for name, condition in purpose.kept:
        if holds(condition, state) and not holds(condition, after):
            faults.append(f"breaks {name}")
    for own in purpose.constraints:
        if own.word == "untouched" and untouched_changed(purpose, own.entity, state, after, strict):
            faults.append(f"changes what {own.text} protects")
    return faults


def plan_faults(purpose: Purpose, steps: list[NumberAction], state: State, strict: bool) -> list[str]:
    """The faults of a list of steps from a state; a strict verdict counts only what every reading accepts."""
    tracker = Tracker(purpose, strict)
    progress = tracker.start(StateView(state))
    for number, action in enumerate(steps, 1):
        faults = step_faults(purpose, action, state, strict)
        if faults:
            return [f"step {number}: {fault}" for fault in faults]
        events = events_of(purpose.world, action, state)
        state = purpose.world.apply(action, state)
        progress = tracker.on(progress, StateView(state), events)
    faults = []
    if not tracker.is_complete(progress):
        faults.append(f"stage {progress.stage + 1} is not complete")
    missing = [own for _, own in purpose.parts() if not holds(own.condition, state)] if strict else purpose.missing(state)
    faults += [f"not reached: {part.text}" for part in missing]
    faults += ["a rule for the end" for own in purpose.at_end() if not holds(own, state)]
    return faults


class StateView:
    """A state that is known entirely."""

    def __init__(self, state: State):
        self.state = state
        self.numbers = state.numbers

    def fact(self, fact: tuple) -> bool:
        """The truth of a fact."""
        return fact in self.state

    def with_events(self, events: frozenset, happening: set[str]) -> "StateView":
        """The same with these events alone."""
        if not happening:
            return self
        facts = frozenset(fact for fact in self.state if fact[0] not in happening) | events
        return StateView(State.of(facts, self.numbers))


def find_plan(purpose: Purpose, state: State, progress: Progress, excluded: set, limit: int = STATES) -> list | str | None:
    """A plan that every reading accepts, `over` if the bound is reached, or none.

    The search follows the stages from `progress` on, and asks for all parts of all stages at the end.
    """
    world, tracker = purpose.world, Tracker(purpose, strict=True)
    wanted = join("and", [part.condition for stage in purpose.stages for part in stage] + purpose.at_end() + purpose.hidden)
    actions = [own for own in world.all_actions() if own.condition is not False and (own.name, own.arguments) not in excluded]
    actions = [own for own in actions if not any(constraint.forbids(own) for constraint in purpose.constraints)]
    untouched = [own.entity for own in purpose.constraints if own.word == "untouched"]
    first = (state, tracker.on(progress, StateView(state)))
    if tracker.is_complete(first[1]) and holds(wanted, state):
        return []
    seen, waiting = {(state.key(), first[1])}, [(*first, [])]
    for state, at, done in waiting:
        if len(seen) > limit:
            return "over"
        binding = [condition for _, condition in purpose.kept if holds(condition, state)]
        for action in actions:
            after = world.successor(action, state)
            if after is None or not all(holds(condition, after) for condition in binding):
                continue
            if any(untouched_changed(purpose, entity, state, after, strict=True) for entity in untouched):
                continue
            on = tracker.on(at, StateView(after), events_of(world, action, state))
            key = (after.key(), on)
            if key in seen:
                continue
            if tracker.is_complete(on) and holds(wanted, after):
                return [*done, action]
            seen.add(key)
            waiting.append((after, on, [*done, action]))
    return None
