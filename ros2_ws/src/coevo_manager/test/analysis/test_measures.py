"""Measures of progress: hand-computed tournaments, the paper's own tables, planted truths."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from coevo_manager.analysis.conditions import Condition
from coevo_manager.analysis.measures import beyond, progress, statistics
from coevo_manager.analysis.measures import paper as measures
from coevo_manager.analysis.measures.paper import performance
from coevo_manager.analysis.report.progress import verdicts as verdicts_of

GENERATIONS = np.arange(5) * 100


def logistic(x):
    return 1 / (1 + np.exp(-x))


def planted(kind, replications=6, size=9, noise=0.01, seed=0):
    """Tournaments (R, S, S) of predators of strength a against prey of strength b."""
    rng = np.random.default_rng(seed)
    time = np.linspace(0, 1, size)
    found = []
    for _ in range(replications):
        if kind == 'progress':
            margin = 4 * (time[:, None] - time[None, :])
        elif kind == 'cycle':
            turn = 2 * np.pi * (2.37 * time + rng.random())
            margin = 2 * np.sin(turn[:, None] - turn[None, :] + 0.7)
        else:
            margin = rng.normal(0, 1, (size, size))
        found.append(logistic(margin + rng.normal(0, noise, (size, size))))
    return np.array(found)


def test_who_is_row_and_who_is_column():
    tournament = np.array([[0.1, 0.2], [0.7, 0.4]])  # predators of generation 1, prey of 0: 0.7
    assert performance(tournament, 'predator')[1, 0] == 0.7
    assert performance(tournament, 'prey')[0, 1] == pytest.approx(
        0.3
    )  # prey 0 against predators 1
    assert performance(tournament, 'prey')[1, 0] == pytest.approx(
        0.8
    )  # prey 1 against predators 0
    with pytest.raises(ValueError, match='species is'):
        performance(tournament, 'wolf')


def test_ciao_keeps_ancestors_only():
    table = measures.ciao(np.array([[0.1, 0.2], [0.7, 0.4]]), 'prey')
    assert np.isnan(table[0, 1])
    assert table[1, 0] == pytest.approx(0.8)
    assert table[1, 1] == pytest.approx(0.6)


def test_historical_table_by_hand():
    """Predators gain 0.3 a generation of age difference; only that is beyond the noise."""
    rng = np.random.default_rng(1)
    ages = np.arange(4)
    tournament = 0.5 + 0.1 * (ages[:, None] - ages[None, :]) + rng.normal(0, 0.001, (5, 4, 4))
    tests = measures.historical_tests(tournament, GENERATIONS[:4], 'predator')
    assert list(measures.most_recent(tests)) == [0, 100, 200]
    assert measures.duration(measures.most_recent(tests)) == 300
    row = tests[(tests.generation == 300) & (tests.earlier == 100)].iloc[0]
    assert row['mean_first'] == pytest.approx(0.7, abs=0.002)  # predators 300 against prey 100
    assert row['mean_second'] == pytest.approx(0.5, abs=0.002)  # predators 300 against prey 300


def test_global_table_compares_agents_against_the_last_opponents():
    noise = np.array([-2, -1, 0, 1, 2]) * 0.001
    tournament = np.full((5, 4, 4), 0.5) + noise[:, None, None]
    tournament[:, 2:, 3] += 0.2  # predators of 200 and 300 beat the last prey
    tests = measures.global_tests(tournament, GENERATIONS[:4], 'predator')
    assert list(measures.most_recent(tests)) == [0, 100, 100]
    assert measures.duration(measures.most_recent(tests)) == 200
    swapped = np.swapaxes(1 - tournament, 1, 2)
    prey = measures.global_tests(swapped, GENERATIONS[:4], 'prey')
    assert list(measures.most_recent(prey)) == [0, 100, 100]


PAPER = {  # Tables 1 and 2, and how far the text of section 3 says progress continued, in 10,000s
    'standard predators, historical': ([0, 1, 2, 2, 3, 4, 4, 5, 5, 5, 5, 6, 7, 7, 7], 13),
    'standard prey, historical': ([0, 1, 1, 2, 2, 3, 3, 4, 5, 4, 4, 4, 4, 7, 7], 14),
    'simplified predators, historical': ([0, 1, 1, 2, 3, 4, 4, 4, 4, 4, 5, 5, 5, 6, 6], 14),
    'simplified prey, historical': ([0, 1, 1, 2, 2, 2, 2, 3, 3, 5, 5, 5, 5, 6, 6], 14),
    'vanilla predators, historical': ([0] * 15, 0),
    'standard predators, global': ([0, 0, 1, 1, 1, 2, 2, 3, 3, 3, 3, 3, 3, 3], 8),
    'standard prey, global': ([0, 1, 2, 3, 3, 3, 4, 5, 6, 6, 6, 7, 7, 7], 12),
    'simplified predators, global': ([0, 0, 2, 2, 2, 3, 4, 4, 5, 5, 5, 5, 5, 5], 9),
    'simplified prey, global': ([0, 0, 1, 1, 2, 3, 3, 4, 4, 4, 5, 5, 5, 5], 11),
}


@pytest.mark.parametrize('name', PAPER)
def test_durations_that_the_paper_reads_from_its_tables(name):
    entries, expected = PAPER[name]
    table = pd.Series(entries, index=np.arange(1, len(entries) + 1))
    assert measures.duration(table) == expected


def test_rate_is_gain_over_earlier_opponents_a_thousand_generations():
    ages = np.arange(5)
    tournament = 0.5 + 0.1 * ages[:, None] - 0.05 * ages[None, :]
    # Predators of 300 exceed those of 0 by 0.3 against everyone: 0.3 in 300 generations.
    assert measures.rate(tournament, GENERATIONS, 'predator', 300) == pytest.approx(1.0)
    assert measures.rate(tournament, GENERATIONS, 'prey', 200) == pytest.approx(0.5)
    assert np.isnan(measures.rate(tournament, GENERATIONS, 'prey', 0))


def test_representative_behaviours_are_ranked():
    complexity = np.array([[5.0, 1.0, 4.0], [2.0, 3.0, 9.0], [6.0, 7.0, 8.0]])
    picks = measures.representative(complexity)
    assert [complexity[pick] for pick in picks] == [1, 3, 5, 7, 9]
    assert picks[0] == (0, 1)


def test_normalised_curve():
    assert list(measures.normalised([0.2, 0.6, 0.4])) == pytest.approx([0, 1, 0.5])
    assert list(measures.normalised([0.3, 0.3])) == [0, 0]


def test_retrogression_by_hand():
    tournament = np.array([[0.2, 0.4], [0.5, 0.3], [0.4, 0.6]])[None, :, :]
    square = np.concatenate([tournament, np.zeros((1, 3, 1))], axis=2)
    # Predators' steps: +0.3 -0.1 0 / -0.1 +0.3 0: 2 of 6 fall, losing 0.2 of 0.8.
    rate, loss = beyond.retrogression(square, 'predator')
    assert rate[0] == pytest.approx(2 / 6)
    assert loss[0] == pytest.approx(0.2 / 0.8)


def test_hodge_of_rock_paper_scissors_and_of_a_ladder():
    circle = 0.5 + 0.1 * np.array([[0, 1, -1], [-1, 0, 1], [1, -1, 0]])
    rating, cyclic, share = beyond.hodge(circle)
    assert rating == pytest.approx([0, 0, 0])
    assert share == pytest.approx(1)
    assert cyclic == pytest.approx(circle - circle.T)
    ages = np.arange(3)
    rating, _, share = beyond.hodge(0.5 + 0.05 * (ages[:, None] - ages[None, :]))
    assert rating == pytest.approx([-0.1, 0, 0.1])
    assert share == pytest.approx(0, abs=1e-12)
    assert np.isnan(beyond.hodge(np.full((3, 3), 0.4))[2])


def test_hodge_parts_are_orthogonal_and_add_up():
    tournament = np.random.default_rng(3).random((7, 7))
    rating, cyclic, share = beyond.hodge(tournament)
    transitive = rating[:, None] - rating[None, :]
    assert transitive + cyclic == pytest.approx(tournament - tournament.T)
    assert (transitive * cyclic).sum() == pytest.approx(0, abs=1e-9)
    assert 0 < share < 1


def test_diversity_by_hand():
    paths = np.array([[[0, 0], [0, 0]], [[3, 4], [0, 0]], [[0, 0], [0, 2]]], float)
    # Mean distances of the three pairs: 2.5, 1, 3.5.
    assert beyond.path_diversity(paths) == pytest.approx((2.5 + 1 + 3.5) / 3)
    assert beyond.profile_diversity([[0, 0, 0, 0], [1, 1, 1, 1]]) == pytest.approx(1)
    assert np.isnan(beyond.path_diversity(paths[:1]))


def verdicts(tournaments):
    """Verdicts on one condition without held-out opponents."""
    condition = Condition('Standard', 'open arena')
    each = SimpleNamespace(
        condition=condition, tournament=tournaments, held_out_mean=lambda species: None
    )
    return verdicts_of(SimpleNamespace(conditions=[each]))


def test_halves_leave_random_genomes_out():
    assert progress.halves(16) == (slice(1, 8), slice(8, 16))
    early, late = progress.halves(2)
    assert len(range(2)[early]) == len(range(2)[late]) == 0


def test_planted_progress_is_found():
    tournaments = planted('progress')
    assert set(verdicts(tournaments)['verdict']) == {'progress'}
    tests = measures.historical_tests(tournaments, np.arange(9), 'predator')
    assert measures.duration(measures.most_recent(tests, 'p_paired_holm')) == 8
    rate, _ = beyond.retrogression(tournaments, 'predator')
    assert rate.max() < 0.05
    rating, _, share = beyond.hodge(tournaments[0])
    assert np.all(np.diff(rating) > 0)
    assert share < 0.05


def test_planted_decay_is_called_retrogression():
    backwards = planted('progress')[:, ::-1, ::-1]
    found = verdicts(backwards).set_index('measure')['verdict']
    assert set(found['global']) == {'retrogression'}


def test_a_planted_cycle_is_never_called_progress():
    for seed in range(12):
        assert 'progress' not in set(verdicts(planted('cycle', seed=seed))['verdict'])
    rate, _ = beyond.retrogression(planted('cycle'), 'prey')
    assert rate.mean() > 0.35


@pytest.mark.parametrize('replications', [1, 6])
def test_what_did_not_change_is_neither_progress_nor_retrogression(replications):
    """0/0 is no evidence of anything: the prey here never change, only the predators do."""
    rows = np.linspace(0.1, 0.7, 9)
    constant = np.repeat(rows[:, None], 9, axis=1) + np.arange(replications)[:, None, None] / 50
    found = verdicts(constant).set_index(['species', 'measure'])
    assert found.loc[('prey', 'global'), 'verdict'] == 'no change'
    assert found.loc[('prey', 'global'), 'difference'] == pytest.approx(0, abs=1e-12)
    assert found.loc[('predator', 'historical'), 'verdict'] == 'no change'
    assert found.loc[('predator', 'global'), 'verdict'] in ('progress', 'cannot be claimed')


def test_one_replication_claims_nothing():
    assert set(verdicts(planted('progress', replications=1))['verdict']) == {'cannot be claimed'}


def test_no_difference_gives_the_nominal_false_positive_rate():
    pairs = []
    for seed in range(600):
        own = performance(planted('none', seed=seed), 'predator' if seed % 2 else 'prey')
        pairs.append(progress.historical_gain(own))
        pairs.append(progress.global_gain(own[:, :, 1:].mean(axis=2)))
    first, second = np.swapaxes(pairs, 0, 1)
    p = statistics.compare_paired(first, second)['p_paired'].to_numpy().reshape(-1, 2)
    assert 0.03 < (p[:, 0] < 0.05).mean() < 0.075  # 0.05 within three standard errors
    assert 0.03 < (p[:, 1] < 0.05).mean() < 0.075


def test_no_difference_is_seldom_called_progress():
    """Corrected, at least one of a condition's verdicts errs in about 5 % of conditions."""
    found = [verdicts(planted('none', seed=seed))['p_paired_holm'].min() for seed in range(30)]
    assert (
        np.array(found) < 0.05
    ).mean() < 0.15  # a binomial of 60 and 0.05 exceeds it once in 2000
