"""The ends of runs: "Done" is true as far as docs/reference/execution.md promises, and a stop has a true reason."""

from ..numbers import State
from ..world import as_list, holds
from .belief import ASSUMED, OBSERVED, PROMISED, SURMISED
from .purpose import find_plan
from .view import keys_of, truth

# The beginning of the reason of each stop, as it is printed.
NO_PLAN = "no plan achieves the goal from here"
NOT_SEEN = "not observed: "


def check_done(judge, event: dict) -> None:
    """The purpose holds, and all that it rests on was shown or is listed."""
    belief, purpose = judge.belief, judge.purpose
    if any(own.end == "under way" for own in judge.orders.values()):
        judge.blame("done with an order under way")
    if not judge.looked:
        judge.blame("done without a look")
    check_environment(judge, event.get("environment", {}))
    listed = check_listed(judge, event.get("unseen", []))
    if judge.settings.trust == "observed":
        for key, basis in listed.items():
            if basis in ("promised", "assumed") and key not in judge.confirmed:
                judge.blame("a promise is trusted", f"{key} {basis}")

    def counts(key: tuple) -> bool:
        # What no look of the end has shown has to be listed, apart from facts that never change, and from those that nothing can
        # show and no order could have changed.
        if key in belief.shown or key in judge.confirmed or key in listed or not judge.changes(key):
            return True
        return not belief.visible(key) and belief.source_of(key)[0] == ASSUMED

    view = belief.view(counts)
    for stage, part in purpose.parts():
        known = truth(part.condition, view)
        if known is not True and not judge.is_open(part.condition) and purpose.is_kept(stage, part):
            missing = sorted(str(key) for key in keys_of(part.condition) if not counts(key))
            judge.blame("false done", f"{part.text or 'a member'}: {'not so' if known is False else f'not shown {missing}'}, stage {stage + 1}")
    if judge.denied:
        judge.blame("done although a person says that it is not so")
    touched = {key for own in judge.orders.values() for key in own.action.touches()}
    for condition in purpose.at_end():
        known = truth(condition, belief.view(lambda key: counts(key) or key not in touched))
        if known is not True and not judge.is_open(condition):
            missing = sorted(str(key) for key in keys_of(condition) if key in touched and not counts(key))
            judge.blame("false done", f"a rule for the end is {'broken' if known is False else f'not shown: {missing}'}")
    if not judge.lenient.is_complete(judge.progress):
        judge.blame("false done", f"stage {judge.progress.stage + 1} never was complete")


def check_listed(judge, unseen: list[dict]) -> dict[tuple, str]:
    """The facts and numbers that no look of the end has shown, by their basis, which has to be the true one."""
    belief, found = judge.belief, {}
    for own in unseen:
        read = judge.sentences.read(own["what"])
        if read is None:
            judge.blame("a sentence without a meaning", own["what"])
            continue
        key, value = read
        found[key] = own["basis"]
        source, order = belief.source_of(key)
        basis = {ASSUMED: "assumed", PROMISED: "promised", OBSERVED: "seen", SURMISED: "word"}[source]
        if not belief.visible(key):
            basis = "word"
        if key in judge.confirmed and basis in ("assumed", "promised"):
            # A person's word may be listed as what it replaces.
            continue
        if own["basis"] != basis:
            judge.blame("another basis", f"{own['what']} is {basis}, not {own['basis']}")
        elif basis in ("seen", "promised") and own.get("order") != order:
            judge.blame("another basis", f"{own['what']} is {basis} by order {order}, not {own.get('order')}")
        if belief.value(key) != value and source != SURMISED:
            judge.blame("listed as unseen and not believed", own["what"])
        if key in belief.shown:
            judge.blame("listed as unseen although the last looks show it", own["what"])
    return found


def check_stop(judge, event: dict) -> None:
    """The reason is true."""
    why = event["why"]
    check_environment(judge, event.get("environment", {}))
    if why.startswith(NOT_SEEN):
        check_unseen(judge)
    if event["proven"]:
        if why.startswith(NO_PLAN):
            check_no_plan(judge)
        else:
            check_broken(judge, why)
        return


def check_environment(judge, environment: dict) -> None:
    """The environment at the end is the believed one."""
    if not environment:
        return
    facts, numbers = set(), {}
    for key in ("asset_states", "object_states"):
        for entity, entry in environment.get(key, {}).items():
            judge.world.read(entity.strip("<>"), as_list(entry), facts, numbers)
    judge.world.read(None, environment.get("facts", []), facts, numbers)
    told = State.of(facts, numbers)
    if any(judge.belief.differs(key, judge.belief.state, told) for key in judge.entries.visible):
        # What an environment does not say may follow from the rest, or be usual.
        told = type(judge.world)(judge.world.words, {**judge.world.environment, **environment}).initial
    # An environment cannot deny what is usual.
    usual = {fact[1] for fact, _ in judge.world.words.defaults}
    for key in judge.entries.visible:
        if key[0] in usual:
            continue
        if judge.world.subjects[key] is None and "facts" not in environment:
            continue
        if judge.certain(key) and judge.belief.differs(key, judge.belief.state, told):
            judge.blame("another environment at the end", str(key))
            return


def check_unseen(judge) -> None:
    """A fact of the goal was not seen: the purpose does not follow from what was observed."""
    if judge.settings.trust == "promised":
        judge.blame("a stop for a promise that is trusted")
    view = judge.belief.view(judge.evident)
    known = [truth(part.condition, view) for _, part in judge.purpose.parts()]
    known += [truth(condition, view) for condition in judge.purpose.at_end()]
    if all(own is True for own in known) and judge.lenient.is_complete(judge.progress):
        judge.blame("stopped for a fact that was not seen, and all are seen")


def check_no_plan(judge) -> None:
    """No plan exists from the believed world: an exhaustive search finds none."""
    belief = judge.belief
    if any(source == SURMISED for source, _ in belief.source.values()):
        judge.counts["proof not examined"] += 1
        return
    retries = judge.world.words.retries
    # A step that had no effect too often is one that the robot cannot do, as one that failed.
    excluded = {key for key, count in (judge.failures + judge.idle).items() if count > retries.get(key[0], 2)}
    progress = judge.strict_progress or judge.strict.start(belief.view(judge.evident))
    plan = find_plan(judge.purpose, belief.state, progress, excluded)
    if plan == "over":
        judge.counts["proof not examined"] += 1
    elif plan is not None:
        steps = ", ".join(f"{own.name}{own.arguments}" for own in plan)
        judge.blame("a plan exists", steps or "the empty one")
    else:
        judge.counts["proof examined"] += 1


def check_broken(judge, why: str) -> None:
    """A constraint or a rule does not hold in the believed world."""
    state = judge.belief.state
    for _, condition in judge.purpose.kept:
        if judge.is_open(condition) or not holds(condition, state):
            judge.counts["broken constraint examined"] += 1
            return
    judge.blame("no constraint is broken", why)


def check_end(judge, ended: dict, given: set[str]) -> None:
    """The stop that the interface returns has a cause in what the robot and the person did."""
    stop = ended["stop"]
    judge.counts[f"end {stop or 'done'}"] += 1
    if (stop is None) != (judge.ended == "done"):
        judge.blame("the log ends otherwise", f"{stop} and {judge.ended}")
    causes = {
        "requested": {"signal", "no answer"},
        "refused": {"refused"},
        "robot": {"robot", "log", "look"},
    }
    if stop == "unseen" and "denied" not in given and judge.settings.approval != "never" and "denies" not in given:
        judge.blame("a stop without a cause", f"nobody was asked: {ended['why']}")
    if judge.counts["said no"]:
        given = given | {"refused"}
    if stop in causes and not causes[stop] & given:
        judge.blame("a stop without a cause", f"{stop}: {ended['why']}")
    if stop == "too-many-changes" and judge.plans < judge.settings.changes:
        judge.blame("a stop without a cause", f"{judge.plans} changes of {judge.settings.changes}")
    if stop == "repeated" and judge.plans < 2:
        judge.blame("a stop without a cause", f"the same world after {judge.plans} changes")




def compare_with_world(judge, robot) -> None:
    """Counts how "Done" relates to the real world, and finds what a harmless run cannot explain."""
    if judge.ended != "done":
        return
    state, belief = robot.state, judge.belief
    wrong = [part.condition for part in judge.purpose.missing(state)]
    if not wrong:
        judge.counts["done and so in the real world"] += 1
        return
    judge.counts["done and not so any more, or not seen"] += 1
    for condition in wrong:
        keys = keys_of(condition)
        if any(not belief.visible(key) or key not in belief.shown for key in keys):
            continue
        differing = {key for key in keys if belief.value(key) != robot.value(key, state)}
        if not differing & robot.changed and not {"lies", "stale"} & set(robot.happened):
            judge.blame("false done in the real world", str(differing))
