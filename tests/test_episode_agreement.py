"""Whole episodes of the compiled kernel against the reference: every tick, then every outcome."""

import numpy as np
import pytest
from reference import Model, decide, gap, play, press, sense, wheel_commands
from reference.controller import inputs, spent_energy, split, tiredness
from reference.samples import compared, envelope, outside

from coevo_manager.core.environment import make_environment
from coevo_manager.core.episodes import Environment, evaluate_pairs, measure_pairs, trace_pair
from coevo_manager.core.episodes.numbering import episode_numbers
from coevo_manager.core.worlds import WORLDS
from marxbot_sim.core.disturbance import PerturbedRobots
from marxbot_sim.core.world import World

PLAIN = {
    'motor_map': 'printed',
    'wall_contact': 'slide',
    'infrared_response': 'linear',
    'ground_coding': 'raw',
}
UNDO = {'wall_contact': 'undo', 'ground_coding': 'raw'}
CONDITIONS = [
    pytest.param({**fields, 'obstacle': obstacle}, id=f'{name}-{arena}')
    for name, fields in (('faithful', {}), ('plain', PLAIN), ('undo', UNDO))
    for arena, obstacle in (('open', False), ('obstacle', True))
]
START = np.array([(-0.5, 0, 0), (0.5, 0, np.pi)])


def genomes(n, seed):
    """Genomes of both species: a half all over the range, a half of small and smoother ones."""
    rng = np.random.default_rng(seed)
    both = rng.uniform(-5, 5, (2, n, 442))
    both[:, n // 2 :] *= rng.uniform(0.05, 0.5, (2, n - n // 2, 1))
    return both.astype(np.float32)


def evolved(environment, n=6, generations=60):
    """Genomes that have learnt to chase and to flee: nearer to walls and to each other."""
    rng = np.random.default_rng(4)
    species = list(rng.uniform(-5, 5, (2, n, 442)).astype(np.float32))
    agent, opponent = np.indices((n, n)).reshape(2, -1)
    for turn in range(2 * generations):
        evolving, other = species[turn % 2], species[1 - turn % 2]
        redrawn = rng.random(evolving.shape) < 0.02
        offspring = np.where(redrawn, rng.uniform(-5, 5, evolving.shape), evolving)
        both = np.concatenate([evolving, offspring.astype(np.float32)])
        agents, opponents = np.concatenate([agent, agent + n]), np.tile(opponent, 2)
        if turn % 2 == 0:
            lived = -evaluate_pairs(both, other, agents, opponents, environment)
        else:
            lived = evaluate_pairs(other, both, opponents, agents, environment)
        before, after = lived.reshape(2, n, n).mean(axis=2)
        species[turn % 2] = np.where((after >= before)[:, None], both[n:], evolving)
    return species


def windows(spent):
    """The 200 values before each tick, (ticks, 2, 200), zero before the start."""
    padded = np.concatenate([np.zeros((200, 2)), spent[:-1]])
    return np.lib.stride_tricks.sliding_window_view(padded, 200, axis=0)


def replayed(trace, pair, environment):
    """What robots would sense without noise, and how they roll, while they do what they did.

    Both arrays are as in the trace: (ticks, 2, 37) and (ticks, 2, 2). In a world without noise
    they are its readings and wheels.
    """
    opponents = episode_numbers(np.array(pair[::-1]))
    robots = PerturbedRobots(environment.perturbations, environment.max_wheel_speeds)
    world = World(environment.arena)
    world.reset(robots.starts(opponents))
    robots.begin(opponents)
    readings, rolling = [], []
    for noisy, wheels in zip(trace.readings, trace.wheels, strict=True):
        readings.append(world.readings)
        assert (robots.sense(readings[-1]) == noisy).all()
        rolling.append(robots.drive(wheels)[1])
        world.step(rolling[-1])
    return np.array(readings), np.array(rolling)


def compare_every_tick(pair, environment, model):
    """Set the reference to the kernel's state before each tick; return how often walls were felt.

    It must do what the kernel did, noise and starts given.
    """
    trace = trace_pair(*pair, environment)
    ticks = trace.ticks
    poses, before = trace.poses.astype(float), trace.poses[:-1].astype(float)
    wheels = trace.wheels.astype(float)
    readings, rolling = replayed(trace, pair, environment)
    assert trace.poses.shape == (ticks + 1, 2, 3)

    def moved(poses):
        after, contact = press(
            poses, rolling.astype(float), 0.5, model.obstacle, model.wall_contact
        )
        x, y, heading = np.moveaxis(after, -1, 0)
        return np.stack([x, y, np.cos(heading), np.sin(heading), contact], axis=-1)

    low, high = envelope(moved, before)
    x, y, heading = np.moveaxis(poses[1:], -1, 0)
    ours = np.stack([x, y, np.cos(heading), np.sin(heading)], axis=-1)
    error = outside(ours, low[..., :4], high[..., :4])
    assert error[..., :2].max() < 1e-6
    # a turn is 21 rad for each metre that friction took, which float32 knows to 1e-7 m
    assert error[..., 2:].max() < (5e-6 if model.wall_contact == 'rigid' else 1e-6)
    contact = readings[..., 36]
    assert (contact[0] == 0).all()
    assert outside(contact[1:], low[:-1, :, 4], high[:-1, :, 4]).max() == 0

    low, high = envelope(lambda poses: compared(sense(poses, contact, model.obstacle)), before)
    assert outside(compared(readings), low, high).max() < 1e-6

    clock = np.repeat(np.arange(ticks)[:, None] / 1000, 2, axis=1)
    tired = tiredness(windows(spent_energy(wheels, model.max_speed)))
    coding = model.infrared_response, model.ground_coding
    sensors = inputs(compared(trace.readings), clock, tired, *coding)
    assert np.abs(trace.inputs - sensors).max() < 5e-6

    hidden_before = np.concatenate([np.zeros((1, 2, 10)), trace.hidden[:-1]])
    genes = {name: values[None] for name, values in split(np.stack(pair)).items()}
    hidden, outputs = decide(genes, trace.inputs.astype(float), hidden_before.astype(float))
    assert np.abs(trace.hidden - hidden).max() < 5e-6
    assert np.abs(trace.outputs - outputs).max() < 1e-5

    outputs = trace.outputs.astype(float)
    expected = wheel_commands(outputs, tired, model.max_speed, model.motor_map)
    assert np.abs(wheels - expected).max() < 3 * 2.0**-16

    apart = gap(before[..., :2], poses[1:, :, :2])
    assert (apart[:-1] > -1e-6).all()
    assert apart[-1] < 1e-6 if trace.captured else apart[-1] > -1e-6
    assert trace.captured or ticks == 1000
    return contact.sum()


@pytest.mark.parametrize('fields', CONDITIONS)
def test_every_tick_of_a_trajectory(fields):
    environment = Environment(**fields)
    pairs = [*zip(*genomes(6, 1), strict=True), *zip(*evolved(environment), strict=True)]
    contacts = sum(compare_every_tick(pair, environment, Model(**fields)) for pair in pairs)
    assert contacts >= 10


@pytest.mark.parametrize('arena', ['open', 'obstacle'])
@pytest.mark.parametrize('world', WORLDS)
def test_every_tick_in_every_world(world, arena):
    environment = make_environment({**WORLDS[world], 'environment': arena})
    noisy = environment.perturbations.camera_noise > 0
    assert noisy == (world == 'robust')
    contacts = 0
    for pair in zip(*genomes(8, 5), strict=True):
        contacts += compare_every_tick(pair, environment, Model(arena == 'obstacle'))
    assert contacts >= 10


@pytest.mark.parametrize('fields', CONDITIONS)
def test_outcomes_of_whole_episodes(fields):
    """Capture ticks are equal, but where a displacement of 1e-6 m changes the reference's own.

    Recurrent networks can be chaotic; such pairs must be few.
    """
    n, tries = 60, 3
    predators, prey = genomes(n, 2)
    rng = np.random.default_rng(3)
    starts = START + np.concatenate(
        [np.zeros((1, n, 2, 3)), 1e-6 * rng.choice([-1, 1], (tries, n, 2, 3))]
    )
    every = np.tile(np.arange(n), tries + 1)
    ticks, complexity = play(
        predators[every], prey[every], Model(**fields), starts.reshape(-1, 2, 3)
    )
    ticks, complexity = ticks.reshape(-1, n), complexity.reshape(-1, n, 2)
    sensitive = (ticks != ticks[0]).any(axis=0)

    environment = Environment(**fields)
    pairs = np.arange(n)
    ours, our_complexity = measure_pairs(predators, prey, pairs, pairs, environment)

    assert (ours == ticks[0])[~sensitive].all()
    assert sensitive.mean() < 0.1
    assert 0.05 < (ours < 1000).mean() < 0.95
    error, swing = np.abs(our_complexity - complexity[0]), np.ptp(complexity, axis=0)
    assert np.median(error) < 1e-6
    # a robot that barely rests on a wall feels it or not by a rounding, in the midst of an episode
    assert (error < 1e-4 + 10 * swing).mean() > 0.97
