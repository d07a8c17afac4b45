"""Did they make progress? One number a replication, and what may be claimed of it."""

import numpy as np
import pandas as pd

from coevo_manager.analysis import measures, statistics
from coevo_manager.analysis.measures import SPECIES, performance

MEASURES = ('historical', 'global', 'held-out')


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
        contemporaries; global: second half rather than first against the last generation's
        opponents; held-out: the same against the elites of other runs), the columns of
        `compare_paired`, and `verdict`: progress, retrogression, not significant, or cannot be
        claimed.
    """
    rows, first, second = [], [], []
    for each in study.conditions:
        for species in SPECIES:
            own = performance(each.tournament, species)
            pairs = {
                'historical': historical_gain(own),
                'global': global_gain(own[:, :, -1]),
            }
            held_out = each.held_out_mean(species)
            if held_out is not None:
                pairs['held-out'] = global_gain(held_out)
            for measure, (better, worse) in pairs.items():
                rows.append((each.condition.arena, each.condition.name, species, measure))
                first.append(better)
                second.append(worse)
    table = pd.DataFrame(rows, columns=['arena', 'condition', 'species', 'measure'])
    tests = pd.concat(
        [statistics.compare_paired(*pair) for pair in zip(first, second, strict=True)],
        ignore_index=True,
    )
    falls = [
        statistics.compare_paired(*pair)['p_paired'].iloc[0]
        for pair in zip(second, first, strict=True)
    ]
    table = pd.concat([table, tests.assign(p_fall=falls)], axis=1)
    families = table.groupby(['arena', 'condition'])
    for column in ('p_paired', 'p_sign_flip', 'p_fall'):
        table[f'{column}_holm'] = families[column].transform(statistics.holm)
    table['verdict'] = [
        _verdict(rise, fall)
        for rise, fall in zip(table['p_paired_holm'], table['p_fall_holm'], strict=True)
    ]
    return table


def _verdict(rise: float, fall: float) -> str:
    if np.isnan(rise):
        return 'cannot be claimed'
    if rise < statistics.ALPHA:
        return 'progress'
    return 'retrogression' if fall < statistics.ALPHA else 'not significant'


def durations(study) -> pd.DataFrame:
    """Duration and rate of progress and complexification of each condition and species.

    Returns
    -------
    pandas.DataFrame
        `duration_paper` by the paper's uncorrected t-tests, `duration_paired` by paired t-tests
        with Holm's correction over the table; for `measure` historical also `rate_per_1000`, the
        mean over replications of `measures.rate` up to the duration by the paper's tests (up to
        the last generation where there is none, which `rate_until` tells).
    """
    rows = []
    for each in study.conditions:
        for species in SPECIES:
            for measure, tests in condition_tests(study, each, species).items():
                row = {
                    'arena': each.condition.arena,
                    'condition': each.condition.name,
                    'species': species,
                    'measure': measure,
                    'duration_paper': measures.duration(measures.most_recent(tests)),
                    'duration_paired': measures.duration(
                        measures.most_recent(tests, 'p_paired_holm')
                    ),
                }
                if measure == 'historical':
                    known = row['duration_paper'] > 0
                    until = row['duration_paper'] if known else study.generations[-1]
                    rates = measures.rate(each.tournament, study.generations, species, until)
                    row['rate_per_1000'] = float(np.mean(rates))
                    row['rate_until'] = int(until)
                rows.append(row)
    return pd.DataFrame(rows)


def condition_tests(study, each, species: str) -> dict[str, pd.DataFrame]:
    """Test generations against each other, for Table 1, Table 2 and complexity (section 4)."""
    return {
        'historical': measures.historical_tests(each.tournament, study.generations, species),
        'global': measures.global_tests(each.tournament, study.generations, species),
        'complexity': measures.increase_tests(each.complexity[species], study.generations),
    }


def _mean(values):
    return values.mean(axis=1) if values.shape[1] else np.full(len(values), np.nan)
