"""Families of domains of one's own: nested quantifiers, effects, rules, derivations, templates; and PDDL problems."""

import json

from genes import Family, choice, size
from measure import Case

COMMANDS = (
    ("domain", "check", "d"),
    ("domain", "show", "d"),
    ("solve", "--goal", "GOAL", "--env", "env.json", "--domain", "d"),
    ("verify", "plan.py", "--env", "env.json", "--domain", "d"),
    ("repair", "plan.py", "--env", "env.json", "--domain", "d"),
    ("plan", "Mark all the spots.", "--env", "env.json", "--domain", "d", "--model", "replay:r.jsonl", "--explain-prompt"),
    ("domain", "check", "d", "--json"),
    ("domain", "check", "d", "--env", "env.json"),
    ("run", "plan.py", "--env", "env.json", "--domain", "d", "--robot", "sim", "--approve", "never", "--log", "run.jsonl", "--goal", "GOAL"),
    ("solve", "--goal", "GOAL", "--env", "env.json", "--domain", "d", "--pddl"),
    ("solve", "--goal", "GOAL", "--env", "env.json", "--domain", "d", "--parallel"),
)

# The head of a recording: the model that prompts are shown for.
HEAD = json.dumps({"recording": {"version": 1, "name": "m", "constraint_kind": "grammar", "counting": {"estimate": "x"}, "context_tokens": None}})

KINDS = ("thing", "spot", "item")
UNARY = ("marked", "lit", "open", "seen")


class Conditions:
    """Random conditions in PDDL over the variables in scope."""

    def __init__(self, genes, rng):
        self.genes, self.rng = genes, rng
        self.fresh = 0

    def atom(self, scope):
        rng = self.rng
        roll = rng.randrange(10)
        if not scope or roll == 0:
            return "(ready)"
        if roll < 3:
            text = f"({rng.choice(UNARY)} {rng.choice(scope)})"
        elif roll < 8:
            text = f"(at {rng.choice(scope)} {rng.choice(scope)})"
        elif roll == 8:
            text = f"(link {rng.choice(scope)} {rng.choice(scope)} {rng.choice(scope)})"
        else:
            text = f"(= {rng.choice(scope)} {rng.choice(scope)})"
        return f"(not {text})" if rng.randrange(100) < self.genes["negated"] else text

    def condition(self, scope, depth, parts, initially=False):
        """Quantifiers `depth` deep around a junction of so many parts."""
        rng = self.rng
        if depth > 0:
            self.fresh += 1
            variable = f"?v{self.fresh}"
            word = ("forall", "exists")[(self.fresh if self.genes["quantifier"] == 2 else self.genes["quantifier"]) % 2]
            inner = self.condition([*scope, variable], depth - 1, parts, initially)
            return f"({word} ({variable} - {KINDS[rng.randrange(self.genes['kinds'] + 1)]}) {inner})"
        if parts <= 1:
            text = self.atom(scope)
            return f"(initially {text})" if initially and rng.random() < 0.3 else text
        word = ("and", "or", "imply", "and")[self.genes["junction"] if self.genes["junction"] != 3 else rng.randrange(3)]
        if word == "imply":
            return f"(imply {self.condition(scope, 0, parts // 2, initially)} {self.condition(scope, 0, parts - parts // 2, initially)})"
        if self.genes["nested"] and parts > 3:
            cut = parts // 2
            other = "or" if word == "and" else "and"
            pieces = [f"({other} {self.condition(scope, 0, cut // 2, initially)} {self.condition(scope, 0, cut - cut // 2, initially)})" for _ in range(2)]
        else:
            pieces = [self.condition(scope, 0, 1, initially) for _ in range(parts)]
        return f"({word} {' '.join(pieces)})"


def domain_pddl(genes, conditions, rng):
    actions = []
    for index in range(genes["actions"]):
        count = min(genes["parameters"], 9)
        scope = [f"?p{place}" for place in range(count)]
        typed = " ".join(f"{name} - {KINDS[rng.randrange(genes['kinds'] + 1)]}" for name in scope)
        before = conditions.condition(scope, genes["action_depth"], genes["action_parts"])
        effects = []
        for number in range(genes["effects"]):
            variables = [f"?e{number}x{place}" for place in range(genes["effect_depth"])]
            target = rng.choice(scope + variables) if scope + variables else None
            second = rng.choice(scope + variables) if scope + variables else None
            fact = "(ready)" if target is None else rng.choice((f"({rng.choice(UNARY)} {target})", f"(at {target} {second})"))
            fact = f"(not {fact})" if rng.random() < 0.3 else fact
            if genes["when_parts"]:
                fact = f"(when {conditions.condition(scope + variables, genes['when_depth'], genes['when_parts'])} {fact})"
            for variable in reversed(variables):
                fact = f"(forall ({variable} - thing) {fact})"
            effects.append(fact)
        actions.append(f"(:action act{index} :parameters ({typed})\n :precondition {before}\n :effect (and {' '.join(effects)}))")
    predicates = "(ready) (at ?x - thing ?y - thing) (link ?x - thing ?y - thing ?z - thing) " + " ".join(f"({name} ?x - thing)" for name in UNARY)
    return (
        "(define (domain d) (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions\n"
        " :quantified-preconditions :conditional-effects :equality)\n (:types spot item - thing)\n"
        f" (:predicates {predicates})\n {chr(10).join(actions)})\n"
    )


def quoted(text):
    return json.dumps(text)


def domain_toml(genes, conditions, rng):
    lines = ['name = "d"', 'about = "A test."', "[environment]", 'assets = "spot"', 'objects = "item"']

    def table(kind, **values):
        lines.append(f"[[{kind}]]")
        lines.extend(f"{key} = {value if isinstance(value, list) else quoted(value)}" for key, value in values.items())

    table("predicate", name="ready", says="it is ready", denies="it is not ready")
    table("predicate", name="at", says="{x} is at {y}", denies="{x} is not at {y}", short="at {y}")
    table("predicate", name="link", says="{x} links {y} and {z}", denies="{x} does not link {y} and {z}")
    for name in UNARY:
        table("predicate", name=name, says=f"{{x}} is {name}", denies=f"{{x}} is not {name}", short=name)
        table("state", word=f"{name}()", fact=f"({name} ?self)", means=f"It is {name}.")
    table("state", word="at(<other>)", fact="(at ?self ?other)", means="It is at <other>.")
    table("state", word="link(<one>, <two>)", fact="(link ?self ?one ?two)", means="It links <one> and <two>.")
    for index in range(genes["actions"]):
        shown = ", ".join(f"?p{place}" for place in range(min(genes["parameters"], 9))) if genes["shown"] else ""
        table("action", name=f"act{index}", call=f"act{index}({shown})", says=f"do act {index}", means=f"Does act {index}.")
    for index in range(genes["rules"]):
        depth = genes["rule_depth"]
        text = conditions.condition([], depth, genes["rule_parts"], initially=True)
        table("rule", name=f"rule{index}", holds=("start", "always", "end", "tidy")[genes["holds"]], condition=text, says="this is not right")
    for index in range(genes["derivations"]):
        when = conditions.condition(["?self", "?other"], genes["derive_depth"], genes["derive_parts"])
        table("derive", facts=["(at ?self ?other)"], when=when)
    for index in range(genes["defaults"]):
        table("default", fact=f"({rng.choice(UNARY)} ?self)", when=conditions.condition(["?self"], genes["derive_depth"], 2))
    for index in range(genes["words"]):
        scope = [f"?g{place}" for place in range(genes["goal_parameters"])]
        form = ", ".join(f"{{g{place}}}" for place in range(genes["goal_parameters"]))
        table(
            "goal",
            form=f"want{index}({form})",
            parameters=" ".join(f"{name} - thing" for name in scope),
            condition=conditions.condition(scope, genes["goal_depth"], genes["goal_parts"]),
            offered=conditions.condition(scope, genes["offered_depth"], 2),
            says=" ".join(["it is wanted that", *(f"{{g{place}}}" for place in range(genes["goal_parameters"]))]),
            means="it is wanted",
            cues=["mark", "want"],
        )
    if genes["lexicon"]:
        lines.append("[lexicon]")
        lines.extend(f'"i{index}" = {json.dumps([f"item {index % 3}", *("x" * k for k in range(1, genes["lexicon"]))])}' for index in range(genes["lexicon"]))
    return "\n".join(lines) + "\n"


TEMPLATES = (
    "{{% for a in actions %}}{{{{ a.call }}}} {{% endfor %}}",
    "{{% for a in range({n}) %}}{{% for b in range({n}) %}}{{% for c in range({n}) %}}x{{% endfor %}}{{% endfor %}}{{% endfor %}}",
    "{{% set ns = namespace(s='x') %}}{{% for i in range({m}) %}}{{% set ns.s = ns.s ~ ns.s %}}{{% endfor %}}{{{{ ns.s }}}}",
    "{{% macro f(k) %}}{{% if k > 0 %}}{{{{ f(k - 1) }}}}{{{{ f(k - 1) }}}}{{% endif %}}{{% endmacro %}}{{{{ f({m}) }}}}",
    "{{{{ 'x' * {n} * {n} * 100 }}}}",
    "{{{{ range({n}) | join('x' * {n}) | replace('x', 'yyyyyyyy' * {n}) }}}}",
    "{{{{ range({n}) | list | string | upper | indent({n}) }}}}",
    "{{% for a in range({n}) | batch(1) %}}{{{{ a }}}}{{% for b in actions %}}{{{{ loop.index }}}}{{% endfor %}}{{% endfor %}}",
)


def environment(genes, rng):
    assets = [f"<s{index}>" for index in range(genes["spots"])]
    objects = [f"<i{index}>" for index in range(genes["items"])]
    names = assets + objects
    states = {name: [f"at({rng.choice(names)})" for _ in range(genes["facts"])] + ([f"{rng.choice(UNARY)}()"] if rng.random() < 0.5 else []) for name in objects}
    states = {name: said for name, said in states.items() if said}
    return {"assets": assets, "asset_states": {}, "objects": objects, "object_states": states}


def domain_case(genes, rng):
    conditions = Conditions(genes, rng)
    world = environment(genes, rng)
    arguments = [rng.choice(world["objects"]) for _ in range(genes["goal_parameters"])]
    goal = " & ".join(f"want{index % max(1, genes['words'])}({', '.join(arguments)})" for index in range(genes["goals"]))
    template = TEMPLATES[genes["template"]].format(n=10 ** genes["loops"], m=genes["doublings"])
    shown = [f'"{rng.choice(world["objects"])}"' for _ in range(min(genes["parameters"], 9))] if genes["shown"] else []
    steps = [f"act{index % max(1, genes['actions'])}({', '.join(shown)})" for index in range(genes["steps"])]
    example = '[[example]]\nobjects = { i0 = "" }\nplaces = { s0 = "" }\ninstruction = "Fly"\nanswer = "question: Where to?"\n'
    files = {
        "d/domain.pddl": domain_pddl(genes, conditions, rng),
        "d/domain.toml": domain_toml(genes, conditions, rng),
        "d/prompt/goal.md": template,
        "d/prompt/examples.toml": example,
        "env.json": json.dumps(world),
        "plan.py": "\n".join(steps) + "\n",
        "r.jsonl": HEAD + "\n",
    }
    argv = tuple(goal if word == "GOAL" else word for word in COMMANDS[genes["command"]])
    if genes["direct"] and argv[0] == "plan":
        files["d/prompt/role.md"] = template
        argv += ("--strategy", "direct")
    return Case(files, argv)


# Genes and their least and most; what is not in a family's table has its usual value.
USUAL = {
    "command": choice(len(COMMANDS)),
    "spots": size(1, 400), "items": size(1, 400), "facts": size(0, 6),
    "negated": size(0, 100), "quantifier": choice(3), "kinds": choice(3), "junction": choice(4), "nested": choice(2),
    "actions": size(1, 60), "parameters": size(0, 9), "shown": choice(2), "action_depth": size(0, 8), "action_parts": size(1, 60),
    "effects": size(1, 40), "effect_depth": size(0, 6), "when_depth": size(0, 6), "when_parts": size(0, 30),
    "rules": size(0, 30), "rule_depth": size(0, 10), "rule_parts": size(1, 200), "holds": choice(4),
    "derivations": size(0, 30), "derive_depth": size(0, 6), "derive_parts": size(1, 60), "defaults": size(0, 20),
    "words": size(1, 60), "goal_parameters": size(0, 8), "goal_depth": size(0, 8), "goal_parts": size(1, 100),
    "offered_depth": size(0, 6), "lexicon": size(0, 60),
    "template": choice(len(TEMPLATES)), "loops": size(0, 9), "doublings": size(0, 200), "direct": choice(2),
    "goals": size(1, 60), "steps": size(0, 200),
}
PLAIN = dict(
    action_depth=size(0, 1), action_parts=size(1, 3), effects=size(1, 3), effect_depth=size(0, 1), when_depth=size(0, 0), when_parts=size(0, 1),
    rules=size(0, 1), rule_depth=size(0, 2), rule_parts=size(1, 3), derivations=size(0, 0), derive_depth=size(0, 0), derive_parts=size(1, 1),
    defaults=size(0, 0), words=size(1, 2), goal_parameters=size(0, 2), goal_depth=size(0, 1), goal_parts=size(1, 3), offered_depth=size(0, 0),
    lexicon=size(0, 0), template=choice(1), loops=size(0, 0), doublings=size(0, 0), actions=size(1, 4), parameters=size(0, 3), goals=size(1, 4),
)


def family(name, *varied):
    """A family in which only these genes go beyond what is plain."""
    table = {key: gene if key in varied or key not in PLAIN else PLAIN[key] for key, gene in USUAL.items()}
    return Family(name, table, domain_case)


def problem_case(genes, rng):
    conditions = Conditions(genes, rng)
    objects = [f"i{index}" for index in range(genes["items"])]
    facts = [f"(at {rng.choice(objects)} {rng.choice(objects)})" for _ in range(genes["items"] * genes["facts"])]
    goal = conditions.condition(objects[:3], genes["goal_depth"], genes["goal_parts"])
    problem = f"(define (problem p) (:domain d) (:objects {' '.join(objects)} - item)\n (:init {' '.join(facts)})\n (:goal {goal}))\n"
    return Case({"d.pddl": domain_pddl(genes, conditions, rng), "p.pddl": problem}, ("solve", "--problem", "p.pddl", "--domain", "d.pddl"))


FAMILIES = [
    family("domain", *USUAL),
    family("domain-rules", "rules", "rule_depth", "rule_parts"),
    family("domain-actions", "actions", "parameters", "action_depth", "action_parts"),
    family("domain-effects", "effects", "effect_depth", "when_depth", "when_parts"),
    family("domain-derivations", "derivations", "derive_depth", "derive_parts", "defaults"),
    family("domain-goals", "words", "goal_parameters", "goal_depth", "goal_parts", "offered_depth", "goals"),
    family("domain-names", "lexicon", "words"),
    Family("domain-templates", {**{k: PLAIN.get(k, g) for k, g in USUAL.items()}, "template": choice(len(TEMPLATES)), "loops": size(0, 5), "doublings": size(0, 200), "command": choice(len(COMMANDS))}, domain_case),
    Family("problem", USUAL, problem_case),
]
