"""Progress in tables: verdicts on the gain of the second half, and the tests of Tables 1 and 2."""

from __future__ import annotations

import numpy as np
import pandas as pd

from coevo_manager.analysis.measures import paper as measures
from coevo_manager.analysis.measures import statistics
from coevo_manager.analysis.measures.paper import performance
from coevo_manager.analysis.measures.progress import (
    cyclic_share,
    global_gain,
    historical_gain,
    verdict,
)
from coevo_manager.analysis.study import ConditionResults, Study
from coevo_manager.core.species import PLURAL, SPECIES

KEYS = ('arena', 'condition', 'species', 'measure')


def verdicts(study: Study) -> pd.DataFrame:
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


def _condition_verdicts(each: ConditionResults) -> pd.DataFrame:
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
    falls = statistics.compare_paired(second, first)['p_paired'].astype(float)
    table['p_fall_holm'] = statistics.holm(falls)
    table['cyclic_share'] = share = cyclic_share(each.tournament)
    gains = np.subtract(first, second)
    changed = np.array([not (np.abs(gain) < 1e-12).all() for gain in gains])  # means round
    table['verdict'] = [
        verdict(rise, fall, share, bool(any_change))
        for rise, fall, any_change in zip(
            table['p_paired_holm'], table['p_fall_holm'], changed, strict=True
        )
    ]
    return table


def generation_tests(study: Study) -> pd.DataFrame:
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


def durations(study: Study, tests: pd.DataFrame) -> pd.DataFrame:
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
