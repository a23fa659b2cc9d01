"""Comparison of the program's answers about planning tasks with their meaning."""

import collections
from dataclasses import dataclass, replace
from pathlib import Path
from random import Random

from .judge import Judge
from .task_drawer import Drawer
from .task_machine import OVER, UNSOLVABLE, Machine
from .tasks import Task

# Seconds for the answers to a batch; a search that gives up takes some of them.
PATIENCE = 240


@dataclass
class Found:
    """What came of comparing: a difference in words, or a case over the bound of one of the two."""

    difference: str | None = None
    over: bool = False
    solved: bool = False
    unsolvable: bool = False


def compare(task: Task, plans: list, answer: dict, faults: frozenset = frozenset()) -> Found:
    """Compares what the program answered with the meaning of the task."""
    if "crash" in answer:
        return Found(f"crash: {answer['crash']}")
    if "can hold in no state" in answer.get("error", ""):
        # A constraint that forbids nothing is refused.
        return Found(over=True)
    if "error" in answer:
        return Found(f"cannot be read: {answer['error']}")
    machine, flags = Machine(task, faults), answer["stages"]
    if flags and len(flags) != len(machine.conditions):
        return Found(f"goals: {len(flags)} there, {len(machine.conditions)} here")
    for plan, verdict in zip(plans, answer["verdicts"]):
        inapplicable, valid, cost = machine.replay(plan, flags)
        if (inapplicable, valid) != (verdict["inapplicable"], verdict["valid"]):
            return Found(f"verdict {verdict} on {plan}, here {inapplicable, valid}")
        if inapplicable is None and task.has_costs() and verdict["cost"] != str(cost):
            return Found(f"verdict {verdict} on {plan}, which costs {cost}")
    given_up = needlessly_given_up(machine, flags)
    if given_up is not None:
        return Found(given_up)
    best, outcome = machine.best(flags), answer["outcome"]
    if outcome == "solved":
        return compare_plan(task, machine, flags, answer, best)
    if best == OVER or outcome == "gave_up":
        return Found(over=True)
    if best != UNSOLVABLE:
        return Found(f"{outcome} there, {best} here")
    return Found(unsolvable=True)


def compare_plan(task: Task, machine: Machine, flags: list[dict], answer: dict, best) -> Found:
    """Compares a plan that the search found."""
    plan = answer["plan"]
    inapplicable, valid, cost = machine.replay(plan, flags)
    if not answer["valid"] or not valid:
        return Found(f"the plan is {'valid' if valid else f'invalid ({inapplicable})'} here and {answer['valid']} there: {plan}")
    if task.has_costs() and answer["cost"] != str(cost):
        return Found(f"the plan costs {cost}, not {answer['cost']}: {plan}")
    if best == UNSOLVABLE:
        return Found(f"solved, and there is no plan: {plan}")
    if best == OVER:
        return Found(over=True)
    if (cost, len(plan)) < best or answer["best"] and (cost, len(plan)) != best:
        return Found(f"the plan has {cost, len(plan)}, the best one {best}: {plan}")
    return Found(solved=True)


def needlessly_given_up(machine: Machine, flags: list[dict]) -> str | None:
    """An earlier goal that need not last although an alternative of it can hold together with each later goal."""
    stages = machine.progress(flags).stages
    given_up = [number for number, flag in enumerate(flags) if not flag["kept"]]
    states = machine.reachable() if given_up else None
    goals = [own for stage in machine.task.stages for goal in stage for own in goal.conditions]
    for number in given_up if states is not None else []:
        later = [machine.conditions[other] for stage in stages if stage.start > number for other in stage]
        for alternative in map(machine.condition, alternatives(goals[number])):
            together = [state for state in states if alternative(*state)]
            if all(any(other(*state) for state in together) for other in later):
                return f"goal {number} is given up, and each later goal can hold together with it"
    return None


def alternatives(condition: tuple) -> list[tuple]:
    """The conditions of which a goal requires one."""
    if condition[0] == "and" and len(condition) > 1 and condition[1][0] == "or":
        return alternatives(condition[1])
    return list(condition[1:]) if condition[0] == "or" else [condition]


# --- smaller tasks ------------------------------------------------------------------------------------------------


def smaller(task: Task) -> list[Task]:
    """Tasks with one part less."""
    found = []
    for place, action in enumerate(task.actions):
        others = task.actions[:place], task.actions[place + 1 :]
        found.append(replace(task, actions=others[0] + others[1]))
        lesser = [replace(action, effects=own) for own in less(action.effects) if own]
        lesser += [replace(action, condition=("and",))] if action.condition != ("and",) else []
        lesser += [replace(action, effects=(*action.effects[:at], inner, *action.effects[at + 1 :]))
                   for at, effect in enumerate(action.effects) if effect[0] == "and" for inner in effect[1:]]  # fmt: skip
        found += [replace(task, actions=(*others[0], own, *others[1])) for own in lesser]
    found += [replace(task, goal=("and", *own)) for own in less(task.goal[1:])] if not task.stages else []
    found += [replace(task, stages=own) for own in less(task.stages) if own]
    for place, stage in enumerate(task.stages):
        shorter = (own for own in less(stage) if own)
        found += [replace(task, stages=(*task.stages[:place], own, *task.stages[place + 1 :])) for own in shorter]
    found += [replace(task, constraints=own) for own in less(task.constraints)]
    found += [replace(task, facts=task.facts - {fact}) for fact in sorted(task.facts)]
    return found


def less(parts: tuple) -> list[tuple]:
    """The parts without one of them, in every way."""
    return [parts[:place] + parts[place + 1 :] for place in range(len(parts))]


def shrink(task: Task, plans: list, judge, difference: str, rounds: int = 80) -> tuple[Task, list, str]:
    """The smallest task found on which the two still differ."""
    for _ in range(rounds):
        candidates = smaller(task)
        names = lambda own: {action.name for action in own.actions}
        usable = lambda own: all(step[0] in names(own) for plan in plans for step in plan)
        trials = [(own, plans if usable(own) else []) for own in candidates]
        answers = judge.ask([own.request(steps) for own, steps in trials])
        for (own, steps), answer in zip(trials, answers):
            again = compare(own, steps, answer).difference
            if again is not None and not again.startswith(("cannot be read", "goals")):
                task, plans, difference = own, steps, again
                break
        else:
            break
    return task, plans, difference


def run(program: Path, seed: int, count: int, faults: frozenset = frozenset()) -> dict:
    """Draws tasks from a seed, has them solved, and compares; the counts and the disagreements."""
    judge, drawer = Judge(program, PATIENCE), Drawer(Random(seed))
    drawn = [drawer.task() for _ in range(count)]
    answers = judge.ask([task.request(plans) for task, plans in drawn])
    counts = collections.Counter(cases=len(drawn))
    disagreements = []
    for (task, plans), answer in zip(drawn, answers):
        found = compare(task, plans, answer, faults)
        counts.update(solved=found.solved, unsolvable=found.unsolvable, over=found.over)
        if found.difference is None:
            continue
        difference = found.difference
        if not faults:
            task, plans, difference = shrink(task, plans, judge, difference)
        disagreements.append({"difference": difference, "seed": seed, "request": task.request(plans)})
    return {"counts": counts, "disagreements": disagreements}
