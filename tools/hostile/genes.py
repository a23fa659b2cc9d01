"""Families of inputs: a build function over a few numbers (genes), which a search varies, crosses and shrinks."""

import random
from dataclasses import dataclass

# No file and no argument of a case is larger, in bytes.
LARGEST = 20_000


@dataclass(frozen=True)
class Gene:
    """A number from `low` to `high`. A size is varied by factors, a choice is drawn anew."""

    low: int
    high: int
    is_choice: bool = False

    def draw(self, rng):
        if self.is_choice:
            return rng.randint(self.low, self.high)
        # Each order of magnitude is as likely as the others, and the ends are worth a look.
        if rng.random() < 0.1:
            return rng.choice((self.low, self.high))
        top = self.high - self.low + 1
        return self.low + min(self.high - self.low, int(top ** rng.random()) - 1 + (top > 1 and rng.random() < 0.3))

    def vary(self, value, rng):
        if self.is_choice or rng.random() < 0.15:
            return self.draw(rng)
        step = rng.choice((value * 2, value // 2, value + 1, value - 1, value * 5 // 4, value * 3 // 4))
        return max(self.low, min(self.high, step))


def size(low, high):
    return Gene(low, high)


def choice(count):
    return Gene(0, count - 1, True)


class Family:
    """A name, genes, and `build(genes, rng)`, which returns a case. The same genes give the same case."""

    def __init__(self, name, genes, build):
        self.name = name
        self.genes = {**genes, "seed": Gene(0, 1 << 30, True)}
        self.build_case = build

    def build(self, genome):
        return self.build_case(genome, random.Random(genome["seed"]))

    def draw(self, rng):
        return self.fitted({name: gene.draw(rng) for name, gene in self.genes.items()}, rng)

    def vary(self, genome, rng):
        varied = dict(genome)
        for name in rng.sample(list(self.genes), min(len(self.genes), rng.choice((1, 1, 2, 3)))):
            varied[name] = self.genes[name].vary(varied[name], rng)
        return self.fitted(varied, rng)

    def cross(self, one, other, rng):
        return self.fitted({name: rng.choice((one, other))[name] for name in self.genes}, rng)

    def fitted(self, genome, rng):
        """The genome with sizes halved until every file is small enough; none if that takes too long."""
        sizes = [name for name, gene in self.genes.items() if not gene.is_choice]
        for _ in range(60):
            if self.build(genome).largest() <= LARGEST:
                return genome
            large = [name for name in sizes if genome[name] > self.genes[name].low]
            if not large:
                return None
            # Mostly the largest of three, since the others may be what makes the case expensive.
            name = max(rng.sample(large, min(3, len(large))), key=genome.get)
            genome = {**genome, name: max(self.genes[name].low, genome[name] * 3 // 4 if genome[name] < 8 else genome[name] // 2)}
        return None

    def smaller(self, genome):
        """Genomes that are simpler than this one in one gene, the simplest first."""
        for name, gene in self.genes.items():
            value = genome[name]
            steps = () if gene.is_choice else (gene.low, gene.low + (value - gene.low) // 2, value - max(1, value // 8))
            for step in dict.fromkeys(steps):
                if gene.low <= step < value:
                    yield {**genome, name: step}
