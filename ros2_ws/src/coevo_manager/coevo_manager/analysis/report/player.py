"""Episodes between generations of a run, for the report's episode player."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from coevo_manager.analysis.play.kernel import Kernel
from coevo_manager.analysis.report.packing import constants, pack
from coevo_manager.analysis.study import Advance, ConditionResults
from coevo_manager.core.species import SPECIES

GENERATIONS = 4
RANKS = ('best', 'median')
EPISODES = 200
"""At most, in all conditions together, for individuals of both ranks: some 2 MB of the page."""


def ranks(conditions: Sequence[ConditionResults]) -> tuple[str, ...]:
    """Return who is shown of each generation: the best alone where there are many conditions."""
    return RANKS if sum(size(each, RANKS) for each in conditions) <= EPISODES else RANKS[:1]


def grid(
    each: ConditionResults, shown: Sequence[str], kernel: Kernel, advance: Advance
) -> dict[str, Any]:
    """Record episodes between individuals of a few generations of the first replication.

    Parameters
    ----------
    shown : sequence of str
        Who is shown of each generation, see `ranks`.

    Returns
    -------
    dict
        Ready for JSON: `generations`, `ranks`, the `constants` that drawing needs, and packed
        `episodes` by "predator generation/rank/prey generation/rank" (indices).
    """
    run, snapshots = each.runs[0], each.snapshots[0]
    count = min(GENERATIONS, len(snapshots))
    chosen = [snapshots[k] for k in np.linspace(0, len(snapshots) - 1, count).round().astype(int)]
    agents = {
        species: [
            (g, rank, snapshot.population(species)[snapshot.ranking(species)[place]])
            for g, snapshot in enumerate(chosen)
            for rank, place in enumerate((0, run.configuration.population // 2)[: len(shown)])
        ]
        for species in SPECIES
    }
    predators, prey = (np.array([genome for *_, genome in agents[s]]) for s in SPECIES)
    rows, columns = np.indices((len(predators), len(prey))).reshape(2, -1)
    traces = kernel.traces(predators, prey, rows, columns, run.environment)
    episodes = {}
    for i, j, trace in zip(rows, columns, traces, strict=True):
        name = '{}/{}/{}/{}'.format(*agents['predator'][i][:2], *agents['prey'][j][:2])
        episodes[name] = pack(trace)
        advance(1)
    return {
        'title': f'{each.condition.name}, {each.condition.arena}, seed {run.seed}',
        'generations': [snapshot.generation for snapshot in chosen],
        'ranks': list(shown),
        **constants(run.environment),
        'episodes': episodes,
    }


def size(each: ConditionResults, shown: Sequence[str]) -> int:
    """Number of episodes in a condition's grid."""
    return (min(GENERATIONS, len(each.snapshots[0])) * len(shown)) ** 2
