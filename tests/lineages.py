"""Lineages of a (1+1) evolution strategy, followed generation by generation."""

import numpy as np

from coevo_manager.core.episodes import evaluate_pairs
from coevo_manager.core.evaluation import Lineage
from neuro_controller.core.genome import GENES, random_genomes


def random_lineage(rng, species, environment, generations=6, opponents=3):
    """Return a lineage whose parent has its true fitness; about every fifth mutation is empty."""
    parent, others = random_genomes(1, rng), random_genomes(opponents, rng)
    redrawn = rng.integers(0, 5, generations).astype(np.uint32)
    genes = [rng.choice(GENES, count, replace=False) for count in redrawn]
    values = rng.uniform(-5, 5, redrawn.sum()).astype(np.float32)
    ticks = int(meet(species, parent[0], others, environment).sum())
    genes = np.concatenate(genes).astype(np.uint32)
    return Lineage(species, parent[0], ticks, others, redrawn, genes, values)


def meet(species, genome, opponents, environment):
    """Return the capture ticks of one genome against all opponents."""
    ours, theirs = np.zeros(len(opponents), int), np.arange(len(opponents))
    if species == 'predator':
        return evaluate_pairs([genome], opponents, ours, theirs, environment)
    return evaluate_pairs(opponents, [genome], theirs, ours, environment)


def follow(lineage, environment, meet=meet):
    """Return the capture ticks of all generations, and how many offspring were accepted."""
    parent, best = lineage.parent.copy(), lineage.parent_ticks
    played, accepted, first = [], 0, 0
    for count in lineage.redrawn.tolist():
        offspring = parent.copy()
        for change in range(first, first + count):
            offspring[lineage.genes[change]] = lineage.values[change]
        first += count
        played.append(meet(lineage.species, offspring, lineage.opponents, environment))
        total = int(played[-1].sum())
        if total <= best if lineage.species == 'predator' else total >= best:
            parent, best = offspring, total
            accepted += 1
    return np.concatenate(played), accepted
