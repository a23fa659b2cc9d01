"""Lanes side by side: every order in which their steps can happen."""

from .plan import Step


def run(walk, lanes: list, states: frozenset) -> frozenset:
    """The states after lanes; what is wrong with them is told to the walk."""
    if states:
        check(walk, lanes)
    after: set = set()
    for state in states:
        finals = interleave(walk, lanes, state)
        if len(finals) > 1:
            walk.blame("race", None)
        after |= finals
    return frozenset(after)


def check(walk, lanes: list) -> None:
    """What is wrong with lanes whatever the state: who does what, who senses, who can meet whom."""
    names = [name for name, _ in lanes]
    if len(set(names)) < len(names):
        walk.blame("lane_twice", None)
    for name, nodes in lanes:
        for kind, step in nodes:
            if kind != "step":
                continue
            if step.call.senses:
                walk.blame("senses_in_lane", step.number)
            action = walk.action(step, frozenset())
            parameters = [parameter for parameter, _ in step.call.action.parameters]
            actor = step.call.actor
            if actor is None or action.arguments[parameters.index(actor)] != name:
                walk.blame("wrong_actor", step.number)
    for one, other in meeting(lanes, "no-sync" in walk.world.faults):
        if handled(walk, one) & handled(walk, other):
            walk.blame("shared_object", one.number)


def handled(walk, step: Step) -> set[str]:
    """The things that a step handles: those of its arguments that are objects of the environment, not its assets."""
    words = walk.world.words
    arguments = walk.action(step, frozenset()).arguments
    return {name for name in arguments if words.pddl.is_a(walk.world.types[name], words.object_type)}


def moves(lanes: list, positions: tuple, no_sync: bool = False) -> list[tuple[tuple, Step | None]]:
    """The next positions: a lane does a step, or all lanes with a `sync` of one name pass it together."""
    nexts = []
    for index, (_, nodes) in enumerate(lanes):
        if positions[index] == len(nodes):
            continue
        kind, what = nodes[positions[index]]
        if kind == "step":
            nexts.append((positions[:index] + (positions[index] + 1,) + positions[index + 1 :], what))
            continue
        # A lane that has passed its last `sync` of a name is not waited for.
        partners = [number for number, (_, others) in enumerate(lanes) if ("sync", what) in others[positions[number] :]]
        if no_sync:
            partners = [index]
        waiting = [at < len(lanes[number][1]) and lanes[number][1][at] == ("sync", what)
                   for number, at in enumerate(positions)]
        if index == partners[0] and all(waiting[number] for number in partners):
            passed = tuple(at + 1 if number in partners else at for number, at in enumerate(positions))
            nexts.append((passed, None))
    return nexts


def meeting(lanes: list, no_sync: bool) -> list[tuple[Step, Step]]:
    """The pairs of steps of different lanes that can both be next at one time."""
    start = tuple(0 for _ in lanes)
    seen, waiting, pairs = {start}, [start], []
    while waiting:
        positions = waiting.pop()
        nexts = moves(lanes, positions, no_sync)
        steps = [step for _, step in nexts if step is not None]
        pairs += [(one, other) for index, one in enumerate(steps) for other in steps[index + 1 :]]
        for after, _ in nexts:
            if after not in seen:
                seen.add(after)
                waiting.append(after)
    return pairs


def interleave(walk, lanes: list, state: frozenset) -> frozenset:
    """The last states of every order; a violation where nobody can go on."""
    end = tuple(len(nodes) for _, nodes in lanes)
    start = (tuple(0 for _ in lanes), state)
    seen, waiting, finals = {start}, [start], set()
    while waiting:
        positions, now = waiting.pop()
        walk.spend(1)
        if positions == end:
            finals.add(now)
            continue
        nexts = moves(lanes, positions, "no-sync" in walk.world.faults)
        if not nexts:
            walk.blame("deadlock", None)
        if "unordered-lanes" in walk.world.faults:
            nexts = nexts[-1:]
        for after, step in nexts:
            afters = [now] if step is None else [made for _, _, made in walk.step(step, frozenset([now]))]
            for made in afters:
                if (after, made) not in seen:
                    seen.add((after, made))
                    waiting.append((after, made))
    return frozenset(finals)
