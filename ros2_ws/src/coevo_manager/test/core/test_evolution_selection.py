"""Opponents, agents and survivors of a phase, against examples worked by hand (N = 8, n = 2)."""

from fractions import Fraction
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from coevo_manager.core.evolution import algorithms, load_configuration
from coevo_manager.core.evolution.algorithm import Contest
from coevo_manager.core.evolution.ranking import replacements, survivors
from coevo_manager.core.evolution.selection import (
    best_against_each,
    cluster,
    fittest,
    fittest_of_groups,
)
from coevo_manager.core.evolution.state import State
from neuro_controller.core.genome import GENES

N, T = 8, 1000


def algorithm(name, **values):
    return algorithms.load(name)(
        load_configuration({'algorithm': name, 'population': N, **values})
    )


@pytest.fixture
def state():
    """Eight prey whose results differ against predators 0 and 1 only.

    Against predator 0 they last 1, 5, 7, 11, 101, 102, 104 and 111 ticks, against predator 1
    500 ticks but prey 5, which lasts 520; against all others 500.
    """
    ticks = np.full((N, N), 500, np.int32)
    ticks[0] = [1, 5, 7, 11, 101, 102, 104, 111]
    ticks[1, 5] = 520
    genomes = np.arange(N, dtype=np.float32)[:, None] * np.ones(GENES, np.float32) / 10
    return State(genomes, -genomes, ticks, T)


def test_cluster_merges_the_nearest_first():
    # Round 1: 4-5 (distance 1), 1-2 (2), then of 0, 3, 6, 7: 6-7 (7), 0-3 (10).
    # Round 2: the centroids of {0, 3} and {1, 2} are both 5, those of the others 100.5 and 106.5.
    vectors = np.array([[0], [4], [6], [10], [100], [101], [103], [110]])
    assert cluster(vectors, 4).tolist() == [[0, 3], [1, 2], [4, 5], [6, 7]]
    assert cluster(vectors, 2).tolist() == [[0, 1, 2, 3], [4, 5, 6, 7]]
    assert cluster(vectors, 8).tolist() == [[i] for i in range(8)]
    assert cluster(vectors, 1).tolist() == [list(range(8))]


def test_cluster_breaks_ties_by_the_lowest_index():
    assert cluster(np.zeros((8, 3), int), 4).tolist() == [[0, 1], [2, 3], [4, 5], [6, 7]]
    # 1 is as far from 0 as from 2: 0-1 merges first.
    assert cluster(np.array([[0], [1], [2], [3]]), 2).tolist() == [[0, 1], [2, 3]]


def cluster_slowly(vectors, groups):
    """The same merging with exact fractions, one pair at a time."""
    clusters = [[i] for i in range(len(vectors))]
    while len(clusters) > groups:
        waiting, merged = list(clusters), []
        centroid = {
            tuple(group): [
                Fraction(int(sum(vectors[i][d] for i in group)), len(group))
                for d in range(len(vectors[0]))
            ]
            for group in clusters
        }

        def distance(pair, centroid=centroid):
            first, second = (centroid[tuple(group)] for group in pair)
            return sum((x - y) ** 2 for x, y in zip(first, second, strict=True))

        while waiting:
            first, second = min(combinations(waiting, 2), key=distance)
            waiting.remove(first)
            waiting.remove(second)
            merged.append(sorted(first + second))
        clusters = sorted(merged)
    return clusters


@settings(deadline=None, max_examples=60)
@given(st.data())
def test_cluster_equals_an_independent_implementation(data):
    groups = data.draw(st.sampled_from([1, 2, 3, 5]))
    size = groups * data.draw(st.sampled_from([2, 4] if groups > 2 else [2, 4, 8]))
    largest = data.draw(st.sampled_from([3, 1000]))  # many ties, or hardly any
    row = st.lists(st.integers(0, largest), min_size=3, max_size=3)
    vectors = np.array(data.draw(st.lists(row, min_size=size, max_size=size)))
    assert cluster(vectors, groups).tolist() == cluster_slowly(vectors.tolist(), groups)


def test_fittest_of_each_group():
    fitness = np.array([3, 9, 9, 1, 0, 0, 5, 2])
    groups = np.array([[0, 1, 2, 3], [4, 5, 6, 7]])
    assert fittest_of_groups(groups, fitness).tolist() == [1, 6]  # 1 and 2 tie: the lower
    assert fittest(fitness, 3).tolist() == [1, 2, 6]


def test_standard_chooses_differentiated_opponents(state):
    # Prey, round 1: 1-2 (2), 4-6 (3), 0-3 (10), 5-7 (sqrt(81 + 400)); round 2: {0, 1, 2, 3} and
    # {4, 5, 6, 7}. The fittest last longest in sum: prey 3 (11), prey 5 (102 + 20 more).
    opponents = algorithm('standard', selected=2).opponents(state, np.random.default_rng())
    assert opponents.index.tolist() == [3, 5]
    np.testing.assert_array_equal(opponents.genomes, state.prey[[3, 5]])


def test_simplified_chooses_the_fittest_opponents(state):
    # Summed over predators: prey 5 lasts 102 + 520 + 6 * 500, prey 7 111 + 500 + 6 * 500.
    opponents = algorithm('simplified', selected=2).opponents(state, np.random.default_rng())
    assert opponents.index.tolist() == [5, 7]


def test_vanilla_chooses_everyone(state):
    vanilla = algorithm('vanilla')
    opponents = vanilla.opponents(state, np.random.default_rng())
    np.testing.assert_array_equal(opponents.genomes, state.prey)
    fitness = state.fitness('predator')[:, opponents.index]
    assert vanilla.agents(fitness, np.random.default_rng()).tolist() == [*range(N)]


def test_prey_that_evolve_meet_predators(state):
    # Predators seen as opponents: 0 and 1 differ from the rest, and they are nearest neighbours
    # only of what is left: 2-3, 4-5 and 6-7 merge at distance 0, 0-1 last; {2, 3} and {4, 5}
    # merge next. Predator 0 is fittest of {0, 1, 6, 7}, predator 2 of {2, 3, 4, 5}.
    state.evolving = 'prey'
    opponents = algorithm('standard', selected=2).opponents(state, np.random.default_rng())
    assert opponents.index.tolist() == [0, 2]
    np.testing.assert_array_equal(opponents.genomes, state.predators[[0, 2]])


@pytest.mark.parametrize(('selection', 'expected'), [('distinct', [0, 2]), ('repeated', [0, 0])])
def test_agents_are_the_best_against_each_opponent(state, selection, expected):
    # Predator 0 is best against prey 3 (989) and prey 5 (898). The next best against prey 5 are
    # those with 500; predator 1 has 480, so that the lowest of them is 2.
    standard = algorithm('standard', selected=2, agent_selection=selection)
    fitness = state.fitness('predator')[:, [3, 5]]
    assert standard.agents(fitness, np.random.default_rng()).tolist() == expected


def test_a_distinct_agent_with_no_fitness_is_still_one():
    assert best_against_each(np.zeros((3, 3), int), distinct=True).tolist() == [0, 1, 2]


@pytest.fixture
def contest():
    """Ten predators against eight prey, T = 10.

    Incumbent i catches prey i at once, and all eight catch prey 7, which is worth nothing
    therefore. The first evolved agent catches prey 7 as well and nearly prey 0; the second
    catches prey 0 only.
    """
    fitness = np.zeros((10, 8), int)
    fitness[range(8), range(8)] = 10
    fitness[:8, 7] = 10
    fitness[8, [0, 7]] = 9, 10
    fitness[9, 0] = 10
    return Contest(fitness, np.arange(10), pair_ticks=10)


@pytest.mark.parametrize(
    ('name', 'weights', 'scores', 'evolved'),
    [
        # Weights 8 * 10 - 10 = 70 of prey 0 to 6, 0 of prey 7.
        ('standard', 'incumbents', [700] * 7 + [0, 9 * 70, 10 * 70], 1),
        # Weights 100 - 29 = 71 of prey 0, 90 of prey 1 to 6, 100 - 90 = 10 of prey 7.
        ('standard', 'all', [810] + [1000] * 6 + [100, 9 * 71 + 100, 710], 0),
        ('simplified', 'incumbents', [20] * 7 + [10, 19, 10], 0),
    ],
)
def test_ranking_and_replacement(contest, name, weights, scores, evolved):
    # In each reading incumbent 7 is dropped and one of the evolved agents stays: weighted by the
    # incumbents the second, which ties with incumbents 0 to 6; else the first.
    ranked = algorithm(name, selected=2, ranking_weights=weights).scores(contest)
    assert ranked.tolist() == scores
    places, retained = replacements(ranked, N)
    assert (places.tolist(), retained.tolist()) == ([7], [evolved])


def test_controls_rank_on_the_opponents_of_the_phase(contest):
    for name in ('hall_of_fame', 'random_opponents'):
        assert algorithm(name, selected=2).scores(contest).tolist() == [*range(10)]


def test_evolved_agents_stay_first_among_equals():
    assert survivors(np.zeros(10, int), N).tolist() == [8, 9, 0, 1, 2, 3, 4, 5]
    places, evolved = replacements(np.zeros(10, int), N)
    assert (places.tolist(), evolved.tolist()) == ([7, 6], [0, 1])


def test_the_best_evolved_takes_the_place_of_the_worst_dropped():
    scores = np.array([50, 10, 90, 20, 80, 70, 60, 40, 55, 95])
    # Kept: 9, 2, 4, 5, 6, 8, 0, 7; dropped: 3 (20) and 1 (10).
    places, evolved = replacements(scores, N)
    assert (places.tolist(), evolved.tolist()) == ([1, 3], [1, 0])
