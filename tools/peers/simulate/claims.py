"""Claims: what `environment_after` promises, and whether an ending keeps it."""

from .plan import Bound
from .world import World, as_list


def claimed(world: World, after: dict) -> set[tuple]:
    """The facts that a claim says of entities and in words that mean something here."""
    facts = set()
    for key in ("asset_states", "object_states"):
        for entity, entry in after.get(key, {}).items():
            for text in as_list(entry):
                try:
                    fact = world.fact_of_word(entity.strip("<>"), text)
                except (KeyError, ValueError):
                    continue
                if all(name in world.types for name in fact[1:]) and world.fits(fact):
                    facts.add(fact)
    return facts


def possible(world: World) -> set[tuple]:
    """The facts that some action could bring about: it has them as an effect, and what never changes allows it."""
    if not hasattr(world, "brought_about"):
        world.brought_about = {
            fact
            for action in world.all_actions()
            if action.condition is not False
            for when, sign, fact in action.effects
            if sign and when is not False
        }
    return world.brought_about


def subject(world: World, fact: tuple) -> str | None:
    """The entity or term that a fact is said of: that of the state word which says it, or else the first argument."""
    for word in world.words.states.values():
        if word.predicate == fact[0] and "?self" in word.terms:
            return fact[1 + word.terms.index("?self")]
    return fact[1] if len(fact) > 1 else None


def hides_place(world: World, call) -> list[str]:
    """The predicates of the places of a call's object, if the call changes them and hides an argument besides the object."""
    if call.object is None or not set(call.hidden) - {call.object, call.actor}:
        return []
    found = []

    def look(effect: tuple) -> None:
        if effect[0] == "and":
            for part in effect[1]:
                look(part)
        elif effect[0] in ("forall", "when"):
            look(effect[2])
        elif len(effect[2]) == 2 and subject(world, (effect[1], *effect[2])) == call.object:
            found.append(effect[1])

    look(call.action.effect)
    return found


def promises(bound: Bound, after: dict) -> set[tuple]:
    """What has to hold at the end: claimed and new and possible, or claimed as the place of what such a call handles."""
    world = bound.world
    said = claimed(world, after)
    may = possible(world)
    wanted = {fact for fact in said if fact not in world.initial and fact in may}
    for step in bound.plan.steps:
        action = step and bound.action(step)
        if not action:
            continue
        parameters = [name for name, _ in step.call.action.parameters]
        for predicate in hides_place(world, step.call):
            thing = action.arguments[parameters.index(step.call.object)]
            wanted |= {fact for fact in said if fact[0] == predicate and subject(world, fact) == thing and fact in may | world.initial}
    return wanted


def kept(bound: Bound, after: dict | None, endings: frozenset) -> bool:
    """True if one ending keeps every promise."""
    if after is None:
        return True
    wanted = promises(bound, after)
    if "claims-by-parts" in bound.world.faults:
        return all(any(fact in ending for ending in endings) for fact in wanted)
    return any(wanted <= ending for ending in endings)
