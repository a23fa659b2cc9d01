"""Random tasks as PDDL files."""

from dataclasses import dataclass
from pathlib import Path
from random import Random

from coverage import ground, worlds
from simulate import pddl

HERE = Path(__file__).parent
ROOT = HERE.parents[2]
# Steps of a random walk; a walk on a grid wanders.
WALK, WANDERING = (5, 60), (60, 600)


@dataclass
class Task:
    """A task that has a plan."""

    name: str
    domain: Path
    problem: Path


def domain_file(name: str) -> Path:
    """The domain as PDDL."""
    return ROOT / "crates/longstep-model/domains/household/domain.pddl" if name == "household" else HERE / f"domains/{name}.pddl"


def written(fact: tuple[str, ...]) -> str:
    """A fact as PDDL."""
    return f"({' '.join(fact)})"


def domain_of(number: int) -> str:
    """The domain of a task; the domains take turns."""
    return worlds.DOMAINS[number % len(worlds.DOMAINS)].__name__


def write(folder: Path, seed: int, number: int, attempt: int) -> Task:
    """Writes a task; each attempt is another one of the same domain."""
    make, kind = worlds.DOMAINS[number % len(worlds.DOMAINS)], domain_of(number)
    random = Random(f"{seed}/{number}/{attempt}")
    file = domain_file(kind)
    domain = pddl.parse_domain(file.read_text())
    goal: list[str] = []
    while not goal:
        start = make(random)
        if start.goal and random.random() < 0.5:
            goal = [written(fact) for fact in start.goal if fact not in start.facts]
        else:
            goal = walked(ground.World(domain, start.objects, set(start.facts)), kind, random)
    lines = [f"(define (problem {kind}-{number})", f"  (:domain {domain.name})", "  (:objects"]
    lines += [f"    {' '.join(names)} - {type_name}" for type_name, names in start.objects.items()]
    lines += ["  )", "  (:init", *(f"    {written(fact)}" for fact in start.facts), "  )"]
    lines += ["  (:goal (and", *(f"    {part}" for part in goal), "  )))", ""]
    problem = folder / f"{number:03}-{kind}.pddl"
    problem.write_text("\n".join(lines))
    return Task(problem.stem, file, problem)


def walked(world: ground.World, kind: str, random: Random) -> list[str]:
    """Facts, or a random part of them, that are as a random walk left them and not as at the start."""
    length = random.randint(*(WANDERING if kind in ("keys", "pushing") else WALK))
    end, start = ground.walk(world, length, random), world.facts
    changes = [written(fact) for fact in sorted(end - start)]
    # Only a domain with negative preconditions has negative goals.
    if kind in ("lab", "household"):
        changes += [f"(not {written(fact)})" for fact in sorted(start - end)]
    share = random.choice([0.3, 0.6, 1.0])
    return [change for change in changes if random.random() < share]
