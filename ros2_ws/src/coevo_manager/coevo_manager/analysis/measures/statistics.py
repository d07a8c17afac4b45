"""Tests over replications: the paper's one-tailed t-test beside better ones, each labelled.

The replication (one seeded run) is the unit everywhere: individuals and generations of one run are
not independent. All p-values are one-tailed for "the first is larger" unless a name says
otherwise.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy import stats
from statsmodels.stats.power import TTestPower

ALPHA = 0.05
RESAMPLES = 2000
TEST_COLUMNS = (
    'replications',
    'mean_first',
    'mean_second',
    'difference',
    'bootstrap_low',
    'bootstrap_high',
    'hedges_g',
    'p_paper',
    'p_paired',
    'p_welch',
    'p_sign_flip',
    'p_paired_holm',
    'p_sign_flip_holm',
)


def holm(p: ArrayLike) -> np.ndarray:
    """Correct a family of p-values by Holm's step-down method; NaN entries stay out of it.

    Equal to statsmodels' `multipletests`, which collects garbage at each call (0.2 s).
    """
    p = np.asarray(p, float)
    corrected = np.full(p.shape, np.nan)
    known = np.flatnonzero(np.isfinite(p))
    order = known[np.argsort(p[known], kind='stable')]
    stepped = p[order] * np.arange(len(order), 0, -1)
    corrected[order] = np.minimum(np.maximum.accumulate(stepped), 1.0)
    return corrected


def compare_paired(first: ArrayLike, second: ArrayLike) -> pd.DataFrame:
    """Test "first > second" over replications, for K comparisons that form one Holm family.

    Parameters
    ----------
    first, second : array_like (K, R)
        One value a replication; column r of both comes from the same replication.

    Returns
    -------
    pandas.DataFrame
        K rows of `TEST_COLUMNS`. `p_paper` is the paper's test (Student's two-sample t-test, equal
        variances, one-tailed, uncorrected); `p_paired` the paired t-test; `p_welch` Welch's;
        `p_sign_flip` the permutation test that flips the signs of the R differences (exact up to
        13 replications); `bootstrap_low` and `bootstrap_high` bound the mean difference (95 %,
        percentile); `hedges_g` is the mean difference over its standard deviation, corrected for
        small R. With one replication every test is NaN: nothing can be claimed.
    """
    first, second = np.atleast_2d(first).astype(float), np.atleast_2d(second).astype(float)
    difference = first - second
    replications = difference.shape[1]
    table = pd.DataFrame(
        {
            'replications': replications,
            'mean_first': first.mean(axis=1),
            'mean_second': second.mean(axis=1),
            'difference': difference.mean(axis=1),
        }
    ).reindex(columns=TEST_COLUMNS)
    if replications < 2 or not len(table):
        return table
    table['bootstrap_low'], table['bootstrap_high'] = bootstrap_interval(difference)
    table['hedges_g'] = hedges_g(difference)
    table['p_paper'] = _p(stats.ttest_ind, first, second)
    table['p_welch'] = _p(stats.ttest_ind, first, second, equal_var=False)
    table['p_paired'] = _p(stats.ttest_rel, first, second)
    table['p_sign_flip'] = sign_flip(difference)
    table['p_paired_holm'] = holm(table['p_paired'])
    table['p_sign_flip_holm'] = holm(table['p_sign_flip'])
    return table


def compare_groups(first: ArrayLike, second: ArrayLike) -> dict[str, float]:
    """Test "first > second" for two independent groups of replications (two conditions).

    Returns
    -------
    dict
        `difference` with its bootstrap interval, `hedges_g` (pooled standard deviation), `p_paper`
        (Student, one-tailed), `p_welch` (one-tailed) and `p_permutation` (labels exchanged, exact
        for small groups). Tests are NaN when a group has fewer than two replications.
    """
    first, second = np.asarray(first, float), np.asarray(second, float)
    row = {
        'replications_first': len(first),
        'replications_second': len(second),
        'mean_first': first.mean() if len(first) else np.nan,
        'mean_second': second.mean() if len(second) else np.nan,
    }
    row['difference'] = row['mean_first'] - row['mean_second']
    names = ('bootstrap_low', 'bootstrap_high', 'hedges_g', 'p_paper', 'p_welch', 'p_permutation')
    row.update(dict.fromkeys(names, np.nan))
    if min(len(first), len(second)) < 2:
        return row
    interval = _interval((first, second), _mean_difference)
    degrees = len(first) + len(second) - 2
    pooled = np.sqrt(
        ((len(first) - 1) * first.var(ddof=1) + (len(second) - 1) * second.var(ddof=1)) / degrees
    )
    row['bootstrap_low'], row['bootstrap_high'] = interval.low, interval.high
    row['hedges_g'] = (
        row['difference'] / pooled * (1 - 3 / (4 * degrees - 1)) if pooled > 0 else np.nan
    )
    row['p_paper'] = float(_p(stats.ttest_ind, first, second))
    row['p_welch'] = float(_p(stats.ttest_ind, first, second, equal_var=False))
    row['p_permutation'] = float(
        stats.permutation_test(
            (first, second),
            _mean_difference,
            alternative='greater',
            n_resamples=20000,
            rng=np.random.default_rng(0),
        ).pvalue
    )
    return row


def sign_flip(difference: ArrayLike) -> np.ndarray:
    """Permutation test of a mean above 0: flip the signs of R differences (..., R); p-values."""
    return stats.permutation_test(
        (np.asarray(difference, float),),
        np.mean,
        permutation_type='samples',
        vectorized=True,
        axis=-1,
        alternative='greater',
        n_resamples=9999,
        rng=np.random.default_rng(0),
    ).pvalue


def bootstrap_interval(values: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Bound the mean over the last axis (replications): low, high (95 %, percentile)."""
    values = np.asarray(values, float)
    if values.shape[-1] < 2:
        return np.full(values.shape[:-1], np.nan), np.full(values.shape[:-1], np.nan)
    interval = _interval((values,), np.mean, axis=-1)
    return interval.low, interval.high


def _interval(samples: tuple[np.ndarray, ...], statistic: Callable, **options: Any) -> Any:
    """Return the 95 % percentile interval; NaN where values are missing, without a warning."""
    with warnings.catch_warnings():
        warnings.simplefilter('ignore', stats.DegenerateDataWarning)
        return stats.bootstrap(
            samples,
            statistic,
            n_resamples=RESAMPLES,
            method='percentile',
            rng=np.random.default_rng(0),
            **options,
        ).confidence_interval


def hedges_g(difference: ArrayLike) -> np.ndarray:
    """Paired effect size: mean difference over its standard deviation, small-sample corrected."""
    difference = np.asarray(difference, float)
    degrees = difference.shape[-1] - 1
    deviation = difference.std(axis=-1, ddof=1)
    with np.errstate(divide='ignore', invalid='ignore'):
        return difference.mean(axis=-1) / deviation * (1 - 3 / (4 * degrees - 1))


def correlation(x: ArrayLike, y: ArrayLike) -> tuple[float, float, float, float]:
    """Pearson's r of two series, its two-tailed p and its 95 % interval (Fisher's z).

    NaN where a series has no variance; the interval also where there are fewer than 4 values.
    """
    x, y = np.asarray(x, float), np.asarray(y, float)
    if len(x) < 3 or np.ptp(x) == 0 or np.ptp(y) == 0:
        return np.nan, np.nan, np.nan, np.nan
    result = stats.pearsonr(x, y)
    low, high = result.confidence_interval(0.95) if len(x) > 3 else (np.nan, np.nan)
    return float(result.statistic), float(result.pvalue), float(low), float(high)


def detectable_effect(replications: int) -> float:
    """Smallest paired effect (in standard deviations) found with 80 % power at 5 %, one-tailed."""
    if replications < 2:
        return np.inf
    return float(
        TTestPower().solve_power(nobs=replications, alpha=ALPHA, power=0.8, alternative='larger')
    )


def caution(replications: int) -> str:
    """One sentence: what this number of replications cannot show."""
    if replications < 2:
        return (
            'One replication: every curve below is a description of this run; no difference '
            'between generations or conditions can be called significant.'
        )
    smallest = 0.5**replications
    sentence = (
        f'{replications} replications: only effects of about '
        f'{detectable_effect(replications):.1f} '
        'standard deviations or more are likely (80 %) to be detected at the 5 % level'
    )
    if smallest > ALPHA:
        return (
            f'{sentence}, and the exact sign-flip test cannot fall below p = {smallest:.3g}, '
            'so it cannot reach that level at all.'
        )
    return f'{sentence}; the exact sign-flip test cannot fall below p = {smallest:.3g}.'


def _mean_difference(first: np.ndarray, second: np.ndarray, axis: int = -1) -> np.ndarray:
    return np.mean(first, axis=axis) - np.mean(second, axis=axis)


def _p(
    test: Callable[..., Any], first: np.ndarray, second: np.ndarray, **options: Any
) -> np.ndarray:
    """One-tailed p; two equal constant samples (0/0 in the statistic) are no evidence: p = 1."""
    with warnings.catch_warnings(), np.errstate(divide='ignore', invalid='ignore'):
        warnings.simplefilter('ignore', RuntimeWarning)
        p = test(first, second, axis=-1, alternative='greater', **options).pvalue
    return np.nan_to_num(p, nan=1.0)
