"""Statistics of the analysis against hand-computed values and their own promises."""

import warnings

import numpy as np
import pytest
from statsmodels.stats.multitest import multipletests

from coevo_manager.analysis.measures import statistics


def test_known_t_tests():
    first, second = np.array([3.0, 4.0, 5.0]), np.array([1.0, 3.0, 2.0])
    row = statistics.compare_paired([first], [second]).iloc[0]
    # Differences 2, 1, 3: mean 2, standard deviation 1, t = 2 sqrt(3), 2 degrees of freedom, whose
    # distribution has the closed form P(T > t) = 1/2 - t / (2 sqrt(2 + t^2)).
    t = 2 * np.sqrt(3)
    assert row['p_paired'] == pytest.approx(0.5 - t / (2 * np.sqrt(2 + t**2)))
    assert row['difference'] == 2
    assert row['hedges_g'] == pytest.approx(2 * (1 - 3 / 7))
    # Both samples have variance 1: Student's t = 2 / sqrt(2/3) = sqrt(6), 4 degrees of freedom,
    # P(T > t) = 1/2 - (s/2) (3 - s^2) / 2 with s = t / sqrt(4 + t^2).
    s = np.sqrt(6 / 10)
    assert row['p_paper'] == pytest.approx(0.5 - s * (3 - s**2) / 4)
    assert row['p_welch'] == pytest.approx(row['p_paper'])  # equal variances and sizes
    assert row['p_sign_flip'] == pytest.approx(1 / 8)  # the largest of 8 sign patterns


def test_the_direction_of_the_tests():
    high, low = [[0.9, 0.8, 0.85, 0.95]], [[0.1, 0.2, 0.3, 0.15]]
    up, down = statistics.compare_paired(high, low), statistics.compare_paired(low, high)
    for column in ('p_paper', 'p_paired', 'p_welch', 'p_sign_flip'):
        assert up[column][0] < 0.07
        assert down[column][0] > 0.93
    assert up['bootstrap_low'][0] > 0.4


def test_holm_by_hand():
    # Sorted .01, .02, .04 times 3, 2, 1, made monotone; NaN is no member of the family.
    corrected = statistics.holm([0.04, 0.01, np.nan, 0.02])
    assert corrected[[0, 1, 3]] == pytest.approx([0.04, 0.03, 0.04])
    assert np.isnan(corrected[2])


def test_holm_against_statsmodels():
    p = np.random.default_rng(4).random((4, 7)) ** 3
    for family in p:
        assert statistics.holm(family) == pytest.approx(multipletests(family, method='holm')[1])


def test_equal_samples_are_no_evidence():
    row = statistics.compare_paired([[0.5, 0.5, 0.5]], [[0.5, 0.5, 0.5]]).iloc[0]
    assert row['p_paper'] == row['p_paired'] == row['p_welch'] == 1


def test_one_replication_tests_nothing():
    row = statistics.compare_paired([[0.9]], [[0.1]]).iloc[0]
    assert row['difference'] == pytest.approx(0.8)
    assert row[['p_paper', 'p_paired', 'p_sign_flip', 'bootstrap_low']].isna().all()
    assert 'no difference' in statistics.caution(1)
    assert np.isnan(statistics.compare_groups([0.9], [0.1, 0.2])['p_welch'])


def test_what_a_number_of_replications_can_show():
    assert 'cannot reach that level' in statistics.caution(3)
    assert 'cannot reach that level' not in statistics.caution(5)
    assert statistics.detectable_effect(5) > statistics.detectable_effect(20)


def test_groups_against_enumeration():
    first, second = [5.0, 6.0, 7.0], [1.0, 2.0, 3.0]
    found = statistics.compare_groups(first, second)
    assert found['p_permutation'] == pytest.approx(1 / 20)  # one of C(6, 3) assignments
    assert found['hedges_g'] == pytest.approx(4 * (1 - 3 / 15))
    assert found['bootstrap_low'] <= 4 <= found['bootstrap_high']


@pytest.mark.parametrize('column', ['p_paper', 'p_paired', 'p_welch', 'p_sign_flip'])
def test_false_positive_rate_is_nominal(column):
    rng = np.random.default_rng(5)
    tests = statistics.compare_paired(rng.normal(size=(2000, 6)), rng.normal(size=(2000, 6)))
    rate = (tests[column] < 0.05).mean()
    assert 0.03 < rate < 0.07  # 0.05 within 4 standard errors; sign flips are discrete: 3/64


def test_bootstrap_interval_covers_the_mean():
    rng = np.random.default_rng(6)
    low, high = statistics.bootstrap_interval(rng.normal(2.0, 1.0, (400, 20)))
    assert 0.88 < ((low < 2.0) & (high > 2.0)).mean() < 0.98


def test_correlation_without_variance_is_unknown():
    assert statistics.correlation([1, 2, 3], [2, 4, 6])[0] == pytest.approx(1)
    r, _, low, high = statistics.correlation([1, 2, 3, 4, 5], [1, 3, 2, 5, 4])
    # Fisher: tanh(artanh(r) -+ 1.96 / sqrt(n - 3)), r = 0.8, n = 5.
    assert (r, low, high) == pytest.approx((0.8, -0.279, 0.986), abs=0.001)
    assert np.isnan(statistics.correlation([1, 1, 1], [2, 4, 6])[0])


def test_intervals_of_missing_values_are_missing_and_nothing_warns():
    values = np.array([[0.1, 0.2, 0.4], [np.nan, 0.2, 0.4], [0.3, 0.3, 0.3]])
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        low, high = statistics.bootstrap_interval(values)
    assert 0.1 < low[0] + 1e-9 < high[0] < 0.4 + 1e-9
    assert np.isnan([low[1], high[1]]).all()
    assert low[2] == high[2] == pytest.approx(0.3)
