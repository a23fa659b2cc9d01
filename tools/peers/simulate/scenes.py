"""Random environments for the shipped domains and for random ones, small enough to be searched through."""

from random import Random

from .words import Words


def brackets(name: str) -> str:
    """An identifier as environments write it."""
    return f"<{name}>"


def household(random: Random, dual: bool) -> dict:
    """Tables, a fridge, a drawer, a bin; things on them and in them."""
    assets = random.sample(["table", "counter", "ledge", "window"], random.randint(1, 3))
    handles = []
    for name in ("fridge", "drawer"):
        if random.random() < 0.35:
            assets.append(name)
            handles.append(name + "_handle")
    if random.random() < 0.4:
        assets.append("trash_bin")
    items = random.sample(["milk", "plate", "carton", "sponge", "vase", "box"], random.randint(1, 3))
    objects = items + handles
    states: dict[str, list[str]] = {}
    for position, name in enumerate(items):
        places = [other for other in assets + items[:position] if other != "window"]
        if places and random.random() < 0.9:
            place = random.choice(places)
            inner = place in ("fridge", "drawer", "trash_bin", "box")
            states[name] = [f"{'inside' if inner else 'on'}_something(<{place}>)"]
    for handle in handles:
        word = random.choice(["open()", "closed()", "closed()", None])
        if word:
            states[handle] = [word]
    properties: dict[str, list[str]] = {}
    for handle in handles:
        if random.random() < 0.7:
            properties[handle] = ["SLIDES" if handle.startswith("drawer") else "ROTATES"]
    for name in items:
        word = random.choice([None, None, "BASE", "CONTAINER", "UPRIGHT", "HEAVY" if dual else None])
        if word:
            properties[name] = [word]
    asset_states: dict[str, list[str]] = {}
    if dual:
        hands = ["right", "left"]
        for name in assets:
            if random.random() < 0.15:
                asset_states[name] = [f"reachable_by({random.choice(hands)})"]
        for hand in hands:
            if random.random() < 0.1:
                name = random.choice(items)
                if not any(word.startswith("inside_hand") for word in states.get(name, [])):
                    states.setdefault(name, []).append(f"inside_hand({hand})")
    elif random.random() < 0.15:
        states.setdefault(random.choice(items), []).append("inside_hand()")
    return finished(assets, objects, asset_states, states, {}, properties)


def checks(random: Random) -> dict:
    """A household in which some outcomes of sensing are known."""
    environment = household(random, dual=False)
    states = environment["object_states"]
    for name in environment["objects"]:
        for group in (["fresh()", "expired()"], ["full()", "half_full()", "empty()"], ["intact()", "broken()"]):
            if random.random() < 0.08 and not name.endswith("_handle>"):
                states.setdefault(name, []).append(random.choice(group))
    for name in environment["assets"]:
        if random.random() < 0.15:
            environment["asset_states"].setdefault(name, []).append(random.choice(["clean()", "dirty()"]))
    return environment


def virtualhome(random: Random) -> dict:
    """A room or two, furniture, devices, and things."""
    rooms = random.sample(["kitchen", "bedroom"], random.randint(1, 2))
    furniture = random.sample(["sofa", "desk", "cabinet", "fridge", "microwave", "stove", "tv", "sink"], random.randint(2, 4))
    things = random.sample(["apple", "mug", "pillow", "plate", "pan", "magazine"], random.randint(1, 3))
    if "sink" in furniture and random.random() < 0.7:
        furniture.append("faucet")
    number = {name: f"{name}_{index + 1}" for index, name in enumerate(rooms + furniture + things)}
    can_open = {"cabinet", "fridge", "microwave", "stove"}
    switch = {"microwave", "stove", "tv", "faucet", "fridge"}
    asset_states: dict[str, list[str]] = {}
    asset_properties: dict[str, list[str]] = {}
    for name in furniture:
        own = number[name]
        asset_states[own] = [f"INSIDE(<{number[random.choice(rooms)]}>)"]
        asset_properties[own] = ["IS_OPENABLE" if name in can_open else "NOT_OPENABLE"]
        asset_properties[own].append("HAS_SWITCH" if name in switch else "NO_SWITCH")
        if name in can_open:
            word = random.choice(["OPEN()", "CLOSED()", "CLOSED()", None])
            asset_states[own] += [word] if word else []
        if name in switch and random.random() < 0.3:
            asset_states[own].append("SWITCHED_ON()")
        if random.random() < 0.1:
            asset_properties[own].append(random.choice(["SURFACE", "HEATS", "HOT_ON_TOP"]))
    for name in rooms:
        asset_properties[number[name]] = ["NOT_OPENABLE", "NO_SWITCH"]
    states: dict[str, list[str]] = {}
    properties: dict[str, list[str]] = {}
    held = False
    for position, name in enumerate(things):
        own = number[name]
        properties[own] = [random.choice(["NOT_OPENABLE", "NOT_OPENABLE", "NOT_OPENABLE", "IS_OPENABLE"]), "NO_SWITCH"]
        if random.random() < 0.3:
            properties[own].append(random.choice(["RECIPIENT", "COOKWARE", "SURFACE"]))
        if not held and random.random() < 0.1:
            states[own], held = ["HELD()"], True
        elif random.random() < 0.93:
            place = random.choice(furniture + things[:position])
            word = "INSIDE" if place in can_open and random.random() < 0.7 else "ON"
            states[own] = [f"{word}(<{number[place]}>)"]
    assets = [number[name] for name in rooms + furniture]
    return finished(assets, [number[name] for name in things], asset_states, states, asset_properties, properties)


def greenhouse(random: Random) -> dict:
    """Beds along a rail, with plants in them."""
    beds = random.sample(["north", "south", "east", "west"], random.randint(2, 3))
    plants = random.sample(["tomato", "basil", "cress", "mint"], random.randint(1, 3))
    states = {name: [f"grows_in(<{random.choice(beds)}>)"] for name in plants}
    for name in plants:
        if random.random() < 0.6:
            states[name].append("dry()")
    asset_states = {random.choice(beds): ["robot_here()"]}
    for name in beds:
        if random.random() < 0.3:
            asset_states.setdefault(name, []).append("vent_open()")
    properties = {name: ["HAS_VENT"] for name in beds if random.random() < 0.6}
    return finished(beds, plants, asset_states, states, properties, {})


def finished(assets, objects, asset_states, object_states, asset_properties, object_properties) -> dict:
    """An environment from its parts."""

    def entries(of: dict) -> dict:
        return {brackets(name): words for name, words in of.items()}

    return {
        "assets": [brackets(name) for name in assets],
        "asset_states": entries(asset_states),
        "objects": [brackets(name) for name in objects],
        "object_states": entries(object_states),
        "asset_properties": entries(asset_properties),
        "object_properties": entries(object_properties),
    }


def opposite(property_word: str) -> str:
    """The property that denies a property of a random domain."""
    return property_word[4:] if property_word.startswith("NOT_") else "NOT_" + property_word


def any_domain(random: Random, words: Words) -> dict:
    """An environment for a random domain, in which every state word is said of some of what it can be said of."""
    assets = random.sample(["gate", "kiosk", "hangar", "plaza"], random.randint(1, 3))
    objects = random.sample(["letter", "drum", "lamp", "spool"], random.randint(1, 3))
    kinds = {**{name: words.asset_type for name in assets}, **{name: words.object_type for name in objects}}
    kinds.update(words.pddl.constants)
    states: dict[str, list[str]] = {}
    outcomes = {predicate: call for call in words.calls.values() for predicate, _ in call.senses}
    for word in words.states.values():
        declared = dict(zip(word.terms, (kind for _, kind in words.pddl.predicates[word.predicate])))
        for name in assets + objects:
            if not words.pddl.is_a(kinds[name], declared["?self"]):
                continue
            if word.predicate in outcomes:
                # At most one outcome is known.
                group = [predicate for predicate, _ in outcomes[word.predicate].senses]
                said = [text.split("(")[0] for text in states.get(name, [])]
                names = {other.name for other in words.states.values() if other.predicate in group}
                if random.random() < 0.15 and not names & set(said):
                    states.setdefault(name, []).append(f"{word.name}()")
                continue
            choices: list[list[str]] = [[]]
            for parameter in word.parameters:
                fitting = [other for other, kind in kinds.items() if words.pddl.is_a(kind, declared[parameter])]
                choices = [done + [other] for done in choices for other in fitting]
            for choice in choices:
                if random.random() < 0.35:
                    constants = {other for other, _ in words.pddl.constants}
                    said = ", ".join(other if other in constants else brackets(other) for other in choice)
                    states.setdefault(name, []).append(f"{word.name}({said})")
    properties: dict[str, list[str]] = {}
    for word, facts in words.properties.items():
        [(_, kind)] = words.pddl.predicates[facts[0][1]]
        for name in assets + objects:
            said = properties.setdefault(name, [])
            if words.pddl.is_a(kinds[name], kind) and random.random() < 0.5 and opposite(word) not in said:
                said.append(word)
    properties = {name: said for name, said in properties.items() if said}
    return finished(
        assets,
        objects,
        {name: states[name] for name in assets if name in states},
        {name: states[name] for name in objects if name in states},
        {name: properties[name] for name in assets if name in properties},
        {name: properties[name] for name in objects if name in properties},
    )
