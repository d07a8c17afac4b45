"""Episodes: known answers by hand, fitness, and what is refused."""

import math

import numpy as np
import pytest

from coevo_manager.core.episodes import (
    Environment,
    evaluate_matrix,
    evaluate_pairs,
    fitness,
    measure_pairs,
    trace_pair,
)
from neuro_controller.core.genome import GENES, random_genomes

PRINTED = Environment(motor_map='printed')
ZERO = np.zeros(GENES, np.float32)


def driver(translation, rotation):
    """A genome whose motor neurons have these net inputs whatever it senses."""
    genome = ZERO.copy()
    genome[10], genome[11] = translation, rotation
    return genome


def logistic(x):
    return 1 / (1 + math.exp(-x))


def capture(predator, prey, environment=Environment()):  # noqa: B008 (frozen)
    return int(evaluate_pairs([predator], [prey], [0], [0], environment)[0])


def straight_run(gap, speeds):
    """Tick in which two robots meet that drive straight at each other, tiring (equations 1 and 2).

    ``speeds`` are pairs of maximum wheel speed and its share that is wanted.
    """
    spent = [[], []]
    for tick in range(1, 1001):
        for robot, (maximum, share) in enumerate(speeds):
            tiredness = (sum(spent[robot][-200:]) / 200) ** 2
            wheel = maximum * (1 - tiredness) * share
            spent[robot].append(abs(wheel) / maximum)
            gap -= wheel * 0.027 * 0.1
        if gap <= 0:
            return tick
    return 1000


@pytest.mark.parametrize('predator', [-1, 0, 2, 5])
@pytest.mark.parametrize('prey', [-5, -1, 3])
def test_robots_that_drive_at_each_other_meet_when_they_should(predator, prey):
    # 0.83 m between the rims; tm = 1/2 drives straight
    expected = straight_run(0.83, [(8.5, logistic(predator)), (10, logistic(prey))])
    assert capture(driver(0, predator), driver(0, prey), PRINTED) == expected
    assert 15 < expected < 200


def test_a_long_chase_is_slowed_by_fatigue():
    # the prey backs away, slowly
    signed = Environment(motor_map='signed', predator_speed=2.0, prey_speed=2.0)
    shares = [2 * logistic(1) - 1, 2 * logistic(-0.2) - 1]
    expected = straight_run(0.83, [(2.0, shares[0]), (2.0, shares[1])])
    assert 300 < expected < 1000
    assert capture(driver(0, 1), driver(0, -0.2), signed) == expected


def test_no_capture_counts_as_the_whole_episode():
    # the prey stands 0.83 m off; 20 ticks of a predator at 8.5 rad/s are 0.46 m
    for ticks in (1, 20):
        environment = Environment(motor_map='signed', episode_ticks=ticks)
        assert capture(driver(0, 5), driver(0, 0), environment) == ticks
    # spinning in place, both of them
    assert capture(driver(-5, 5), driver(-5, 5), Environment(motor_map='signed')) == 1000


def test_the_obstacle_stands_between_them():
    head_on = driver(0, 5), driver(0, -5)
    obstructed = Environment(obstacle=True, motor_map='printed')
    assert capture(*head_on, PRINTED) < 100
    assert capture(*head_on, obstructed) == 1000
    trace = trace_pair(*head_on, obstructed)
    assert trace.poses[-1, 0, :2] == pytest.approx((-0.135, 0), abs=1e-6)


def test_every_choice_of_the_environment_matters():
    genomes = random_genomes(40, np.random.default_rng(0))
    pairs = np.arange(20)

    def results(**options):
        return measure_pairs(genomes[:20], genomes[20:], pairs, pairs, Environment(**options))[
            1
        ].tolist()

    usual = results()
    assert usual == results(predator_speed=8.5, prey_speed=10.0, wall_friction=0.5)
    for change in (
        {'predator_speed': 10.0},
        {'prey_speed': 9.0},
        {'wall_friction': 0.0},
        {'motor_map': 'printed'},
        {'wall_contact': 'slide'},
        {'wall_contact': 'undo'},
        {'infrared_response': 'linear'},
        {'ground_coding': 'raw'},
    ):
        assert results(**change) != usual
    assert results(obstacle=True) == results(obstacle=True, predator_speed=10.0)


def test_complexity_of_known_behaviour():
    # straight at constant speed: only the first step, from rest, and the slow tiring count
    ticks, complexity = measure_pairs(
        [driver(0, 0)],
        [driver(-5, 0)],
        [0],
        [0],
        Environment(motor_map='printed', episode_ticks=1),
    )
    assert ticks.tolist() == [1]
    assert complexity[0, 0] == pytest.approx(8.5 * 0.5 / 2, abs=1e-4)
    # l = 5 f, r = 5 with f(0.0067) = -0.94682: |tv| + |rv| = 5 (1 + f)/2 + 5 (1 - f)/2 = 5
    assert complexity[0, 1] == pytest.approx(5 / 2, abs=1e-4)
    ticks, complexity = measure_pairs(
        [driver(0, 0)], [driver(0, 0)], [0], [0], Environment(motor_map='signed')
    )
    assert complexity == pytest.approx(np.zeros((1, 2)), abs=1e-6)


def test_the_two_fitnesses_sum_to_one():
    ticks = np.arange(1, 1001)
    predator, prey = fitness(ticks, 'predator'), fitness(ticks, 'prey')
    assert (predator + prey == 1).all()
    assert predator[-1] == 0 and prey[-1] == 1
    assert fitness([250], 'predator').tolist() == [0.75]
    assert fitness([5], 'prey', episode_ticks=20).tolist() == [0.25]
    with pytest.raises(ValueError, match='hunter'):
        fitness(ticks, 'hunter')


def test_the_matrix_has_predators_in_rows():
    genomes = random_genomes(7, np.random.default_rng(1))
    matrix = evaluate_matrix(genomes[:3], genomes[3:])
    assert matrix.shape == (3, 4) and matrix.dtype == np.int32
    for i in range(3):
        for j in range(4):
            assert matrix[i, j] == capture(genomes[i], genomes[3 + j])


def test_no_episodes_are_no_error():
    assert evaluate_pairs([ZERO], [ZERO], np.array([], int), np.array([], int)).shape == (0,)


@pytest.mark.parametrize(
    ('change', 'clue'),
    [
        ({'predators': np.zeros((1, 441))}, 'predators.*441.*442'),
        ({'prey': np.full((1, 442), np.nan)}, 'prey.*nan'),
        ({'prey': np.full((1, 442), -5.5)}, r'prey.*-5\.5'),
        ({'predator_index': [1]}, 'predator_index.*1'),
        ({'prey_index': [-1]}, 'prey_index.*-1'),
        ({'prey_index': [0, 0]}, 'prey_index.*2'),
        ({'predator_index': [0.5]}, 'predator_index'),
        ({'predator_index': [[0]]}, 'predator_index'),
        ({'threads': 0}, 'threads.*0'),
    ],
)
def test_bad_requests_are_refused_in_one_sentence(change, clue):
    request = {
        'predators': [ZERO],
        'prey': [ZERO],
        'predator_index': [0],
        'prey_index': [0],
        'threads': 1,
        **change,
    }
    with pytest.raises(ValueError, match=clue) as error:
        evaluate_pairs(**request)
    assert '\n' not in str(error.value)


@pytest.mark.parametrize(
    ('field', 'value'),
    [
        ('obstacle', 'yes'),
        ('motor_map', 'reversed'),
        ('wall_contact', 'soft'),
        ('infrared_response', 'cubic'),
        ('ground_coding', 'none'),
        ('predator_speed', 0.0),
        ('predator_speed', math.nan),
        ('prey_speed', -1.0),
        ('prey_speed', 1e9),
        ('prey_speed', 'fast'),
        ('episode_ticks', 0),
        ('episode_ticks', 10.5),
        ('episode_ticks', 10**9),
        ('wall_friction', -0.1),
        ('wall_friction', math.inf),
        ('physics', 'quantum'),
    ],
)
def test_bad_environments_are_refused_by_field_and_value(field, value):
    with pytest.raises(ValueError) as error:
        Environment(**{field: value})
    assert field in str(error.value)
    assert str(value) in str(error.value)
    assert '\n' not in str(error.value)
