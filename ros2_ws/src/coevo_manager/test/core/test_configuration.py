"""The configuration: one loader, every wrong value named."""

import dataclasses
import json
import math

import pytest

from coevo_manager.core.configuration import (
    FIELDS,
    PRESETS,
    Configuration,
    differences,
)
from coevo_manager.core.environment import OPTIONS, Environment
from coevo_manager.core.evolution import algorithms, load_configuration
from coevo_manager.core.evolution.fields import all_fields
from coevo_manager.core.evolution.loading import complete
from coevo_manager.core.worlds import WORLDS
from marxbot_sim.core.perturbations import Perturbations


def test_the_paper_preset_is_the_papers():
    paper = load_configuration({}, 'paper')
    assert (paper.population, paper.selected) == (80, 10)
    assert (paper.phases, paper.generations, paper.swap_generations) == (1500, 100, 500)
    assert paper.mutation_rate == 0.02
    environment = paper.make_environment()
    assert (environment.predator_speed, environment.prey_speed) == (8.5, 10.0)
    assert (environment.episode_ticks, paper.world) == (1000, 'faithful')
    assert environment == Environment()
    obstacle = load_configuration({'environment': 'obstacle'}, 'paper').make_environment()
    assert (obstacle.predator_speed, obstacle.obstacle) == (10.0, True)


def test_the_usual_preset_is_quick_in_the_world_varied():
    assert load_configuration({}) == load_configuration({'world': 'varied'}, 'quick')


def test_the_defaults_are_the_world_faithful():
    assert load_configuration({'world': 'faithful'}) == complete(Configuration())
    assert Configuration().make_environment() == Environment()


def test_the_worlds():
    faithful, varied, robust = (
        load_configuration({'world': world}).make_environment()
        for world in ('faithful', 'varied', 'robust')
    )
    assert (faithful.motor_map, faithful.wall_contact) == ('signed', 'rigid')
    assert (faithful.infrared_response, faithful.ground_coding) == ('squared', 'relative')
    assert not faithful.perturbations.active
    starts = {'start_displacement': 0.3, 'start_rotation': math.pi}
    assert varied == Environment(perturbations=Perturbations(**starts))
    noise = {'camera_noise': 0.05, 'infrared_noise': 0.01, 'ground_noise': 0.005}
    perturbations = Perturbations(**starts, **noise, motor_noise=0.05)
    assert robust == Environment(perturbations=perturbations)


def test_a_single_value_overrides_the_world():
    configuration = load_configuration({'world': 'robust', 'camera_noise': 0, 'seed': 3}, 'paper')
    assert (configuration.world, configuration.phases) == ('robust', 1500)
    assert (configuration.camera_noise, configuration.motor_noise) == (0.0, 0.05)


def test_every_condition_of_an_episode_can_be_configured():
    names = {field.name for field in dataclasses.fields(Environment)}
    assert names - set(FIELDS) == {'obstacle', 'perturbations', 'repetitions'}
    assert {name: FIELDS[name] for name in OPTIONS} == OPTIONS
    imperfect = Perturbations(
        **dict.fromkeys(('wheel_radius_scale', 'wheel_separation_scale'), 1.1),
        **dict.fromkeys(('infrared_noise', 'camera_noise', 'ground_noise'), 0.02),
        motor_noise=0.05,
        latency_ticks=2,
        battery=0.9,
        command_loss=0.1,
        start_distance=1.5,
        start_displacement=0.2,
        start_rotation=1.0,
        robots='prey',
        seed=5,
    )
    values = dataclasses.asdict(imperfect)
    values['perturbed_robots'] = values.pop('robots')
    values['perturbation_seed'] = values.pop('seed')
    assert all(FIELDS[name].default != value for name, value in values.items())
    choices = {
        'wall_contact': 'undo',
        'infrared_response': 'linear',
        'ground_coding': 'raw',
        'motor_map': 'printed',
        'physics': 'pymunk',
        'wall_friction': 0.1,
    }
    each = {'episodes_per_opponent': 4}
    configuration = load_configuration({**choices, **values, **each})
    environment = configuration.make_environment()
    assert environment == Environment(**choices, perturbations=imperfect, repetitions=4)


def test_given_values_replace_those_of_the_preset():
    configuration = load_configuration({'phases': 3, 'seed': 9}, 'paper')
    assert (configuration.phases, configuration.seed, configuration.generations) == (3, 9, 100)


def test_every_field_is_documented():
    for name, option in all_fields().items():
        assert option.help, name
    for values in (*PRESETS.values(), *WORLDS.values()):
        assert set(values) <= set(FIELDS)


@pytest.mark.parametrize('algorithm', algorithms.names())
@pytest.mark.parametrize('population', [80, 20, 12, 7, 2])
def test_the_default_of_selected_suits_every_algorithm(algorithm, population):
    values = {'algorithm': algorithm, 'population': population, 'archive_lineages': 2}
    configuration = load_configuration(values)
    expected = {80: 10, 20: 5, 12: 3, 7: 7, 2: 1}[population]
    everyone = algorithm not in (
        'generalist_2025', 'hall_of_fame', 'random_opponents', 'simplified', 'standard'
    )  # fmt: skip
    assert configuration.selected == (population if everyone else expected)


def test_a_configuration_survives_json():
    configuration = load_configuration({'prey_speed': 9, 'phases': None, 'ticks': 10**9})
    assert load_configuration(json.loads(json.dumps(configuration.as_dict()))) == configuration
    assert isinstance(configuration.prey_speed, float)


def test_it_cannot_be_changed():
    with pytest.raises(dataclasses.FrozenInstanceError):
        Configuration().seed = 2


def test_differences_are_named():
    first, second = load_configuration({}), load_configuration({'seed': 7, 'mutation': 'exact'})
    assert differences(first, second) == ['seed: 1, 7', 'mutation: bernoulli, exact']
    assert differences(first, first) == []


@pytest.mark.parametrize(
    ('values', 'message'),
    [
        ({'sead': 1}, 'configuration key sead is unknown, expected some of algorithm, optimizer'),
        ({'a': 1, 'b': 2}, 'configuration keys a, b are unknown, expected'),
        ({'algorithm': 'best'}, "algorithm is 'best', expected one of .*standard, vanilla"),
        ({'optimizer': 'sgd'}, "optimizer is 'sgd', expected one of cma_es, "),
        ({'environment': 'maze'}, "environment is 'maze', expected one of open, obstacle"),
        ({'motor_map': None}, 'motor_map is None, expected one of signed, printed'),
        ({'world': 'flat'}, "world is 'flat', expected one of faithful, varied, robust"),
        ({'wall_contact': 'soft'}, "wall_contact is 'soft', expected one of rigid, "),
        ({'seed': -1}, 'seed is -1, expected a whole number from 0 to 4294967295'),
        ({'seed': 1.5}, 'seed is 1.5, expected a whole number from 0 to 4294967295'),
        ({'seed': True}, 'seed is True, expected a whole number'),
        ({'population': 1}, r'population is 1, expected .* from 2 to 1024 \(individuals\)'),
        ({'phases': 0}, r'phases is 0, expected a whole number from 1 to 4294967295 \(phases\)'),
        ({'phases': 10**20}, 'phases is 10+, expected a whole number from 1 to 4294967295'),
        ({'phases': 42_949_673}, 'expected at most 42949672 of 100 generations each'),
        ({'ticks': 2**63}, 'ticks is 9223372036854775808, expected a whole number from 1 to '),
        ({'mutation_rate': 1.1}, 'mutation_rate is 1.1, expected a number from 0 to 1'),
        ({'mutation_rate': float('nan')}, 'mutation_rate is nan, expected'),
        ({'mutation_rate': '0.1'}, "mutation_rate is '0.1', expected a number from 0 to 1"),
        ({'prey_speed': 31.0}, r'prey_speed is 31.0, .* above 0 and up to 30 \(rad/s\)'),
        ({'prey_speed': 0.0}, 'prey_speed is 0.0, expected a number above 0'),
        ({'wall_friction': float('inf')}, 'wall_friction is inf, expected'),
        ({'perturbed_robots': 'all'}, "perturbed_robots is 'all', expected one of both"),
        ({'selected': 81}, 'selected is 81, expected at most the population, 80'),
        ({'selected': 7}, 'population / selected is 80 / 7, expected a power of two'),
        ({'selected': 16}, 'population / selected is 80 / 16, expected a power of two'),
        (
            {'algorithm': 'vanilla', 'selected': 5},
            'selected is 5, expected the population, 10, in the algorithm vanilla',
        ),
        (
            {'replacement': 'evolved', 'agent_selection': 'repeated'},
            "agent_selection is 'repeated', expected distinct where replacement is evolved",
        ),
        ({'phases': None}, 'phases is None, expected a number where neither episodes nor ticks'),
        (
            {'episodes': 7000},
            'episodes is 7000, expected at least 7300, the cost of the first evaluation and one',
        ),
        ({'ticks': 7_200_000}, 'ticks is 7200000, expected at least 7300000, the cost'),
    ],
)
def test_a_wrong_value_is_named(values, message):
    with pytest.raises(ValueError, match=message) as caught:
        load_configuration(values)
    assert '\n' not in str(caught.value)


def test_an_unknown_preset_is_named():
    with pytest.raises(ValueError, match="preset is 'slow', expected one of quick, paper"):
        load_configuration({}, 'slow')


def test_equal_configurations_are_one_key():
    exact = load_configuration({'mutation': 'exact'})
    assert len({exact, load_configuration({'mutation': 'exact'}), load_configuration({})}) == 2
