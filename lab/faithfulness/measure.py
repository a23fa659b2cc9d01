#!/usr/bin/env python3
"""Measures how many verified plans do not do what the instruction says.

  lab/faithfulness/measure.py run --program target/release/longstep --work /tmp/faithfulness --out answers.jsonl
  lab/faithfulness/measure.py judge answers.jsonl
  lab/faithfulness/measure.py table answers.jsonl

`run` gives every instruction of instructions.toml (or of `--instructions FILE`, for all three commands) to `longstep plan`
and keeps its answers, one a line; an interrupted
run goes on where it stopped. The model is loaded once for each domain: `longstep eval` records its replies, and
`longstep plan` replays them. `table` counts. What the checks of instructions.toml do not decide is in judgements.json, by a
hash of instruction and plan; `judge` lists the plans without a judgement, and fails if there are any. Only new plans need
a new judgement.
"""

import argparse
import collections
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tomllib

HERE = os.path.dirname(os.path.abspath(__file__))
EXAMPLES = os.path.join(HERE, "..", "..", "examples")
JUDGEMENTS = os.path.join(HERE, "judgements.json")
KEPT = ("goal", "steps", "notes", "violations", "not_represented", "coverage", "assumptions")
STATUSES = {0: "verified", 11: "refused", 12: "gave up", 13: "question"}


def instructions(options):
    with open(options.instructions, "rb") as file:
        return tomllib.load(file)["instruction"]


def places(entry, examples):
    """The arguments for domain and environment."""
    domain, env = entry["domain"], entry["env"]
    if domain != "household":
        folder = os.path.join(examples, domain)
        return ["--domain", folder, "--env", os.path.join(folder, "suite", "scenes", env + ".json")]
    own = os.path.join(HERE, env + ".json")
    return ["--env", own if os.path.exists(own) else os.path.join(examples, "environments", env + ".json")]


def suite(domain, entries, folder, examples):
    """Writes a suite of the instructions of a domain, so that one process answers all of them."""
    os.makedirs(os.path.join(folder, "scenes"), exist_ok=True)
    home = domain if domain == "household" else os.path.abspath(os.path.join(examples, domain))
    with open(os.path.join(folder, "suite.toml"), "w", encoding="utf-8") as file:
        file.write(f"name = {json.dumps(domain)}\nabout = 'Instructions of any kind.'\ndomain = {json.dumps(home)}\n")
    with open(os.path.join(folder, "cases.toml"), "w", encoding="utf-8") as file:
        for entry in entries:
            # The judge of a suite is not used here.
            says = json.dumps(entry["says"], ensure_ascii=False)
            file.write(f"[[case]]\nid = '{entry['id']}'\nscene = '{entry['env']}'\nsays = {says}\nexpect = 'question'\n")
            shutil.copy(places(entry, examples)[-1], os.path.join(folder, "scenes", entry["env"] + ".json"))


def run(options):
    os.makedirs(options.work, exist_ok=True)
    model = ["--model", options.model] if options.model else []
    model += ["--threads", str(options.threads)] if options.threads else []
    by_domain = collections.defaultdict(list)
    for entry in instructions(options):
        by_domain[entry["domain"]].append(entry)
    done = {answer["id"] for answer in read(options.out)} if os.path.exists(options.out) else set()
    with open(options.out, "a", encoding="utf-8") as out:
        for domain, entries in by_domain.items():
            if all(entry["id"] in done for entry in entries):
                continue
            folder, record = os.path.join(options.work, domain), os.path.join(options.work, domain + ".jsonl")
            suite(domain, entries, folder, options.examples)
            command = [options.program, "eval", folder, "--out", folder + "-run", "--record", record, *model]
            subprocess.run(command, stdout=subprocess.DEVNULL, check=False)
            for entry in entries:
                if entry["id"] not in done:
                    out.write(json.dumps(ask(options, entry, record, model), ensure_ascii=False) + "\n")
                    out.flush()


def ask(options, entry, record, model):
    """The program's answer: from the recorded replies, or from the model where `plan` asks it for something else."""
    command = [options.program, "plan", entry["says"], "--json", *places(entry, options.examples)]
    for source in (["--model", "replay:" + record], model):
        ended = subprocess.run([*command, *source], capture_output=True, text=True, timeout=1800, check=False)
        if ended.returncode != 40:
            break
    try:
        answer = json.loads(ended.stdout)
    except json.JSONDecodeError:
        answer = {}
    kept = {
        "id": entry["id"],
        "says": entry["says"],
        "status": STATUSES.get(ended.returncode, "error"),
        "code": ended.returncode,
        "answer": {key: answer.get(key) for key in KEPT},
        "plan": answer.get("plan"),
        "stderr": ended.stderr[-2000:],
    }
    print(entry["id"], kept["status"], " & ".join(kept["answer"]["goal"] or []) or question(kept), flush=True)
    return kept


def read(path):
    with open(path, encoding="utf-8") as file:
        return [json.loads(line) for line in file if line.strip()]


def question(answer):
    return ((answer["plan"] or {}).get("question") or answer["stderr"]).strip()


def steps(answer):
    """The steps as calls with all their arguments, hidden ones by name."""
    lines = []
    for step in answer["answer"]["steps"] or []:
        arguments = [str(argument) for argument in step["arguments"]]
        arguments += [f"{name}={value}" for name, value in step["implicit"].items()]
        lines.append(f"{step['action']}({', '.join(arguments)})")
    return lines


def key(entry, answer):
    """The hash of an instruction and the plan for it, with the parts that the answer declares as left out."""
    content = [entry["domain"], entry["env"], entry["says"], answer["answer"]["goal"], steps(answer), gap(answer), (answer["plan"] or {}).get("task_cohesion")]
    return hashlib.sha256(json.dumps(content, ensure_ascii=False).encode()).hexdigest()[:16]


def gap(answer):
    """The parts of the instruction that the answer itself declares as not represented."""
    return answer["answer"].get("not_represented") or []


def facts(answer):
    """The states of the environment after a plan without branches."""
    after = (answer["plan"] or {}).get("environment_after")
    if not isinstance(after, dict):
        return None
    after = after.get("environment", after)
    found = set()
    for states in (after.get("asset_states") or {}, after.get("object_states") or {}):
        for entity, words in states.items():
            found |= {f"{entity} {word}" for word in ([words] if isinstance(words, str) else words)}
    return found


def fault(entry, answer):
    """The check of the instruction that the plan fails, or None."""
    if entry["expect"] == "ask":
        return "a plan where only a question or a refusal is right"
    lines, after = steps(answer), facts(answer)
    # The notation of a quantity is the domain's, which may change: that is for a person to look at.
    position = 0
    for pattern in entry.get("steps", []):
        matches = [index for index, line in enumerate(lines) if index >= position and re.search(pattern, line)]
        if not matches and not {"quantity", "text"} & set(entry["kind"]):
            return f"no step {pattern} in its place"
        position = matches[0] + 1 if matches else position
    for pattern in entry.get("no_step", []):
        for line in lines:
            if re.search(pattern, line):
                return f"has {line}"
    if after is None:
        return None
    for fact in entry.get("ends", []):
        if fact not in after:
            return f"ends without {fact}"
    for fact in entry.get("ends_not", []):
        if fact in after:
            return f"ends with {fact}"
    return None


def judged(options):
    """Each instruction with its answer and verdict: right, wrong or None, and the reason."""
    with open(JUDGEMENTS, encoding="utf-8") as file:
        judgements = json.load(file)
    answers = {answer["id"]: answer for answer in read(options.answers)}
    for entry in instructions(options):
        answer = answers.get(entry["id"])
        if answer is None:
            continue
        if answer["status"] != "verified":
            right = entry["expect"] in ("ask", "either") and answer["status"] in ("question", "refused", "gave up")
            yield entry, answer, "right" if right else "no plan", ""
            continue
        own = judgements.get(key(entry, answer))
        reason = fault(entry, answer)
        if own is not None:
            yield entry, answer, own["verdict"], own["why"]
        elif reason is not None and not gap(answer):
            yield entry, answer, "wrong", reason
        else:
            yield entry, answer, None, ""


def judge(options):
    missing = 0
    for entry, answer, verdict, _ in judged(options):
        if verdict is None:
            missing += 1
            print(f"\n{key(entry, answer)}  {entry['id']} {entry['says']}\n  meaning: {entry['meaning']}")
            print("  goal:    ", answer["answer"]["goal"])
            if gap(answer):
                print("  left out:", json.dumps(gap(answer), ensure_ascii=False))
            for line in steps(answer):
                print("   ", line)
            if facts(answer) is None:
                print("  branches:", json.dumps((answer["plan"] or {}).get("task_cohesion"), ensure_ascii=False))
    print(f"\n{missing} plans without a judgement")
    return 1 if missing else 0


def table(options):
    rows, wrong = collections.Counter(), []
    for entry, answer, verdict, reason in judged(options):
        status = "verified with a gap" if answer["status"] == "verified" and gap(answer) else answer["status"]
        rows[entry["domain"], status, verdict] += 1
        if answer["status"] == "verified" and verdict == "wrong":
            wrong.append((entry, answer, reason))
        if options.all:
            print(f"{entry['id']}  {answer['status']:9} {verdict}  {entry['says']}  {answer['answer']['goal'] or question(answer)}  {reason}")
    kinds = ["laboratory", "warehouse", "care", "home", "workshop", "household"]
    print("| domain | verified, does it | verified, does not | question, right | question, needless | refused or gave up, right | not right | error |")
    print("|---|---|---|---|---|---|---|---|")

    def total(domains, statuses, verdicts):
        return sum(count for (domain, status, verdict), count in rows.items() if domain in domains and status in statuses and verdict in verdicts)

    plans = ("verified", "verified with a gap")
    stopped = ("refused", "gave up")
    for name, domains in [*((kind, [kind]) for kind in kinds), ("all", kinds)]:
        cells = [
            total(domains, plans, ["right"]), total(domains, plans, ["wrong"]),
            total(domains, ["question"], ["right"]), total(domains, ["question"], ["no plan"]),
            total(domains, stopped, ["right"]), total(domains, stopped, ["no plan"]), total(domains, ["error"], ["right", "no plan"]),
        ]
        print(f"| {name} | " + " | ".join(map(str, cells)) + " |")
    verified = total(kinds, plans, ["right", "wrong", None])
    unjudged = total(kinds, plans, [None])
    print(f"\n{len(wrong)} of {verified} verified plans do not do what was said ({100 * len(wrong) / max(verified, 1):.0f} %); {unjudged} without a judgement")
    for entry, answer, reason in wrong:
        print(f"- {entry['id']} \"{entry['says']}\": {' & '.join(answer['answer']['goal'] or [])}: {reason}")
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    command = commands.add_parser("run", help="give the instructions to the program")
    command.add_argument("--program", required=True)
    command.add_argument("--out", required=True)
    command.add_argument("--work", required=True, help="folder for suites and recordings; a second run goes on from it")
    command.add_argument("--model")
    command.add_argument("--threads", type=int)
    command.add_argument("--examples", default=EXAMPLES)
    command.set_defaults(do=run)
    for name, do in (("judge", judge), ("table", table)):
        command = commands.add_parser(name)
        command.add_argument("answers")
        command.add_argument("--all", action="store_true")
        command.set_defaults(do=do)
    for command in commands.choices.values():
        command.add_argument("--instructions", default=os.path.join(HERE, "instructions.toml"))
    options = parser.parse_args()
    return options.do(options)


if __name__ == "__main__":
    sys.exit(main())
