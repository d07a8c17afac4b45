"""What game theory says of the tournaments, in tables and sentences, and the league."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from openskill.models import PlackettLuce

from coevo_manager.analysis.measures import games
from coevo_manager.analysis.study import ConditionResults, Study
from coevo_manager.core.species import PLURAL, SPECIES

LATE = 0.75
"""Share of the run after which a generation counts as late."""


def nash_averaging(study: Study) -> pd.DataFrame:
    """Probability and rating of each generation in the most even equilibrium, of each run."""
    rows = []
    for each, r, keys in _runs(study):
        found = games.nash_average(each.tournament[r])
        for species, probability, rating in (
            ('predator', found.predators, found.predator_ratings),
            ('prey', found.prey, found.prey_ratings),
        ):
            rows += [
                keys | {'species': species, 'generation': g, 'probability': p, 'rating': q}
                for g, p, q in zip(study.generations.tolist(), probability, rating, strict=True)
            ]
    return pd.DataFrame(rows)


def alpha_rank(study: Study) -> pd.DataFrame:
    """Share of time that evolution by alpha-rank spends with each generation, of each run."""
    rows = []
    for each, r, keys in _runs(study):
        share = games.alpha_rank(each.tournament[r])
        for species, shares in zip(SPECIES, (share.sum(axis=1), share.sum(axis=0)), strict=True):
            rows += [
                keys | {'species': species, 'generation': g, 'share_of_time': s}
                for g, s in zip(study.generations.tolist(), shares, strict=True)
            ]
    return pd.DataFrame(rows)


def meta_exploitability(study: Study) -> pd.DataFrame:
    """What the best other generations gain against each, both species added, of each run."""
    return pd.DataFrame(
        [
            keys | {'generation': generation, 'exploitability': value}
            for each, r, keys in _runs(study)
            for generation, value in zip(
                study.generations.tolist(), games.exploitability(each.tournament[r]), strict=True
            )
        ]
    )


def effective_diversity(study: Study) -> pd.DataFrame:
    """How much the generations of each run beat each other in turn."""
    return pd.DataFrame(
        [
            keys | {'effective_diversity': games.effective_diversity(each.tournament[r])}
            for each, r, keys in _runs(study)
        ]
    )


def league(study: Study) -> pd.DataFrame:
    """Ratings of the conditions of each arena, the best first.

    Every run plays every run of another condition, with the predators and the prey of its last
    generation: it wins if its predators do better against the other's prey than the other's
    against its own. The rating is Plackett and Luce's as OpenSkill updates it (Joshy 2024), match
    by match in the order of the seeds; `at_least` is three standard deviations below it.
    """
    rows = []
    for arena, members in study.arenas().items():
        if len(members) < 2:
            continue
        model = PlackettLuce()
        ratings = [model.rating() for _ in members]
        results = np.zeros((len(members), 3), int)
        for a, b, margin in _matches(members, study):
            ranks = [int(margin < 0), int(margin > 0)]
            [[ratings[a]], [ratings[b]]] = model.rate(
                [[ratings[a]], [ratings[b]]],
                ranks=ranks,  # type: ignore[arg-type]
            )
            results[a, [1, 0, 2][int(np.sign(margin))]] += 1
            results[b, [1, 2, 0][int(np.sign(margin))]] += 1
        rows += [
            {
                'arena': arena,
                'condition': each.condition.name,
                'rating': rating.mu,
                'deviation': rating.sigma,
                'at_least': rating.ordinal(),
                'won': won,
                'drawn': drawn,
                'lost': lost,
            }
            for each, rating, (won, drawn, lost) in zip(
                members, ratings, results.tolist(), strict=True
            )
        ]
    table = pd.DataFrame(rows)
    if len(table):
        table = table.sort_values(['arena', 'rating'], ascending=[True, False], kind='stable')
    return table


def _matches(members: list[ConditionResults], study: Study) -> list[tuple[int, int, float]]:
    """Numbers of two conditions and by how much a run of the first beats one of the second."""
    return [
        (a, b, study.cross[one.folder, other.folder] - study.cross[other.folder, one.folder])
        for i in range(max(len(each.runs) for each in members))
        for j in range(max(len(each.runs) for each in members))
        for a, each in enumerate(members)
        for b, others in enumerate(members)
        if a < b
        for one in each.runs[i : i + 1]
        for other in others.runs[j : j + 1]
    ]


def sentences(tables: Mapping[str, pd.DataFrame], arena: str, condition: str) -> str:
    """Say what each measure found of a condition, in a sentence each.

    Parameters
    ----------
    tables : mapping
        The tables of this module by name.
    """
    own = {
        name: table[(table['arena'] == arena) & (table['condition'] == condition)]
        for name, table in tables.items()
    }
    replications = own['effective_diversity']['seed'].nunique()
    generations = own['nash_averaging']['generation']
    late = generations.max() * LATE

    def share(name: str, column: str) -> str:
        table = own[name][own[name]['generation'] >= late]
        return ', '.join(
            f'{PLURAL[species]} {part.sum() / replications:.2f}'
            for species, part in table.groupby('species', sort=False)[column]
        )

    exploitability = own['meta_exploitability']
    last = exploitability[exploitability['generation'] == generations.max()]
    diversity = own['effective_diversity']['effective_diversity'].mean()
    return (
        f'Nash averaging puts weight on the last quarter of the run: '
        f'{share("nash_averaging", "probability")}. '
        f'Alpha-rank spends this share of time there: {share("alpha_rank", "share_of_time")}. '
        f'Against the last generation the best others gain '
        f'{last["exploitability"].mean():.2f} together. '
        f'The effective diversity is {diversity:.3f}.'
    )


def _runs(study: Study) -> list[tuple[ConditionResults, int, dict[str, Any]]]:
    return [
        (
            each,
            r,
            {'arena': each.condition.arena, 'condition': each.condition.name, 'seed': run.seed},
        )
        for each in study.conditions
        for r, run in enumerate(each.runs)
    ]
