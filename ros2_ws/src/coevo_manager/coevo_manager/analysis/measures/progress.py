"""Did they make progress? One number a replication, and what may be claimed of it."""

import numpy as np
import pandas as pd

from coevo_manager.analysis.measures import beyond, statistics
from coevo_manager.analysis.measures import paper as measures
from coevo_manager.analysis.measures.paper import performance
from coevo_manager.core.species import PLURAL, SPECIES

KEYS = ('arena', 'condition', 'species', 'measure')


def halves(size: int) -> tuple[slice, slice]:
    """The first and the second half of S generations, generation 0 (random genomes) left out.

    Anything beats random genomes and is better than them: leaving them out keeps the take-off of
    the first generations from passing for lasting progress. Both halves are empty where S < 3.
    """
    middle = 1 + (size - 1) // 2
    return slice(1, middle), slice(middle, size if size > 2 else middle)


def historical_gain(own):
    """How the second half's agents do against the first half's opponents, and their own.

    Parameters
    ----------
    own : array_like (R, S, S), `measures.performance`

    Returns
    -------
    ancestors, contemporaries : ndarray (R,)
        Mean performance of the agents of the second half against the opponents of the first half,
        and against those of their own generation. NaN where S < 3.
    """
    own = np.asarray(own, float)
    early, late = halves(own.shape[-1])
    contemporaries = np.diagonal(own, axis1=-2, axis2=-1)[:, late]
    return _mean(own[:, late, early].reshape(len(own), -1)), _mean(contemporaries)


def global_gain(curve):
    """How the second half's agents and the first half's do against the same opponents.

    Parameters
    ----------
    curve : array_like (R, S)
        Performance of each generation against one fixed set of opponents.

    Returns
    -------
    late, early : ndarray (R,)
    """
    curve = np.asarray(curve, float)
    early, late = halves(curve.shape[-1])
    return _mean(curve[:, late]), _mean(curve[:, early])


def verdicts(study) -> pd.DataFrame:
    """Progress of each condition and species by each measure, one Holm family a condition.

    Returns
    -------
    pandas.DataFrame
        `arena`, `condition`, `species`, `measure` (historical: against ancestors rather than
        contemporaries; global: second half rather than first, against the opponents of all
        generations; held-out: the same against the elites of other runs), the columns of
        `compare_paired`, `cyclic_share` and `verdict`: see `verdict`.
    """
    return pd.concat([_condition_verdicts(each) for each in study.conditions], ignore_index=True)


def _condition_verdicts(each) -> pd.DataFrame:
    rows, first, second = [], [], []
    for species in SPECIES:
        own = performance(each.tournament, species)
        pairs = {
            'historical': historical_gain(own),
            'global': global_gain(own[:, :, 1:].mean(axis=2)),
        }
        held_out = each.held_out_mean(species)
        if held_out is not None:
            pairs['held-out'] = global_gain(held_out)
        for measure, (better, worse) in pairs.items():
            rows.append((each.condition.arena, each.condition.name, species, measure))
            first.append(better)
            second.append(worse)
    table = pd.DataFrame(rows, columns=['arena', 'condition', 'species', 'measure'])
    table = pd.concat([table, statistics.compare_paired(first, second)], axis=1)
    table['p_fall_holm'] = statistics.holm(1 - table['p_paired'].astype(float))
    table['cyclic_share'] = share = cyclic_share(each.tournament)
    table['verdict'] = [
        verdict(rise, fall, share)
        for rise, fall in zip(table['p_paired_holm'], table['p_fall_holm'], strict=True)
    ]
    return table


def cyclic_share(tournaments) -> float:
    """Mean over replications (R, S, S) of the cyclic share, generation 0 left out."""
    shares = [beyond.hodge(tournament[1:, 1:])[2] for tournament in np.asarray(tournaments)]
    return float(np.nanmean(shares)) if np.isfinite(shares).any() else np.nan


def verdict(rise: float, fall: float, share: float) -> str:
    """Say what may be claimed.

    Parameters
    ----------
    rise, fall : float
        Corrected one-tailed p-values for a gain and for a loss; NaN without replications.
    share : float
        Cyclic share of the tournament.

    Returns
    -------
    str
        'cannot be claimed' without replications, 'not significant', 'retrogression', 'progress',
        or 'cyclic': a gain where the tournament is more cyclic than transitive, so that it may be
        no more than the phase of a cycle in which the halves of the run happen to be.
    """
    if np.isnan(rise):
        return 'cannot be claimed'
    if rise < statistics.ALPHA:
        return 'cyclic' if share > 0.5 else 'progress'
    return 'retrogression' if fall < statistics.ALPHA else 'not significant'


def generation_tests(study) -> pd.DataFrame:
    """Test generations against each other, for Table 1, Table 2 and complexity (section 4).

    Returns
    -------
    pandas.DataFrame
        `arena`, `condition`, `species`, `measure` (historical, global or complexity) and the
        columns of `measures.historical_tests`; each such combination is one Holm family.
    """
    parts = []
    for each in study.conditions:
        for species in SPECIES:
            tests = {
                'historical': measures.historical_tests(
                    each.tournament, study.generations, species
                ),
                'global': measures.global_tests(each.tournament, study.generations, species),
                'complexity': measures.increase_tests(each.complexity[species], study.generations),
            }
            for measure, table in tests.items():
                keys = (each.condition.arena, each.condition.name, species, measure)
                for place, (name, key) in enumerate(zip(KEYS, keys, strict=True)):
                    table.insert(place, name, key)
                parts.append(table)
    return pd.concat(parts, ignore_index=True)


def durations(study, tests: pd.DataFrame) -> pd.DataFrame:
    """Duration and rate of progress and complexification of each condition and species.

    Parameters
    ----------
    tests : pandas.DataFrame
        `generation_tests`.

    Returns
    -------
    pandas.DataFrame
        `duration_paper` by the paper's uncorrected t-tests, `duration_paired` by paired t-tests
        with Holm's correction; for `measure` historical also `rate_per_1000`, the mean over
        replications of `measures.rate` up to the duration by the paper's tests (up to the last
        generation where there is none, which `rate_until` tells).
    """
    tournaments = {(c.condition.arena, c.condition.name): c.tournament for c in study.conditions}
    rows = []
    for keys, table in tests.groupby(list(KEYS), sort=False):
        row = dict(zip(KEYS, keys, strict=True))
        row['duration_paper'] = measures.duration(measures.most_recent(table))
        row['duration_paired'] = measures.duration(measures.most_recent(table, 'p_paired_holm'))
        if row['measure'] == 'historical':
            known = row['duration_paper'] > 0
            until = int(row['duration_paper'] if known else study.generations[-1])
            rates = measures.rate(tournaments[keys[:2]], study.generations, row['species'], until)
            row |= {'rate_per_1000': float(np.mean(rates)), 'rate_until': until}
        rows.append(row)
    return pd.DataFrame(rows)


def progress_table(tests: pd.DataFrame, arena: str, measure: str, column: str) -> pd.DataFrame:
    """Table 1 (historical) or 2 (global) of an environment, by one column of p-values."""
    part = tests[(tests['arena'] == arena) & (tests['measure'] == measure)]
    found = {
        f'{condition} {PLURAL[species]}': measures.most_recent(table, column)
        for (condition, species), table in part.groupby(['condition', 'species'], sort=False)
    }
    return pd.DataFrame(found).rename_axis('generation').reset_index().astype('Int64')


def _mean(values):
    return values.mean(axis=1) if values.shape[1] else np.full(len(values), np.nan)
