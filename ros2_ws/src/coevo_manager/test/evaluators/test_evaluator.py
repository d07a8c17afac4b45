"""The evaluator node in a process of its own, asked over its service."""

import array
import signal
import subprocess
import sys

import numpy as np
import pytest
from coevo_msgs.msg import Environment as EnvironmentMsg
from coevo_msgs.srv import EvaluateBatch, EvaluateLineages
from lineages import follow, random_lineages
from rclpy.qos import QoSProfile

from coevo_manager.core.episodes import Environment, evaluate_pairs, measure_pairs
from coevo_manager.evaluators.messages import (
    Requests,
    to_environment,
    to_environment_message,
    to_sequence,
)
from marxbot_sim.core.perturbations import Perturbations
from neuro_controller.core.genome import random_genomes

RNG = np.random.default_rng(3)
PREDATORS, PREY = random_genomes(5, RNG), random_genomes(7, RNG)
PREDATOR_INDEX, PREY_INDEX = np.indices((5, 7), np.uint32).reshape(2, -1)
SIGNED = Environment(obstacle=True, motor_map='signed', prey_speed=9.0, episode_ticks=300)


@pytest.fixture(scope='module')
def asker(starter, client):
    """``ask(*requests)`` -> responses, all requests under way at once, of a real evaluator."""
    process = starter(['coevo_manager', 'evaluator', '--ros-args', '-r', '__ns:=/evaluator_3'])
    clients = {
        kind.Request: client.node.create_client(
            kind, f'/evaluator_3/{name}', qos_profile=QoSProfile(depth=30)
        )
        for kind, name in (
            (EvaluateBatch, 'evaluate_batch'),
            (EvaluateLineages, 'evaluate_lineages'),
        )
    }
    client.until(lambda: all(c.service_is_ready() for c in clients.values()), 'the evaluator')
    for kind in clients:  # from then on it knows who asks
        client.answer(lambda kind=kind: clients[kind].call_async(kind()), 'the first answer')

    def begin(request):
        return clients[type(request)].call_async(request)

    def ask(*requests):
        futures = [begin(request) for request in requests]
        client.until(lambda: all(future.done() for future in futures), 'all answers')
        assert process.poll() is None, process.stderr_text
        return [future.result() for future in futures]

    ask.begin = begin
    return ask


def request(environment=None, complexity=False, rows=slice(None)):
    environment = environment or Environment()
    return EvaluateBatch.Request(
        predators=to_sequence(PREDATORS, 'f'),
        prey=to_sequence(PREY, 'f'),
        predator_index=to_sequence(PREDATOR_INDEX[rows], 'I'),
        prey_index=to_sequence(PREY_INDEX[rows], 'I'),
        environment=to_environment_message(environment),
        complexity=complexity,
    )


def test_answers_equal_the_core(asker):
    (response,) = asker(request())
    assert response.success, response.message
    expected = evaluate_pairs(PREDATORS, PREY, PREDATOR_INDEX, PREY_INDEX)
    assert list(response.capture_ticks) == expected.tolist()
    assert len(response.predator_complexity) == len(response.prey_complexity) == 0


def test_complexity_on_request(asker):
    (response,) = asker(request(SIGNED, complexity=True))
    ticks, complexity = measure_pairs(PREDATORS, PREY, PREDATOR_INDEX, PREY_INDEX, SIGNED)
    assert list(response.capture_ticks) == ticks.tolist()
    np.testing.assert_array_equal(response.predator_complexity, complexity[:, 0])
    np.testing.assert_array_equal(response.prey_complexity, complexity[:, 1])


def test_many_requests_at_once_in_several_environments(asker):
    environments = [Environment(episode_ticks=ticks) for ticks in range(40, 140, 10)] + [SIGNED]
    rows = [slice(0, k % 7 + 1) for k in range(22)]
    asked = [(environments[k % 11], rows[k]) for k in range(22)]
    responses = asker(*(request(environment, rows=row) for environment, row in asked))
    for (environment, row), response in zip(asked, responses, strict=True):
        expected = evaluate_pairs(
            PREDATORS, PREY, PREDATOR_INDEX[row], PREY_INDEX[row], environment
        )
        assert list(response.capture_ticks) == expected.tolist()


@pytest.mark.parametrize('species', ['predator', 'prey'])
def test_lineages_beside_batches(asker, species):
    lineages = [
        random_lineages(
            np.random.default_rng(seed), species, SIGNED, generations=15, count=1 + seed
        )
        for seed in range(3)
    ]
    message = to_environment_message(SIGNED)
    *answers, _ = asker(
        *(Requests(message).fill(lineage) for lineage in lineages), request(SIGNED)
    )
    for lineage, response in zip(lineages, answers, strict=True):
        assert response.success, response.message
        assert list(response.capture_ticks) == follow(lineage, SIGNED)[0].tolist()


def test_no_episodes_are_no_work(asker):
    (response,) = asker(EvaluateBatch.Request())
    assert response.success
    assert len(response.capture_ticks) == 0


LINEAGE = random_lineages(np.random.default_rng(6), 'prey', Environment(), generations=3)


def bad_lineage(name, value):
    asked = Requests(to_environment_message(Environment())).fill(LINEAGE)
    setattr(asked, name, value)
    return asked


def bad(name, value):
    asked = request()
    place = asked
    *path, last = name.split('.')
    for part in path:
        place = getattr(place, part)
    setattr(place, last, value)
    return asked


def genes(index, value):
    changed = PREDATORS.copy()
    changed[index] = value
    return to_sequence(changed, 'f')


@pytest.mark.parametrize(
    ('asked', 'sentence'),
    [
        (bad('predators', array.array('f', [0.0] * 441)), 'predators has 441 numbers'),
        (bad('predators', genes((1, 2), np.nan)), 'value nan as gene 2 of genome 1'),
        (bad('predators', genes((4, 441), 5.01)), '5.01'),
        (bad('predators', genes((0, 0), -np.inf)), '-inf as gene 0 of genome 0'),
        (bad('prey', array.array('f')), 'prey_index has the value 6'),
        (bad('prey_index', array.array('I', [7] * 35)), 'prey_index has the value 7'),
        (bad('predator_index', array.array('I', [0] * 34)), '35 entries, expected 34'),
        (bad('environment.motor_map', 'sideways'), "motor_map is 'sideways'"),
        (bad('environment.episode_ticks', 0), 'episode_ticks is 0'),
        (bad('environment.predator_speed', -1.0), 'predator_speed is -1.0'),
        (bad('environment.wall_friction', float('nan')), 'wall_friction is nan'),
        (bad('environment.physics', 'cartoon'), "physics is 'cartoon'"),
        (bad('environment.perturbations.motor_noise', 2.0), 'motor_noise is 2.0'),
        (bad_lineage('parents', array.array('f', [0.0] * 443)), 'parents has 443 numbers'),
        (bad_lineage('parents', array.array('f', [6.0] * 442)), 'value 6.0 as gene 0 of genome 0'),
        (bad_lineage('parents', array.array('f', [0.0] * 884)), '1 entries, expected 2 as par'),
        (bad_lineage('parents', array.array('f')), 'parents is empty'),
        (bad_lineage('parent_ticks', array.array('Q')), 'has 0 entries, expected 1 as parents'),
        (bad_lineage('opponents', array.array('f')), 'opponents is empty'),
        (bad_lineage('redrawn', array.array('I')), 'redrawn is empty'),
        (bad_lineage('redrawn', array.array('I', [2**32 - 1] * 2)), 'expected 8589934590 by'),
        (bad_lineage('genes', array.array('I', [442])), 'genes has the value 442'),
        (bad_lineage('values', array.array('f', [0.0])), 'values has 1 entries, expected'),
        (
            bad_lineage('values', array.array('f', [np.nan] * len(LINEAGE.values))),
            'values has the value nan',
        ),
    ],
)
def test_bad_requests_are_refused_and_the_node_goes_on(asker, asked, sentence):
    refused, served = asker(asked, request())
    assert not refused.success
    assert sentence in refused.message
    assert '\n' not in refused.message
    assert len(refused.capture_ticks) == 0
    assert served.success


def test_environments_survive_the_message():
    other = Environment(
        motor_map='printed',
        predator_speed=7.0,
        wall_friction=0.1,
        wall_contact='undo',
        infrared_response='linear',
        ground_coding='raw',
        physics='pymunk',
        repetitions=3,
        perturbations=Perturbations(latency_ticks=2, camera_noise=0.1, robots='prey', seed=9),
    )
    for environment in (Environment(), SIGNED, Environment(obstacle=True), other):
        assert to_environment(to_environment_message(environment)) == environment


def test_the_defaults_of_the_message_are_those_of_an_environment():
    assert to_environment(EnvironmentMsg()) == Environment()


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_cleanly(start, number):
    process = start(['coevo_manager', 'evaluator'])
    process.wait_for_output('ready on')
    process.send_signal(number)
    assert process.wait() == 0
    assert 'Traceback' not in process.stderr_text


def test_a_signal_in_the_moment_when_it_is_ready_ends_it_cleanly(ros_env):
    script = (
        'import os, signal, sys\n'
        'from coevo_manager.evaluators import evaluator\n'
        'class Hasty(evaluator.EvaluatorNode):\n'
        '    def __init__(self):\n'
        '        super().__init__()\n'
        '        os.kill(os.getpid(), signal.SIGTERM)\n'
        'evaluator.EvaluatorNode = Hasty\n'
        'sys.exit(evaluator.main([]))\n'
    )
    assert subprocess.run([sys.executable, '-c', script], env=ros_env).returncode == 0


def test_a_request_that_comes_again_is_played_once_and_answered_again(asker):
    """The second answer came from memory: the request under the number has other episodes."""
    asked = request()
    asked.number = 7
    (first,) = asker(asked)
    again, another = request(rows=slice(0, 3)), request(rows=slice(0, 3))
    again.number, another.number = 7, 8
    second, other = asker(again, another)
    assert (first.number, second.number, other.number) == (7, 7, 8)
    assert first.capture_ticks == second.capture_ticks
    assert other.capture_ticks == first.capture_ticks[:3]


def test_a_request_that_comes_again_while_it_is_played_is_answered_where_it_was_asked_last(asker):
    slow, again = request(), request()
    slow.number = again.number = 9
    asker.begin(slow)
    (answer,) = asker(again)
    assert answer.success and answer.number == 9


def test_bad_options(start):
    process = start(['coevo_manager', 'evaluator', '--parent', '1'])
    assert process.wait() == 2
