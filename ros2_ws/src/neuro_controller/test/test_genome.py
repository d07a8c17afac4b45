"""The genome: its length, its range and what is refused."""

import numpy as np
import pytest

from neuro_controller.core.controller import Controller
from neuro_controller.core.genome import GENES, check_genomes, random_genomes


def test_the_length_is_the_papers():
    assert GENES == 442 == 12 + 25 * 10 + 10 * 10 + 10 + 25 * 2 + 10 * 2


def test_random_genomes_fill_the_range():
    genomes = random_genomes(200, np.random.default_rng(0))
    assert genomes.shape == (200, 442)
    assert genomes.dtype == np.float32
    assert -5 <= genomes.min() < -4.999 and 4.999 < genomes.max() <= 5
    # uniform: mean 0 and variance 100/12, each within five standard errors
    assert abs(genomes.mean()) < 5 * np.sqrt(100 / 12 / genomes.size)
    assert genomes.var() == pytest.approx(100 / 12, rel=0.02)
    again = random_genomes(200, np.random.default_rng(0))
    assert (genomes == again).all()
    assert (genomes != random_genomes(200, np.random.default_rng(1))).any()


def test_good_genomes_pass_unchanged():
    genomes = random_genomes(3, np.random.default_rng(0))
    genomes[0, :2] = (-5, 5)
    checked = check_genomes(genomes, 'predators')
    assert checked.dtype == np.float32
    assert (checked == genomes).all()
    assert (check_genomes(genomes.astype(float).tolist(), 'prey') == genomes).all()


def broken(index, value):
    genomes = np.zeros((3, 442))
    genomes[index] = value
    return genomes


@pytest.mark.parametrize(
    ('genomes', 'clue'),
    [
        (np.zeros((3, 441)), '441'),
        (np.zeros((3, 443)), '443'),
        (np.zeros((2, 3, 442)), '442'),
        (broken((1, 7), np.nan), 'nan'),
        (broken((1, 7), np.inf), 'inf'),
        (broken((2, 441), 5.01), '5.01'),
        (broken((0, 0), -7), '-7'),
    ],
)
def test_bad_genomes_are_refused_in_one_sentence(genomes, clue):
    with pytest.raises(ValueError) as error:
        check_genomes(genomes, 'predators')
    message = str(error.value)
    assert 'predators' in message
    assert clue in message
    assert '\n' not in message


@pytest.mark.parametrize('length', [0, 441, 443])
def test_a_controller_refuses_a_genome_of_another_length(length):
    with pytest.raises(ValueError, match='442'):
        Controller(np.zeros(length, np.float32), max_wheel_speed=10.0)


def test_a_controller_refuses_an_unknown_motor_map():
    with pytest.raises(ValueError, match='backwards'):
        Controller(np.zeros(GENES, np.float32), max_wheel_speed=10.0, motor_map='backwards')
