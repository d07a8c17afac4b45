"""The rules of the archives and of PSRO, against examples worked by hand."""

import numpy as np
import pytest

from coevo_manager.core.evolution import algorithms, load_configuration
from coevo_manager.core.evolution.algorithms.generalist_2025 import most_different
from coevo_manager.core.evolution.archive import Archive
from coevo_manager.core.evolution.matchup import Evolved, Meeting
from coevo_manager.core.evolution.meta_strategy import SOLVERS, systematic_sample
from coevo_manager.core.evolution.record import Record
from coevo_manager.core.evolution.state import State
from neuro_controller.core.genome import GENES, LAYOUT

T = 1000


def genomes(*values):
    """Genomes of one value each."""
    return np.array(values, np.float32)[:, None] * np.ones(GENES, np.float32)


def begun(name, population, **values):
    """An algorithm and a state that begin with genomes 0, 0.1, 0.2, ... and their negatives."""
    values = {'algorithm': name, 'population': population, **values}
    configuration = load_configuration(values)
    algorithm = algorithms.load(name)(configuration)
    first = genomes(*np.arange(population) / 10)
    ticks = np.full((population, population), 500, np.int32)
    memory = {species: np.zeros((population, 2 * GENES + 1)) for species in ('predator', 'prey')}
    state = State(first, -first, ticks, T, memory=memory)
    for species in ('predator', 'prey'):
        algorithm.remember(state, species)
    return algorithm, state


def evolved(agents, rivals, positions=None, meetings=()):
    """What a phase might have made of its agents, each captured at tick 200."""
    agents = genomes(*agents)
    return Evolved(
        agents,
        np.zeros(len(agents), np.int64),
        np.full((len(agents), rivals), 200, np.int32),
        np.ones((len(agents), 2 * GENES + 1)),
        agents if positions is None else genomes(*positions),
        list(meetings) or [[] for _ in agents],
    )


def settle(algorithm, state, **phase):
    return algorithm.settle(state, None, None, evolved(rivals=len(state.prey), **phase))


def test_an_archive_keeps_all_in_the_order_they_came():
    archive = Archive(LAYOUT)
    archive.add(genomes(*range(-2, 2)))
    archive.add(genomes(*(i / 10 for i in range(30))))
    assert archive.genomes[:, 0].tolist() == pytest.approx([-2, -1, 0, 1, *np.arange(30) / 10])
    archive.remove(1)
    assert archive.genomes[:3, 0].tolist() == pytest.approx([-2, 2.9, 0])


def test_the_best_sample_enters_and_the_lineage_goes_on_from_its_centre():
    archive, state = begun('archive', 10)
    start = archive.start(state, None, None)
    np.testing.assert_array_equal(start.genomes, state.predators[:1])
    assert settle(archive, state, agents=[4.0], positions=[3.0]) == 1
    start = archive.start(state, None, None)
    assert (start.genomes[:, 0].tolist(), start.memory.min()) == ([3.0], 1.0)
    assert state.predators[0, 0] == 4.0  # in place of the oldest
    assert state.capture_ticks[0].tolist() == [200] * 10
    state.evolving = 'prey'
    pool = archive.opponents(state, np.random.default_rng()).genomes
    assert pool[:, 0].tolist() == pytest.approx([*np.arange(10) / 10, 4.0])


def test_each_pair_of_samples_meets_a_draw_of_its_own_from_the_whole_archive():
    archive, state = begun('archive', 10)
    opponents = archive.opponents(state, np.random.default_rng())
    drawn = np.array([opponents.draw(0, generation, 21) for generation in range(200)])
    assert drawn.shape == (200, 21, 10)
    counts = np.bincount(drawn.ravel(), minlength=10)
    assert abs(counts - drawn.size / 10).max() < 5 * np.sqrt(drawn.size / 10)
    np.testing.assert_array_equal(opponents.draw(0, 3, 21), drawn[3])
    assert (drawn[3] != drawn[4]).any() and (drawn[3, 0] != drawn[3, 1]).any()


def test_opponents_are_of_the_lineages_in_turn_and_of_any_time():
    star, _ = begun('archive_star', 12, selected=10)
    # Members 0 to 11 belong to lineages 0 to 4 in turn; then lineages enter as 12, 13, ... 21.
    of = np.array([*np.arange(12) % 5, *np.arange(10) % 5])
    drawn = star.drawn(22, 500, np.random.default_rng(1))
    assert (of[drawn] == np.arange(10) % 5).all()
    assert set(drawn[:, 0]) == {0, 5, 10, 12, 17}  # lineage 0: three at first, two since
    assert set(drawn[:, 9]) == {4, 9, 16, 21}


def test_lineages_enter_one_archive_together():
    star, state = begun('archive_star', 10)
    assert settle(star, state, agents=[1, 2, 3, 4, 5]) == 5
    assert settle(star, state, agents=[6, 7, 8, 9, 10]) == 5
    assert settle(star, state, agents=[11, 12, 13, 14, 15]) == 5
    assert state.predators[:, 0].tolist() == [11, 12, 13, 14, 15, 6, 7, 8, 9, 10]


def test_who_is_nowhere_above_another_is_dominated():
    """Three members, two periods: means 0.9, 0.1; 0.5, 0.5; 0.5, 0.4 of 1000 ticks."""
    record = Record(periods=2)
    record.begin(3)
    record.use(0, np.array([0, 1, 2]), 10, np.array([9000, 5000, 5000]))
    record.use(1, np.array([0, 1, 2]), 10, np.array([1000, 5000, 4000]))
    np.testing.assert_allclose(record.means() / T, [[0.9, 0.1], [0.5, 0.5], [0.5, 0.4]])
    for seed in range(5):
        assert record.dominated(np.random.default_rng(seed), 10) == 2
    record.remove(2)
    assert record.dominated(np.random.default_rng(0), 10) == -1
    # A period later the first is forgotten: 0.1 is below 0.5 now.
    record.use(2, np.array([1]), 10, np.array([5000]))
    assert record.dominated(np.random.default_rng(0), 10) == 0
    # A member that was never an opponent is not tried.
    record.enter(1)
    assert record.members.tolist() == [0, 1, 3]


def test_a_history_gives_the_record_that_it_is_of():
    rng = np.random.default_rng(2)
    record, uses, left = Record(periods=3), [], []
    record.begin(4)
    for step in range(40):
        places = rng.permutation(len(record))[:3]
        uses.append(record.use(step // 5, places, 7, rng.integers(7000, size=3)))
        record.enter(1)
        place = record.dominated(rng, 10) if len(record) > 8 else -1
        left.append(place)
        if place >= 0:
            record.remove(place)
    assert max(left) >= 0
    again = Record.of(3, 4, np.array(left), np.concatenate(uses))
    np.testing.assert_array_equal(again.members, record.members)
    np.testing.assert_array_equal(again.means(), record.means())
    assert again.entered == record.entered == 40


def test_maxsolve_lets_the_dominated_go_beyond_its_size():
    maxsolve, state = begun('maxsolve_star', 3, selected=3, maxsolve_size=4)
    met = np.tile([0, 1, 2], (41, 1))

    def meetings(*values, ticks):
        return [[Meeting(genomes(v)[0], met, np.tile(ticks, (41, 1))) for v in values]]

    # Two generations of predators: prey 0, 1 and 2 last 100, 200 and 300 ticks against them.
    phase = meetings(1.0, 1.1, ticks=[100, 200, 300])
    settle(maxsolve, state, agents=[1.1], meetings=phase)
    members = maxsolve._archives['predator'].genomes[:, 0].tolist()
    assert members == pytest.approx([0, 0.1, 0.2, 1.0, 1.1])  # none was an opponent yet
    # Prey enter; beyond four, prey 0 or 1 goes, which prey 2 dominates.
    state.evolving = 'prey'
    settle(maxsolve, state, agents=[-1.1], meetings=meetings(-1.0, -1.1, ticks=[5, 5, 5]))
    members = sorted(maxsolve._archives['prey'].genomes[:, 0].tolist())
    assert members in (
        pytest.approx([-1.1, -1.0, -0.2, 0.0]),
        pytest.approx([-1.1, -1.0, -0.2, -0.1]),
    )
    drawn = maxsolve.opponents(state, np.random.default_rng()).draw(0, 0, 21)
    assert len(set(drawn[0])) == 3 and (drawn == drawn[0]).all()


def test_the_most_different_are_chosen_one_by_one():
    vectors = np.array([[0, 0], [1, 0], [9, 9], [9, 0], [0, 8]])
    # From 0: 18, 9, 8 away are 2, 3, 4. Then, from 0 and 2 in sum: 1: 1 + 17, 3: 9 + 9, 4: 8 + 10.
    assert most_different(vectors, 3, first=0).tolist() == [0, 2, 1]
    assert most_different(vectors, 5, first=3).tolist() == [3, 4, 2, 0, 1]


ROCK_PAPER_SCISSORS = np.array([[0.5, 0.0, 1.0], [1.0, 0.5, 0.0], [0.0, 1.0, 0.5]])
CHAIN = np.array([[0.5, 0.3, 0.1], [0.7, 0.5, 0.3], [0.9, 0.7, 0.5]])


@pytest.mark.parametrize('name', SOLVERS)
def test_meta_strategies_of_games_with_known_answers(name):
    assert SOLVERS[name](ROCK_PAPER_SCISSORS) == pytest.approx(np.full(3, 1 / 3), abs=0.01)
    assert SOLVERS[name](CHAIN) == pytest.approx([0, 0, 1], abs=0.03)
    # Optimal mixtures (2/5, 3/5) of rows and (3/5, 2/5) of columns; the value is 0.48.
    skewed = np.array([[0.6, 0.3], [0.4, 0.6]])
    assert SOLVERS[name](skewed) == pytest.approx([0.4, 0.6], abs=0.02)
    assert SOLVERS[name](1 - skewed.T) == pytest.approx([0.6, 0.4], abs=0.02)


def test_a_systematic_sample_takes_each_as_often_as_is_due():
    rng = np.random.default_rng(3)
    mixture = np.array([0.5, 0.0, 0.25, 0.25])
    for _ in range(20):
        assert np.bincount(systematic_sample(mixture, 8, rng)).tolist() == [4, 0, 2, 2]
    many = np.concatenate([systematic_sample(np.array([0.33, 0.67]), 3, rng) for _ in range(1000)])
    assert many.mean() == pytest.approx(0.67, abs=0.03)


def test_psro_answers_the_mixture_and_the_best_response_joins():
    psro, state = begun('psro', 3, selected=2)
    # Prey 2 lasts longest against everyone: their mixture is prey 2 alone.
    psro._ticks = np.array([[100, 200, 900], [100, 300, 800], [50, 100, 950]], np.int32)
    opponents = psro.opponents(state, np.random.default_rng())
    np.testing.assert_array_equal(opponents.genomes, state.prey[[2, 2]])
    agents = psro.start(state, None, None)
    # Predator 1 does best against it (200 of 1000), then predator 0 (100).
    np.testing.assert_array_equal(agents.genomes, state.predators[[1, 0]])
    assert agents.training.tolist() == [2 * 200, 2 * 100]
    phase = Evolved(
        genomes(1.0, 2.0),
        np.zeros(2, np.int64),
        np.array([[1, 1, 700], [500, 500, 600]], np.int32),
        np.zeros((2, 2 * GENES + 1)),
        genomes(1.0, 2.0),
        [[], []],
    )
    assert psro.settle(state, agents, None, phase) == 1
    assert state.predators[:, 0].tolist() == pytest.approx([2.0, 0.1, 0.2])
    assert state.capture_ticks[0].tolist() == [500, 500, 600]
    assert psro._ticks[3].tolist() == [500, 500, 600]
    state.evolving = 'prey'
    assert len(psro.rivals(state)) == 4


def test_opponents_that_change_demand_that_parents_are_evaluated_again():
    values = {'algorithm': 'archive', 'optimizer': 'one_plus_one'}
    with pytest.raises(ValueError, match='reevaluate_parents is False, expected True in'):
        load_configuration(values)
    assert load_configuration({**values, 'reevaluate_parents': True}).optimizer == 'one_plus_one'
    with pytest.raises(ValueError, match='maxsolve_size is 5, expected at least selected, 10'):
        load_configuration({'algorithm': 'maxsolve_star', 'maxsolve_size': 5})
    with pytest.raises(ValueError, match='population is 4, expected at least 5'):
        load_configuration({'algorithm': 'archive_star', 'population': 4})
