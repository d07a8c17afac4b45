"""Whole episodes of the compiled kernel against the reference: every tick, then every outcome."""

import numpy as np
import pytest
from reference import Model, arc, decide, gap, play, sense, slide, wheel_commands
from reference.controller import inputs, spent_energy, split, tiredness
from reference.samples import compared, envelope, outside

from coevo_manager.core.episodes import Environment, evaluate_pairs, measure_pairs, trace_pair

CONDITIONS = [
    (obstacle, motor_map) for obstacle in (False, True) for motor_map in ('printed', 'signed')
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


@pytest.mark.parametrize(('obstacle', 'motor_map'), CONDITIONS)
def test_every_tick_of_a_trajectory(obstacle, motor_map):
    """The reference, set to the kernel's state before each tick, does what the kernel did."""
    model = Model(obstacle, motor_map)
    environment = Environment(obstacle=obstacle, motor_map=motor_map)
    contacts = 0
    pairs = [*zip(*genomes(6, 1), strict=True), *zip(*evolved(environment), strict=True)]
    for pair in pairs:
        trace = trace_pair(*pair, environment)
        ticks = trace.ticks
        poses, before = trace.poses.astype(float), trace.poses[:-1].astype(float)
        wheels = trace.wheels.astype(float)
        assert trace.poses.shape == (ticks + 1, 2, 3)
        assert poses[0] == pytest.approx(START, abs=1e-6)

        displacement, turn = arc(before[..., 2], wheels)
        low, high = envelope(
            lambda xy: np.concatenate(
                [part.reshape(ticks, 2, -1) for part in slide(xy, displacement, 0.5, obstacle)],  # noqa: B023
                axis=-1,
            ),
            before[..., :2],
        )
        assert outside(poses[1:, :, :2], low[..., :2], high[..., :2]).max() < 1e-6
        change = poses[1:, :, 2] - before[..., 2] - turn
        assert np.abs(np.angle(np.exp(1j * change))).max() < 1e-6
        contact = trace.readings[..., 36]
        assert (contact[0] == 0).all()
        assert outside(contact[1:], low[:-1, :, 2], high[:-1, :, 2]).max() == 0

        low, high = envelope(lambda poses: compared(sense(poses, contact, obstacle)), before)  # noqa: B023
        assert outside(compared(trace.readings), low, high).max() < 1e-6

        clock = np.repeat(np.arange(ticks)[:, None] / 1000, 2, axis=1)
        tired = tiredness(windows(spent_energy(wheels, model.max_speed)))
        sensors = inputs(compared(trace.readings), clock, tired)
        assert np.abs(trace.inputs - sensors).max() < 5e-6

        hidden_before = np.concatenate([np.zeros((1, 2, 10)), trace.hidden[:-1]])
        genes = {name: values[None] for name, values in split(np.stack(pair)).items()}
        hidden, outputs = decide(genes, trace.inputs.astype(float), hidden_before.astype(float))
        assert np.abs(trace.hidden - hidden).max() < 5e-6
        assert np.abs(trace.outputs - outputs).max() < 1e-5

        expected = wheel_commands(trace.outputs.astype(float), tired, model.max_speed, motor_map)
        assert np.abs(wheels - expected).max() < 3 * 2.0**-16

        apart = gap(before[..., :2], poses[1:, :, :2])
        assert (apart[:-1] > -1e-6).all()
        assert apart[-1] < 1e-6 if trace.captured else apart[-1] > -1e-6
        assert trace.captured or ticks == 1000
        contacts += contact.sum()
    assert contacts >= 10


@pytest.mark.parametrize(('obstacle', 'motor_map'), CONDITIONS)
def test_outcomes_of_whole_episodes(obstacle, motor_map):
    """Capture ticks are equal, but where a displacement of 1e-6 m changes the reference's own.

    Recurrent networks can be chaotic; such pairs must be few.
    """
    n, tries = 100, 1
    predators, prey = genomes(n, 2)
    rng = np.random.default_rng(3)
    starts = START + np.concatenate(
        [np.zeros((1, n, 2, 3)), 1e-6 * rng.choice([-1, 1], (tries, n, 2, 3))]
    )
    every = np.tile(np.arange(n), tries + 1)
    ticks, complexity = play(
        predators[every], prey[every], Model(obstacle, motor_map), starts.reshape(-1, 2, 3)
    )
    ticks, complexity = ticks.reshape(-1, n), complexity.reshape(-1, n, 2)
    sensitive = (ticks != ticks[0]).any(axis=0)

    environment = Environment(obstacle=obstacle, motor_map=motor_map)
    pairs = np.arange(n)
    ours, our_complexity = measure_pairs(predators, prey, pairs, pairs, environment)

    assert (ours == ticks[0])[~sensitive].all()
    assert sensitive.mean() < 0.1
    assert 0.05 < (ours < 1000).mean() < 0.95
    error, swing = np.abs(our_complexity - complexity[0]), np.ptp(complexity, axis=0)
    assert np.median(error) < 1e-6
    # a robot that barely rests on a wall feels it or not by a rounding, in the midst of an episode
    assert (error < 1e-4 + 10 * swing).mean() > 0.97
