"""Episodes under rigid bodies and with imperfect robots: what their results may depend on."""

import dataclasses
import hashlib

import numpy as np
import pytest
import reference.disturbance
from scipy import stats

from coevo_manager.core.episodes import (
    Environment,
    EpisodeStream,
    evaluate_pairs,
    measure_pairs,
    trace_pair,
)
from coevo_manager.core.episodes.numbering import episode_numbers
from marxbot_sim.core.disturbance import PerturbedRobots
from marxbot_sim.core.parameters import START_POSES
from marxbot_sim.core.perturbations import Perturbations
from neuro_controller.core.genome import random_genomes

IMPERFECT = Perturbations(
    wheel_radius_scale=1.05,
    wheel_separation_scale=0.95,
    infrared_noise=0.005,
    camera_noise=0.05,
    ground_noise=0.02,
    motor_noise=0.05,
    latency_ticks=1,
    battery=0.9,
    command_loss=0.05,
    start_distance=1.3,
    start_displacement=0.3,
    start_rotation=3.0,
    seed=11,
)
ENVIRONMENTS = {
    'imperfect': Environment(perturbations=IMPERFECT, episode_ticks=400),
    'rigid': Environment(physics='pymunk', episode_ticks=150),
    'imperfect and rigid': Environment(
        physics='pymunk', perturbations=IMPERFECT, obstacle=True, episode_ticks=150
    ),
}
PLAIN = {
    'motor_map': 'printed',
    'wall_contact': 'slide',
    'infrared_response': 'linear',
    'ground_coding': 'raw',
}
N = 10
FIRST, SECOND = np.indices((N, N)).reshape(2, -1)


def populations(n=N, seed=544):
    """Return random genomes; of this seed many pairs come to a capture, in each environment."""
    rng = np.random.default_rng(seed)
    return random_genomes(n, rng), random_genomes(n, rng)


@pytest.fixture(scope='module', params=ENVIRONMENTS)
def results(request):
    environment = ENVIRONMENTS[request.param]
    predators, prey = populations()
    return (
        environment,
        predators,
        prey,
        *measure_pairs(predators, prey, FIRST, SECOND, environment),
    )


def test_neither_order_nor_company_nor_threads_matter(results):
    environment, predators, prey, ticks, complexity = results
    assert len(np.unique(ticks)) > 8
    rng = np.random.default_rng(1)
    for size, threads in ((100, 2), (37, 1), (1, 1)):
        order = rng.permutation(100)[:size]
        again = measure_pairs(predators, prey, FIRST[order], SECOND[order], environment, threads)
        np.testing.assert_array_equal(again[0], ticks[order])
        np.testing.assert_array_equal(again[1], complexity[order])
    np.testing.assert_array_equal(
        evaluate_pairs(predators, prey, FIRST, SECOND, environment), ticks
    )


def test_a_stream_equals_the_batch_however_requests_interleave(results):
    environment, predators, prey, ticks, _ = results
    rng = np.random.default_rng(2)
    rest = list(np.split(rng.permutation(100), [3, 30, 31, 70]))
    stream, seen = EpisodeStream(environment), 0
    while rest or stream.pending:
        if rest:
            part = rest.pop()
            stream.submit(part, predators, prey, FIRST[part], SECOND[part])
        for part, part_ticks, complexity in stream.advance():
            np.testing.assert_array_equal(part_ticks, ticks[part])
            assert not complexity.any()
            seen += len(part)
    assert seen == 100


def test_an_episode_stepped_from_python_is_the_same(results):
    environment, predators, prey, ticks, complexity = results
    for k in (*np.argsort(ticks, kind='stable')[:3], 55):
        trace = trace_pair(predators[FIRST[k]], prey[SECOND[k]], environment)
        assert trace.ticks == ticks[k]
        wheels = np.concatenate([np.zeros((1, 2, 2)), trace.wheels.astype(float)])
        changes = np.abs(np.diff(wheels.mean(axis=2), axis=0))
        changes += np.abs(np.diff((wheels[..., 1] - wheels[..., 0]) / 2, axis=0))
        np.testing.assert_allclose(
            changes.sum(axis=0) / (2 * trace.ticks), complexity[k], rtol=1e-4
        )


def test_perfect_robots_play_as_if_perturbations_did_not_exist():
    """A change of the kernel on purpose changes these hashes; nothing else may."""
    predators, prey = populations(24, seed=0)
    i, j = np.indices((24, 24)).reshape(2, -1)
    for environment, known in (
        (Environment(**PLAIN), '62e87ed1918c86f0'),
        (Environment(), '234a385fc6226957'),
        (Environment(obstacle=True), '734680c4349eec32'),
        (Environment(obstacle=True, wall_contact='undo'), '7482d328ec7f3d8e'),
    ):
        seeded = dataclasses.replace(environment, perturbations=Perturbations(seed=7))
        ticks, complexity = measure_pairs(predators, prey, i, j, seeded)
        content = ticks.astype('<i4').tobytes() + complexity.astype('<f4').tobytes()
        assert hashlib.sha256(content).hexdigest()[:16] == known


def test_each_imperfection_alone_changes_episodes():
    predators, prey = populations()
    perfect = measure_pairs(predators, prey, FIRST, SECOND, Environment(episode_ticks=200))[1]
    for field in dataclasses.fields(Perturbations):
        if field.name in ('robots', 'seed'):
            continue
        alone = Perturbations(**{field.name: getattr(IMPERFECT, field.name)})
        environment = Environment(episode_ticks=200, perturbations=alone)
        complexity = measure_pairs(predators, prey, FIRST, SECOND, environment)[1]
        assert (complexity != perfect).mean() > 0.05, field.name


def test_robots_start_elsewhere_against_each_opponent_and_alike_against_the_same():
    environment = Environment(
        perturbations=Perturbations(start_displacement=0.3, start_rotation=1.0), episode_ticks=2
    )
    predators, prey = populations(3)

    def start(i, j):
        return trace_pair(predators[i], prey[j], environment).poses[0]

    np.testing.assert_array_equal(start(0, 0)[0], start(1, 0)[0])
    np.testing.assert_array_equal(start(0, 0)[1], start(0, 1)[1])
    assert (start(0, 0)[0] != start(0, 1)[0]).all()
    assert (start(0, 0)[1] != start(1, 0)[1]).all()
    assert (start(0, 0) != np.array(START_POSES, np.float32)).all()
    reseeded = dataclasses.replace(environment.perturbations, seed=1)
    environment = dataclasses.replace(environment, perturbations=reseeded)
    assert (trace_pair(predators[0], prey[0], environment).poses[0] != start(1, 1)).all()


@pytest.mark.parametrize('robots', ['both', 'predator', 'prey'])
def test_imperfect_robots_are_those_of_the_reference(robots):
    """Tick by tick, in float64 and from other code: starts, noise, losses, latency, battery."""
    some = dataclasses.replace(IMPERFECT, robots=robots, latency_ticks=2, command_loss=0.3)
    others = Perturbations(start_distance=some.start_distance)
    speeds, opponents, rng = (8.5, 10.0), (2**63 + 5, 17), np.random.default_rng(4)
    robots_here = PerturbedRobots(some, speeds)
    robots_here.begin(opponents)
    references = [
        reference.disturbance.Robot(some if some.affects(i) else others, i, speeds[i], number)
        for i, number in enumerate(opponents)
    ]
    np.testing.assert_allclose(
        robots_here.starts(opponents), [each.start() for each in references], atol=1e-12
    )
    for _ in range(60):
        readings = rng.uniform(0, [0.115] * 24 + [1] * 13, (2, 37)).astype(np.float32)
        commands = rng.uniform(-10, 10, (2, 2)).astype(np.float32)
        expected = [each.sense(row) for each, row in zip(references, readings, strict=True)]
        np.testing.assert_allclose(robots_here.sense(readings), expected, atol=2e-6)
        driven = [each.drive(row) for each, row in zip(references, commands, strict=True)]
        for part, theirs in zip(
            robots_here.drive(commands), zip(*driven, strict=True), strict=True
        ):
            np.testing.assert_allclose(part, theirs, atol=2e-5)


def test_episode_numbers_differ_wherever_genomes_do():
    genomes = np.repeat(populations(1)[0], 443, axis=0)
    genomes[np.arange(442), np.arange(442)] += np.float32(0.001)
    assert len(np.unique(episode_numbers(genomes))) == 443
    np.testing.assert_array_equal(episode_numbers(genomes[5:7]), episode_numbers(genomes)[5:7])


def test_rigid_bodies_judge_robots_much_as_the_kernel_does():
    predators, prey = populations(16, seed=3)
    i, j = np.indices((16, 16)).reshape(2, -1)
    ticks = [
        evaluate_pairs(predators, prey, i, j, Environment(physics=physics, episode_ticks=200))
        for physics in ('kinematic', 'pymunk')
    ]
    assert stats.spearmanr(*ticks).statistic > 0.8
    assert (ticks[0] != ticks[1]).any()


@pytest.mark.parametrize(
    ('field', 'value'), [('physics', 'newton'), ('physics', None), ('perturbations', {'seed': 1})]
)
def test_a_wrong_environment_is_named(field, value):
    with pytest.raises(ValueError, match=f'^{field} is .*, expected '):
        Environment(**{field: value})


@pytest.mark.parametrize('physics', ['kinematic', 'pymunk'])
def test_the_episodes_of_a_pair_are_summed_and_each_has_its_own_start(physics):
    predators, prey = populations(3, seed=4)
    perturbations = Perturbations(start_displacement=0.3, start_rotation=3.0, camera_noise=0.05)
    environment = Environment(
        physics=physics, episode_ticks=150, perturbations=perturbations, repetitions=4
    )
    once = dataclasses.replace(environment, repetitions=1)
    i, j = np.arange(3), np.arange(3)
    traces = [
        [trace_pair(predators[k], prey[k], once, repetition) for repetition in range(4)]
        for k in range(3)
    ]
    ticks = np.array([[trace.ticks for trace in pair] for pair in traces])
    assert len({trace.poses[0].tobytes() for trace in traces[0]}) == 4
    summed, complexity = measure_pairs(predators, prey, i, j, environment)
    np.testing.assert_array_equal(summed, ticks.sum(axis=1))
    single, own = measure_pairs(predators, prey, i, j, once)
    np.testing.assert_array_equal(single, ticks[:, 0])
    assert (complexity != own).any()
