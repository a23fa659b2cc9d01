"""Goals with an order and with constraints: what they mean, and the length of a shortest plan for them.

Two decisions are the program's and are taken from its answer, since they say what is meant and not what is so: whether a
goal of an earlier stage has to hold at the end (`kept`), and whether one of a later stage has to be achieved anew (`anew`).
"""

from .groups import Choice
from .search import LIMIT, OVER, UNSOLVABLE, Compiler, at_end
from .world import GroundAction, World, complement, holds, join


def bound(world: World, form: str | Choice, arguments: tuple[str, ...]):
    """The condition of a goal."""
    if isinstance(form, Choice):
        return form.condition(world, bound)
    goal = world.words.goals[form]
    return world.ground(goal.condition, dict(zip((name for name, _ in goal.parameters), arguments)))


def ranges(case) -> list[range]:
    """The numbers of the goals of each stage; none without an order."""
    if not case.stages:
        return []
    starts = [0, *case.stages]
    return [range(start, end) for start, end in zip(starts, [*case.stages, len(case.goals)])]


def unchanged(world: World, entity: str):
    """The condition that an entity is as it was: in the facts of the state words of its entry that actions change."""
    words, parts = world.words, []
    told = {predicate for call in words.calls.values() for predicate, _ in call.senses}
    for word in words.states.values():
        if word.predicate not in words.changing or word.predicate in told:
            continue
        declared = words.pddl.predicates[word.predicate]
        variables = [(term, kind) for term, (_, kind) in zip(word.terms, declared) if term in word.parameters]
        for binding in world.bindings(variables):
            fact = (word.predicate, *({**binding, "?self": entity}.get(term, term) for term in word.terms))
            parts.append(("is" if fact in world.initial else "not", fact))
    return join("and", parts)


def constraints(world: World, case) -> tuple[list, set[str]]:
    """The conditions that every state has to keep, and the entities that no step may handle."""
    conditions, untouched = [], set()
    for word, subject in case.constraints:
        if word == "untouched":
            untouched.add(subject)
            conditions.append(unchanged(world, subject))
        else:
            condition = bound(world, *subject)
            conditions.append(condition if word == "always" else complement(condition))
    return conditions, untouched


def waiving(case) -> list:
    """The goals that set rules aside: what is wanted, and what has always to be so."""
    goals = case.goals + [subject for word, subject in case.constraints if word == "always"]
    return [own for goal in goals for own in ([each for _, each in goal[0].goals] if isinstance(goal[0], Choice) else [goal])]


def final(world: World, case, flags: list[dict]):
    """What has to hold in the last state."""
    goals = [bound(world, *goal) for number, goal in enumerate(case.goals) if not flags or flags[number]["kept"]]
    return join("and", goals + at_end(world, waiving(case)))


class Progress:
    """How far a plan has come: the stage, which of its goals are achieved, which count, and the events since it began."""

    def __init__(self, conditions: list, stages: list[range], flags: list[dict], test):
        self.conditions, self.stages, self.flags, self.test = conditions, stages, flags, test

    def start(self, state):
        """The progress before the first step."""
        return self.on((0, frozenset(), frozenset(self.stages[0]) if self.stages else frozenset(), frozenset()), state)

    def on(self, progress, state):
        """The progress in the next state; `progress` has the events already."""
        stage, done, open_goals, events = progress
        while stage < len(self.stages):
            now = {n for n in open_goals - done if self.test(self.conditions[n], state, events if stage else None)}
            done |= now
            if not done >= set(self.stages[stage]):
                break
            stage, done, events = stage + 1, frozenset(), frozenset()
            if stage < len(self.stages):
                counts = lambda n: not (self.flags[n]["anew"] and self.test(self.conditions[n], state, events))
                open_goals = frozenset(n for n in self.stages[stage] if counts(n))
        return stage, done, open_goals, events

    def is_complete(self, progress) -> bool:
        """True after the last stage."""
        return progress[0] == len(self.stages)


def fulfilled(world: World, case, answer: dict) -> bool:
    """True if the plan of an answer keeps the order and the constraints."""
    flags = answer["stages"]

    def test(condition, state, events):
        if events is not None:
            state = frozenset(fact for fact in state if fact[0] not in world.words.events) | events
        return holds(condition, state)

    conditions = [bound(world, *goal) for goal in case.goals]
    progress = Progress(conditions, ranges(case), flags, test)
    kept, untouched = constraints(world, case)
    state = world.initial
    at = progress.start(state)
    for step in answer["bound"]:
        action = world.action(step["action"], tuple(name.strip("<>") for name in step["arguments"]))
        after = world.apply(action, state)
        if untouched & set(action.arguments):
            return False
        if any(holds(condition, state) and not holds(condition, after) for condition in kept):
            return False
        at = progress.on((*at[:3], at[3] | events_of(world, action, state)), after)
        state = after
    return progress.is_complete(at) and holds(final(world, case, flags), state)


def events_of(world: World, action: GroundAction, state: frozenset) -> frozenset:
    """The events that a step brings about, also those that had happened before."""
    facts = (fact for when, sign, fact in action.effects if sign and holds(when, state))
    return frozenset(fact for fact in facts if fact[0] in world.words.events)


def shortest(world: World, case, flags: list[dict], limit: int = LIMIT) -> int | str:
    """The number of steps of a shortest plan, or that there is none, or that the bound was reached."""
    compiler = Compiler(world)
    kept, untouched = constraints(world, case)
    wanted = compiler.condition(final(world, case, flags))
    conditions = [compiler.condition(bound(world, *goal)) for goal in case.goals]
    actions = [
        (compiler.condition(action.condition), compiler.effect(action), compiler.events(action))
        for action in world.all_actions()
        if action.condition is not False and not action.senses and not untouched & set(action.arguments)
    ]
    rules = [compiler.condition(condition) for _, _, condition in world.rules["always"]]
    rules += [compiler.condition(condition) for condition in kept]
    start = compiler.number(world.initial)
    mask = sum(bit for fact, bit in compiler.all_bits() if fact[0] in world.words.events)

    def test(condition, state, events):
        return condition(state if events is None else state & ~mask | sum(events))

    progress = Progress(conditions, ranges(case), flags, test)
    first = (start, progress.start(start))
    if progress.is_complete(first[1]) and wanted(start):
        return 0
    seen, layer, depth = {first}, [first], 0
    while layer:
        depth += 1
        following = []
        for state, at in layer:
            binding = [rule for rule in rules if rule(state)]
            for applicable, effect, events in actions:
                if not applicable(state):
                    continue
                after = effect(state)
                come = events(state)
                since = at[3] | {bit for bit in compiler.split(come)} if come and case.stages else at[3]
                node = (after, progress.on((*at[:3], since), after))
                if node in seen or not all(rule(after) for rule in binding):
                    continue
                if progress.is_complete(node[1]) and wanted(after):
                    return depth
                seen.add(node)
                following.append(node)
        if len(seen) > limit:
            return OVER
        layer = following
    return UNSOLVABLE
