"""Breadth-first search over ground actions: the length of a shortest plan, or that there is none."""

from .world import World, join

# States of one search.
LIMIT = 60_000
UNSOLVABLE = "unsolvable"
OVER = "over"


class Compiler:
    """Turns ground conditions and actions into Python over states that are numbers, a bit for each fact."""

    def __init__(self, world: World):
        self.world = world
        self.bits: dict[tuple, int] = {}

    def bit(self, fact: tuple) -> int:
        """The bit of a fact."""
        return 1 << self.bits.setdefault(fact, len(self.bits))

    def source(self, ground) -> str:
        """A condition as an expression over `s`."""
        if ground is True or ground is False:
            return str(ground)
        head, rest = ground
        if head in ("is", "not"):
            return f"{'' if head == 'is' else 'not '}s & {self.bit(rest)}"
        return "(" + f" {head} ".join(f"({self.source(part)})" for part in rest) + ")"

    def condition(self, ground):
        """A condition as a function."""
        return eval(f"lambda s: {self.source(ground)}")  # the text is made of numbers and operators alone

    def effect(self, action):
        """An action's effect as a function."""
        always = {True: 0, False: 0}
        lines = []
        for when, sign, fact in action.effects:
            if when is True:
                always[sign] |= self.bit(fact)
            else:
                lines.append(f"    if {self.source(when)}: {'a' if sign else 'd'} |= {self.bit(fact)}")
        text = f"def effect(s):\n    a, d = {always[True]}, {always[False]}\n" + "\n".join(lines)
        text += "\n    return s & ~d | a\n"
        scope: dict = {}
        exec(text, scope)
        return scope["effect"]

    def events(self, action):
        """The events that an action brings about, as a function of the state."""
        lines = [
            f"    if {self.source(when)}: e |= {self.bit(fact)}"
            for when, sign, fact in action.effects
            if sign and fact[0] in self.world.words.events
        ]
        scope: dict = {}
        exec("def events(s):\n    e = 0\n" + "\n".join(lines) + "\n    return e\n", scope)
        return scope["events"]

    def all_bits(self) -> list[tuple[tuple, int]]:
        """Every fact with its bit."""
        return [(fact, 1 << place) for fact, place in self.bits.items()]

    def split(self, number: int) -> list[int]:
        """The bits of a number."""
        return [1 << place for place in range(number.bit_length()) if number >> place & 1]

    def number(self, state: frozenset) -> int:
        """A state as a number."""
        return sum(self.bit(fact) for fact in state)


def goal_condition(world: World, goals: list[tuple[str, tuple[str, ...]]]):
    """What has to hold in the last state: the goals, and the rules that they do not set aside."""
    parts = []
    for form, arguments in goals:
        goal = world.words.goals[form]
        parts.append(world.ground(goal.condition, dict(zip((name for name, _ in goal.parameters), arguments))))
    return join("and", parts + at_end(world, goals))


def at_end(world: World, goals: list[tuple[str, tuple[str, ...]]]) -> list:
    """The rules for the last state that goals do not set aside."""
    spoken: dict[str, set[str]] = {}
    for form, arguments in goals:
        spoken.setdefault(form.split("(")[0], set()).update(world.words.goals[form].about(arguments))
    parts = []
    for sort in ("end", "tidy"):
        for rule in world.words.rules:
            if rule.holds != sort:
                continue
            aside = set().union(*(spoken.get(word, set()) for word in rule.unless))
            for binding in world.bindings(rule.variables):
                if not aside & set(binding.values()):
                    parts.append(world.ground(rule.condition, binding))
    return parts


def shortest(world: World, goals: list[tuple[str, tuple[str, ...]]], limit: int = LIMIT) -> int | str:
    """The number of steps of a shortest plan, or that there is none, or that the bound was reached."""
    compiler = Compiler(world)
    wanted = compiler.condition(goal_condition(world, goals))
    actions = [
        (compiler.condition(action.condition), compiler.effect(action))
        for action in world.all_actions()
        if action.condition is not False and not action.senses
    ]
    always = [] if "no-always" in world.faults else world.rules["always"]
    rules = [compiler.condition(condition) for _, _, condition in always]
    start = compiler.number(world.initial)
    extra = 1 if "longer" in world.faults else 0
    if wanted(start):
        return 0
    seen, layer, depth = {start}, [start], 0
    while layer:
        depth += 1
        following = []
        for state in layer:
            kept = [rule for rule in rules if rule(state)]
            for applicable, effect in actions:
                if not applicable(state):
                    continue
                after = effect(state)
                if after in seen or not all(rule(after) for rule in kept):
                    continue
                if wanted(after):
                    return depth + extra
                seen.add(after)
                following.append(after)
        if len(seen) > limit:
            return OVER
        layer = following
    return UNSOLVABLE
