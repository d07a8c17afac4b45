"""Lineages of a (1+1) evolution strategy, followed generation by generation."""

import numpy as np

from coevo_manager.core.episodes import evaluate_pairs
from coevo_manager.core.evaluation import Lineages
from neuro_controller.core.genome import GENES, random_genomes


def random_lineages(rng, species, environment, generations=6, opponents=3, count=1):
    """Return lineages whose parents have their true fitness; every fifth mutation is empty."""
    parents, others = random_genomes(count, rng), random_genomes(opponents, rng)
    redrawn = rng.integers(0, 5, (count, generations)).astype(np.uint32)
    genes = [rng.choice(GENES, changes, replace=False) for changes in redrawn.ravel()]
    values = rng.uniform(-5, 5, redrawn.sum()).astype(np.float32)
    ticks = [meet(species, parent, others, environment).sum() for parent in parents]
    genes = np.concatenate(genes).astype(np.uint32)
    return Lineages(species, parents, np.array(ticks, np.uint64), others, redrawn, genes, values)


def meet(species, genome, opponents, environment):
    """Return the capture ticks of one genome against all opponents."""
    ours, theirs = np.zeros(len(opponents), int), np.arange(len(opponents))
    if species == 'predator':
        return evaluate_pairs([genome], opponents, ours, theirs, environment)
    return evaluate_pairs(opponents, [genome], theirs, ours, environment)


def follow(lineages, environment, meet=meet):
    """Return the capture ticks of all generations, and how many offspring were accepted."""
    played, accepted, first = [], 0, 0
    for parent, parent_ticks, redrawn in zip(
        lineages.parents, lineages.parent_ticks.tolist(), lineages.redrawn.tolist(), strict=True
    ):
        parent, best = parent.copy(), parent_ticks
        for count in redrawn:
            offspring = parent.copy()
            for change in range(first, first + count):
                offspring[lineages.genes[change]] = lineages.values[change]
            first += count
            played.append(meet(lineages.species, offspring, lineages.opponents, environment))
            total = int(played[-1].sum())
            if total <= best if lineages.species == 'predator' else total >= best:
                parent, best = offspring, total
                accepted += 1
    return np.concatenate(played), accepted
