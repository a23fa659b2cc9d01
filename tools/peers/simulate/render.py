"""Writers: plans as JSON and as scripts, states as environments."""

import json
import keyword

from .world import World
from .words import split_call


def environment_of(world: World, facts) -> dict:
    """An environment whose entries say the facts for which there is a word."""
    states: dict[str, list[str]] = {}
    for fact in sorted(facts):
        for word in world.words.states.values():
            if word.predicate != fact[0]:
                continue
            binding = dict(zip(word.terms, fact[1:]))
            if any(not term.startswith("?") and term != name for term, name in binding.items()):
                continue
            arguments = ", ".join(written(world, binding[name]) for name in word.parameters)
            states.setdefault(binding["?self"], []).append(f"{word.name}({arguments})")
    constants = {name for name, _ in world.words.pddl.constants}
    environment: dict = {}
    for key, entry, kind in (
        ("assets", "asset_states", world.words.asset_type),
        ("objects", "object_states", world.words.object_type),
    ):
        names = [name for name, own in world.types.items() if own == kind and name not in constants]
        environment[key] = [f"<{name}>" for name in names]
        environment[entry] = {f"<{name}>": states[name] for name in names if name in states}
    for key in ("asset_properties", "object_properties"):
        if key in world.environment:
            environment[key] = world.environment[key]
    return environment


def written(world: World, name: str) -> str:
    """An entity in brackets, a constant without."""
    return name if (name, world.types.get(name)) in world.words.pddl.constants else f"<{name}>"


def script(nodes: list[dict], world: World, depth: int = 0) -> list[str]:
    """The lines of a script for a plan's nodes."""
    pad = "    " * depth
    lines = []
    for node in nodes:
        if "remark" in node:
            lines.append(f"{pad}# {node['remark']}")
        elif "if" in node:
            lines.append(f"{pad}if {condition(node['if'])}:")
            lines += block(node["then"], world, depth)
            if node.get("else"):
                lines.append(f"{pad}else:")
                lines += block(node["else"], world, depth)
        elif "while" in node:
            lines.append(f"{pad}while {condition(node['while'])}:")
            lines += block(node["do"], world, depth)
        elif "repeat" in node:
            lines.append(f"{pad}for _ in range({node['repeat']}):")
            lines += block(node["do"], world, depth)
        elif "parallel" in node:
            lines.append(f"{pad}with parallel():")
            for lane in node["parallel"]:
                lines.append(f'{pad}    with lane("{lane["lane"]}"):')
                lines += block(lane["do"], world, depth + 1)
        elif "sync" in node:
            lines.append(f'{pad}sync("{node["sync"]}")')
        else:
            lines.append(pad + call(node))
    return lines


def block(nodes: list[dict], world: World, depth: int) -> list[str]:
    """The lines of a block, which is never empty."""
    return script(nodes, world, depth + 1) or ["    " * (depth + 1) + "pass"]


def call(node: dict) -> str:
    """A call in a script, with what it hides given by name."""
    name, arguments = split_call(node["call"])
    parts = [f'"{argument}"' for argument in arguments]
    for parameter, value in node.get("implicit", {}).items():
        parts.append(f'{parameter}{"_" if keyword.iskeyword(parameter) else ""}="{value}"')
    return f"{name}({', '.join(parts)})"


def condition(node: dict) -> str:
    """A condition in a script."""
    if "not" in node:
        return f"not {operand(node['not'])}"
    for key, word in (("all", " and "), ("any", " or ")):
        if key in node:
            return word.join(operand(part) for part in node[key])
    return call(node)


def operand(node: dict) -> str:
    """A part of a condition, in parentheses where it has parts itself."""
    return f"({condition(node)})" if "all" in node or "any" in node else condition(node)


def plan_text(file: dict, world: World, as_script: bool) -> str:
    """The text of a plan file; a script carries its objects in its first line."""
    if not as_script:
        return json.dumps(file)
    cohesion = file["task_cohesion"]
    objects = list(cohesion.get("object_names", []))
    if cohesion.get("object_name"):
        objects.append(cohesion["object_name"])
    lines = [f"# objects: {json.dumps(objects)}"] if objects else []
    entries = cohesion.get("task_tree") or [{"call": text} for text in cohesion.get("task_sequence", [])]
    text = "\n".join(lines + script(entries, world)) + "\n"
    rest = {key: value for key, value in file.items() if key != "task_cohesion"}
    return json.dumps({"python_script": text, **rest}) if rest else text
