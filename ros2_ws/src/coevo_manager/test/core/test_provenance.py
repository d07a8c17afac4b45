"""The environment that champions play in: their own, unless told otherwise."""

import math

import numpy as np
import pytest

from coevo_manager.core.environment import Environment
from coevo_manager.core.evolution import load_configuration
from coevo_manager.core.provenance import choose_environment, describe, episode_record
from neuro_controller.core.champions import Champion
from neuro_controller.core.origin import Origin


def champion(species, **values):
    configuration = load_configuration(values)
    origin = Origin('first', 500, 'abc', configuration.as_dict())
    return Champion(np.zeros(442, np.float32), species, 0, origin), configuration


def test_a_champion_plays_where_it_evolved():
    values = {
        'world': 'robust',
        'environment': 'obstacle',
        'prey_speed': 6.0,
        'motor_map': 'printed',
        'episode_ticks': 300,
        'wall_friction': 0.1,
    }
    predator, configuration = champion('predator', **values)
    prey, _ = champion('prey', **values)
    for champions in ([predator], [prey], [predator, prey]):
        environment, replaced = choose_environment(champions, {})
        assert environment == configuration.make_environment()
        assert not replaced


def test_options_replace_and_say_so():
    predator, _ = champion('predator', world='faithful')
    environment, replaced = choose_environment([predator], {'motor_map': 'printed', 'other': 1})
    assert environment == Environment(motor_map='printed')
    assert replaced == ['motor_map is printed, in place of signed where the predator evolved']


def test_a_world_replaces_all_that_worlds_set():
    predator, _ = champion('predator', world='robust', prey_speed=6.0)
    environment, replaced = choose_environment([predator], {'world': 'faithful'})
    assert environment == Environment(prey_speed=6.0)
    assert 'camera_noise is 0.0, in place of 0.05 where the predator evolved' in replaced
    environment, _ = choose_environment([predator], {'world': 'varied', 'start_rotation': 1.0})
    assert environment.perturbations.start_displacement == 0.3
    assert environment.perturbations.start_rotation == 1.0
    assert environment.perturbations.camera_noise == 0.0


def test_two_runs_must_agree_but_for_their_speeds():
    predator, _ = champion('predator', world='faithful', predator_speed=5.0, prey_speed=1.0)
    prey, _ = champion('prey', world='faithful', predator_speed=2.0, prey_speed=6.0)
    environment, replaced = choose_environment([predator, prey], {})
    assert environment.max_wheel_speeds == (5.0, 6.0)
    assert not replaced
    other, _ = champion('prey', world='faithful', environment='obstacle')
    with pytest.raises(ValueError, match='expected --environment to choose'):
        choose_environment([predator, other], {})
    environment, replaced = choose_environment([predator, other], {'environment': 'open'})
    assert not environment.obstacle
    assert replaced == ['environment is open, in place of obstacle where the prey evolved']


def test_a_champion_is_described_with_its_world():
    predator, _ = champion('predator', world='varied', start_rotation=1.0)
    assert describe(predator) == (
        'predator of rank 0 in generation 500 of run first, commit abc, '
        'world varied but start_rotation 1.0'
    )
    record = episode_record(Environment(), [predator, np.arange(442.0)])
    assert record['predator']['description'] == describe(predator)
    assert record['predator']['configuration']['start_displacement'] == 0.3
    assert record['environment']['perturbations']['start_rotation'] == 0.0
    assert record['prey'] == {
        'description': 'prey of unknown origin',
        'genome': list(range(442)),
    }
    assert math.isclose(record['environment']['prey_speed'], 10.0)
