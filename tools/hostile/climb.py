"""A search for expensive inputs: each family keeps its costliest genomes, varies and crosses them, and starts anew."""

import random

# Genomes that a family keeps, runs without an improvement before it starts anew, findings of a family that are kept.
POPULATION = 10
PATIENCE = 120
FINDINGS = 6


class Climber:
    """The search within one family."""

    def __init__(self, family, limits, rng):
        self.family, self.limits = family, limits
        self.rng = random.Random(rng.random())
        self.population = []
        self.idle = self.runs = self.restarts = 0
        # Processor time that the family has had, to find what is over a limit and to make it smaller.
        self.spent = 0.0
        self.worst_seconds = self.worst_mebibytes = 0.0
        self.worst_genomes = {}
        self.over = []

    def next(self):
        """The genome to try next; none where nothing small enough was found."""
        rng = self.rng
        if len(self.population) < POPULATION // 2 or rng.random() < 0.15:
            return self.family.draw(rng)
        parent = self.chosen()
        if rng.random() < 0.25:
            parent = self.family.cross(parent, self.chosen(), rng) or parent
        return self.family.vary(parent, rng)

    def chosen(self):
        return max(self.rng.sample(self.population, min(3, len(self.population))), key=lambda entry: entry[0])[1]

    def score(self, cost):
        return max(cost.seconds / self.limits.seconds, cost.mebibytes / self.limits.mebibytes)

    def take(self, genome, cost):
        """Keeps a genome that costs more than the least of those that are kept."""
        self.runs += 1
        # Each run costs a few milliseconds besides.
        self.spent += cost.seconds + 0.01
        score = self.score(cost)
        for worst, value in (("seconds", cost.seconds), ("mebibytes", cost.mebibytes)):
            if value > getattr(self, f"worst_{worst}"):
                setattr(self, f"worst_{worst}", value)
                self.worst_genomes[worst] = genome
        best = max((kept for kept, _ in self.population), default=0.0)
        self.population.append((score, genome))
        self.population.sort(key=lambda entry: -entry[0])
        del self.population[POPULATION:]
        # A little more is noise.
        self.idle = 0 if score > best * 1.02 else self.idle + 1
        if self.idle >= PATIENCE:
            self.population, self.idle = [], 0
            self.restarts += 1

    def weight(self):
        """Its share of the time: less once enough is known against it."""
        return 0.2 if len(self.over) >= FINDINGS else 0.5 if self.over else 1.0


def minimised(family, genome, still_over, tries):
    """The genome with every gene as small as it can be while it stays over a limit."""
    changed = True
    while changed and tries > 0:
        changed = False
        for smaller in family.smaller(genome):
            if tries <= 0:
                break
            tries -= 1
            if still_over(smaller):
                genome, changed = smaller, True
                break
    return genome
