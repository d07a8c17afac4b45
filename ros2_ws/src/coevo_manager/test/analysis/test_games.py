"""Game theory of tournaments: known answers, and two libraries that answer the same."""

import nashpy
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from open_spiel.python.egt import alpharank

from coevo_manager.analysis.measures import games

ROCK_PAPER_SCISSORS = np.array([[0.5, 0.0, 1.0], [1.0, 0.5, 0.0], [0.0, 1.0, 0.5]])
CHAIN = np.array([[0.5, 0.3, 0.1], [0.7, 0.5, 0.3], [0.9, 0.7, 0.5]])
"""Later predators beat all earlier ones, and so do later prey."""


def tournaments(rows=(1, 5), columns=(1, 5)):
    return st.tuples(st.integers(*rows), st.integers(*columns)).flatmap(
        lambda shape: arrays(float, shape, elements=st.integers(0, 20).map(lambda i: i / 20))
    )


def test_rock_paper_scissors_is_played_evenly():
    found = games.nash_average(ROCK_PAPER_SCISSORS)
    assert found.value == pytest.approx(0.5)
    assert found.predators == pytest.approx(np.full(3, 1 / 3), abs=1e-6)
    assert found.prey == pytest.approx(np.full(3, 1 / 3), abs=1e-6)
    assert found.predator_ratings == pytest.approx(np.zeros(3), abs=1e-6)
    assert games.effective_number(found.predators) == pytest.approx(3, abs=1e-5)
    assert games.effective_diversity(ROCK_PAPER_SCISSORS) == pytest.approx(1 / 3, abs=1e-6)
    assert games.exploitability(ROCK_PAPER_SCISSORS) == pytest.approx([1, 1, 1])
    assert games.alpha_rank(ROCK_PAPER_SCISSORS).sum(axis=0) == pytest.approx(np.full(3, 1 / 3))


def test_of_a_transitive_chain_the_last_remains():
    found = games.nash_average(CHAIN)
    assert found.predators == pytest.approx([0, 0, 1])
    assert found.prey == pytest.approx([0, 0, 1])
    assert found.predator_ratings == pytest.approx([-0.4, -0.2, 0])
    assert found.prey_ratings == pytest.approx([-0.4, -0.2, 0])
    assert games.effective_diversity(CHAIN) == pytest.approx(0, abs=1e-6)
    assert games.exploitability(CHAIN) == pytest.approx([0.8, 0.4, 0])
    assert games.alpha_rank(CHAIN)[2, 2] == pytest.approx(1, abs=1e-3)


@given(tournaments())
@settings(deadline=None, max_examples=50)
def test_nobody_gains_by_leaving_the_equilibrium(fitness):
    found = games.nash_average(fitness)
    assert found.predator_ratings.max() < 1e-5
    assert found.prey_ratings.max() < 1e-5
    assert found.predators @ fitness @ found.prey == pytest.approx(found.value, abs=1e-5)


@pytest.mark.parametrize('seed', range(5))
def test_a_copy_moves_no_rating(seed):
    fitness = np.random.default_rng(seed).random((6, 5))  # its equilibrium is the only one
    once = games.nash_average(fitness)
    twice = games.nash_average(np.vstack((fitness, fitness[:1])))
    assert twice.predator_ratings[:-1] == pytest.approx(once.predator_ratings, abs=1e-4)
    assert twice.prey_ratings == pytest.approx(once.prey_ratings, abs=1e-4)
    assert twice.predators[0] == pytest.approx(twice.predators[-1], abs=1e-6)


def test_copies_share_their_probability_as_the_greatest_entropy_asks():
    doubled = np.vstack((ROCK_PAPER_SCISSORS, ROCK_PAPER_SCISSORS[:1]))
    found = games.nash_average(doubled)
    assert found.predators == pytest.approx([1 / 6, 1 / 3, 1 / 3, 1 / 6], abs=1e-5)


@given(tournaments((2, 5), (2, 5)))
@settings(deadline=None, max_examples=30)
def test_the_value_is_that_of_nashpy(fitness):
    game = nashpy.Game(fitness, -fitness)
    rows, columns = game.linear_program()
    assert games.nash_average(fitness).value == pytest.approx(rows @ fitness @ columns, abs=1e-6)


@pytest.mark.parametrize('fitness', [ROCK_PAPER_SCISSORS, CHAIN, CHAIN[:, :2], CHAIN[[0, 2]]])
def test_alpha_rank_is_that_of_open_spiel(fitness):
    _, _, expected, _, _ = alpharank.compute(
        [fitness, 1 - fitness], m=50, alpha=0.5, use_local_selection_model=False
    )
    found = games.alpha_rank(fitness, alpha=0.5, population=50)
    assert found.ravel() == pytest.approx(expected, abs=1e-9)


def test_alpha_rank_of_the_published_matching_pennies_and_of_a_dominant_pair():
    pennies = np.array([[1.0, 0.0], [0.0, 1.0]])
    assert games.alpha_rank(pennies) == pytest.approx(np.full((2, 2), 0.25))
    dominant = np.array([[0.6, 0.4], [0.9, 0.8]])
    assert games.alpha_rank(dominant)[1, 1] == pytest.approx(1, abs=1e-3)


def test_generations_of_a_real_size_are_ranked_without_underflow():
    rng = np.random.default_rng(1)
    strength = np.linspace(0, 1, 16)
    fitness = 0.5 + (strength[:, None] - strength) / 2 + rng.normal(0, 0.01, (16, 16))
    found = games.alpha_rank(np.clip(fitness, 0, 1))
    assert np.isfinite(found).all()
    assert found.sum() == pytest.approx(1)
    assert found[13:, 13:].sum() > 0.9
