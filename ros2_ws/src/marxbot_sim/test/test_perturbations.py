"""Imperfect robots: statistics of the noise, what it depends on, exact effects, bad input."""

import dataclasses
import math

import numpy as np
import pytest
from scipy import stats

from marxbot_sim.core.disturbance import PerturbedRobots
from marxbot_sim.core.parameters import BODY_RADIUS, OBSTACLE_RADIUS, START_POSES, Arena
from marxbot_sim.core.perturbations import Perturbations
from marxbot_sim.core.simulation import Simulation
from marxbot_sim.core.world import World

SPEEDS = (8.5, 10.0)
# As every distance: a float32 distance from the centre, less the radius.
NEAR = (np.float32(0.05) + np.float32(BODY_RADIUS)) - np.float32(BODY_RADIUS)
READINGS = np.concatenate([np.full(24, NEAR), np.full(8, 0.5), np.full(4, 0.4), [1.0]]).astype(
    np.float32
) * np.ones((2, 1), np.float32)
NOISY = Perturbations(
    infrared_noise=0.01, camera_noise=0.02, ground_noise=0.03, motor_noise=0.05, seed=3
)


def sensed(perturbations, ticks, episode=0, readings=READINGS):
    robots = PerturbedRobots(perturbations, SPEEDS)
    robots.begin((episode, episode))
    result = []
    for _ in range(ticks):
        result.append(robots.sense(readings))
        robots.drive([(5, 5), (5, 5)])
    return np.array(result)


def driven(perturbations, commands, episode=0):
    """Return how wheels turn and robots roll, (ticks, 2, 2) each, when both get the same
    commands."""
    robots = PerturbedRobots(perturbations, SPEEDS)
    robots.begin((episode, episode))
    pairs = [robots.drive([command, command]) for command in commands]
    return [np.array(part) for part in zip(*pairs, strict=True)]


def test_noise_is_normal_with_the_given_deviations_and_independent():
    noise = sensed(NOISY, 2000) - READINGS
    for sensors, deviation in ((slice(0, 24), 0.01), (slice(24, 32), 0.02), (slice(32, 36), 0.03)):
        part = noise[..., sensors].ravel().astype(float)
        error = deviation / math.sqrt(len(part))
        assert abs(part.mean()) < 4 * error
        assert part.std() == pytest.approx(deviation, rel=0.02)
        assert stats.kstest(part[:4000] / deviation, 'norm').pvalue > 1e-3
    assert (noise[..., 36] == 0).all()
    columns = noise[..., :36].reshape(2000, -1)
    correlation = np.corrcoef(columns, rowvar=False)
    np.fill_diagonal(correlation, 0)
    assert np.abs(correlation).max() < 5 / math.sqrt(2000)
    following = [np.corrcoef(c[:-1], c[1:])[0, 1] for c in columns.T]
    assert np.abs(following).max() < 5 / math.sqrt(2000)


def test_motor_noises_are_independent_by_wheel_robot_and_tick():
    drawn = []
    for seed in range(50):
        robots = PerturbedRobots(Perturbations(motor_noise=0.5, seed=seed), [10.0, 10.0])
        robots.begin()
        drawn.append([robots.drive(np.full((2, 2), 2.0))[1].ravel() for _ in range(200)])
    noises = np.array(drawn, float) - 2.0  # of 50 seeds, 200 ticks, 4 wheels
    error = 1 / np.sqrt(noises[..., 0].size)
    assert np.abs(noises.mean(axis=(0, 1))).max() < 5 * error
    assert np.abs((noises**2).mean(axis=(0, 1)) - 1).max() < 5 * np.sqrt(2) * error
    for values in (noises, (noises**2 - 1) / np.sqrt(2)):
        together = np.einsum('sti,stj->ij', values, values) * error**2
        np.fill_diagonal(together, 0)
        assert np.abs(together).max() < 5 * error
        for lag in (1, 2, 3):
            later = np.einsum('sti,stj->ij', values[:, lag:], values[:, :-lag]) * error**2
            assert np.abs(later).max() < 5 * error


def test_motor_noise_is_relative_and_differs_by_wheel():
    turning, rolling = driven(NOISY, [(10, -4)] * 4000)
    assert (turning == (10, -4)).all()  # what the encoders count
    factor = rolling / np.array([10, -4])
    assert factor.mean() == pytest.approx(1, abs=0.002)
    assert factor.std(axis=0) == pytest.approx(np.full((2, 2), 0.05), rel=0.05)
    assert abs(np.corrcoef(factor.reshape(4000, 4), rowvar=False)[0, 1:]).max() < 0.08


def test_noise_depends_on_seed_episode_and_robot_and_on_nothing_else():
    first = sensed(NOISY, 5, episode=7)
    np.testing.assert_array_equal(first, sensed(NOISY, 5, episode=7))
    assert (first[:, 0] != first[:, 1]).mean() > 0.9
    assert (first[:, :, :36] != sensed(NOISY, 5, episode=8)[:, :, :36]).mean() > 0.9
    other = dataclasses.replace(NOISY, seed=4)
    assert (first[:, :, :36] != sensed(other, 5, episode=7)[:, :, :36]).mean() > 0.9
    # common random numbers: the infrared noise is the same whatever else is disturbed
    less = Perturbations(infrared_noise=0.01, command_loss=0.5, seed=3)
    np.testing.assert_array_equal(first[..., :24], sensed(less, 5, episode=7)[..., :24])


def test_readings_stay_in_their_ranges_and_nothing_seen_stays_unseen():
    strong = Perturbations(infrared_noise=1.0, camera_noise=1.0, ground_noise=1.0)
    readings = READINGS.copy()
    readings[:, :12] = 0.115
    noisy = sensed(strong, 50, readings=readings)
    near = noisy[..., :24][noisy[..., :24] <= 0.1]
    radius = np.float32(BODY_RADIUS)
    assert ((near + radius) - radius == near).all()  # exact from the centre, as without noise
    assert (noisy[..., :12] == np.float32(0.115)).all()
    assert noisy[..., 12:24].min() == 0
    assert noisy[..., 12:24].max() > 0.1
    assert noisy[..., 24:36].min() == 0
    assert noisy[..., 24:36].max() == 1
    assert (noisy[..., 36] == 1).all()


@pytest.mark.parametrize('latency', [1, 3, 10])
def test_latency_delays_by_whole_ticks(latency):
    commands = [(i, -i) for i in range(1, 41)]
    turning, _ = driven(Perturbations(latency_ticks=latency), commands)
    expected = [(0, 0)] * latency + commands[:-latency]
    np.testing.assert_array_equal(turning[:, 0], expected)
    np.testing.assert_array_equal(turning[:, 1], expected)


def test_lost_commands_leave_the_one_before():
    commands = np.arange(1, 5001)[:, None] * [1, 1]
    turning, _ = driven(Perturbations(command_loss=0.2), commands)
    lost = turning[:, :, 0] != commands[:, :1]
    assert lost.mean() == pytest.approx(0.2, abs=0.02)
    held = np.maximum.accumulate(np.where(lost, 0, commands[:, :1]), axis=0)
    np.testing.assert_array_equal(turning[:, :, 0], held)
    always, _ = driven(Perturbations(command_loss=1.0), commands[:10])
    assert (always == 0).all()


def test_a_weak_battery_caps_each_wheel():
    turning, _ = driven(Perturbations(battery=0.8), [(10, 3), (-10, 7.5)])
    np.testing.assert_allclose(turning[:, 0], [(6.8, 3), (-6.8, 6.8)], rtol=1e-6)
    np.testing.assert_allclose(turning[:, 1], [(8, 3), (-8, 7.5)], rtol=1e-6)


def test_wheels_of_another_size_or_distance_move_as_geometry_says():
    larger = Perturbations(wheel_radius_scale=1.1, wheel_separation_scale=0.9)
    turning, rolling = driven(larger, [(6, 10)])
    np.testing.assert_array_equal(turning[0, 0], (6, 10))
    mean, spread = rolling[0, 0].mean(), np.diff(rolling[0, 0])[0]
    assert mean == pytest.approx(8 * 1.1, rel=1e-6)
    assert spread == pytest.approx(4 * 1.1 / 0.9, rel=1e-6)


def test_one_robot_alone_can_be_imperfect():
    own = dataclasses.replace(NOISY, robots='prey', start_displacement=0.2, latency_ticks=1)
    noisy = sensed(own, 3)
    np.testing.assert_array_equal(noisy[:, 0], np.broadcast_to(READINGS[0], (3, 37)))
    assert (noisy[:, 1] != READINGS[1]).mean() > 0.8
    starts = PerturbedRobots(own, SPEEDS).starts((2, 2))
    assert tuple(starts[0]) == START_POSES[0]
    assert tuple(starts[1]) != START_POSES[1]
    turning, _ = driven(own, [(5, 5)])
    assert (turning[0, 0] == 5).all()
    assert (turning[0, 1] == 0).all()


@pytest.mark.parametrize('distance', [1.0, 1.5, 2.0])
def test_starts_fill_a_disc_and_never_touch_anything(distance):
    widest = Perturbations(
        start_distance=distance, start_displacement=0.35, start_rotation=math.pi
    )
    robots = PerturbedRobots(widest, SPEEDS)
    world = World(Arena(obstacle=True))
    starts = np.array([robots.starts((episode, episode)) for episode in range(2000)])
    for poses in starts:
        world.reset(poses)
    away = starts - np.multiply(START_POSES, (distance, 1, 1))
    radius = np.hypot(away[..., 0], away[..., 1])
    assert radius.max() <= 0.35 + 1e-9
    assert (radius < 0.35 / math.sqrt(2)).mean() == pytest.approx(0.5, abs=0.03)
    assert np.abs(away[..., :2].mean(axis=0)).max() < 0.02
    assert stats.kstest(away[..., 2].ravel() / math.pi, stats.uniform(-1, 2).cdf).pvalue > 1e-3
    assert np.hypot(*starts[..., :2].T).min() > OBSTACLE_RADIUS + BODY_RADIUS
    assert np.abs(starts[..., :2]).max() < 1.5 - BODY_RADIUS


def test_both_robots_start_farther_apart_whoever_is_imperfect():
    far = Perturbations(start_distance=1.5, robots='prey')
    assert not far.active
    assert not far.random
    assert PerturbedRobots(far, SPEEDS).starts((4, 5)) == ((-0.75, 0, 0), (0.75, 0, math.pi))


def test_off_leaves_the_arrays_alone():
    for perfect in (Perturbations(seed=5, robots='prey'), Perturbations(start_displacement=0.1)):
        assert not perfect.active
    robots = PerturbedRobots(Perturbations(seed=5), SPEEDS)
    robots.begin((3, 3))
    assert robots.sense(READINGS) is READINGS
    assert robots.starts((3, 3)) == START_POSES
    turning, rolling = robots.drive([(1.5, 2), (3, 4)])
    assert turning is rolling
    np.testing.assert_array_equal(turning, [(1.5, 2), (3, 4)])


@pytest.mark.parametrize('physics', ['kinematic', 'pymunk'])
def test_the_simulation_perturbs_each_episode_anew_and_repeats_it(physics):
    imperfect = dataclasses.replace(NOISY, start_displacement=0.1, latency_ticks=1)

    def episodes():
        simulation = Simulation(physics=physics, perturbations=imperfect)
        result = []
        for _ in range(2):
            seen = [simulation.poses]
            for _ in range(5):
                simulation.step([(5, 5), (5, 4)])
                seen += [simulation.poses, simulation.readings, simulation.wheels]
            result.append(np.concatenate([part.ravel() for part in seen]))
            simulation.reset()
        return result

    first, again = episodes(), episodes()
    np.testing.assert_array_equal(first, again)
    assert (first[0] != first[1]).mean() > 0.3


@pytest.mark.parametrize(
    ('field', 'value'),
    [
        ('infrared_noise', -0.1),
        ('camera_noise', math.nan),
        ('ground_noise', '0.1'),
        ('motor_noise', math.inf),
        ('latency_ticks', 1.5),
        ('latency_ticks', 11),
        ('battery', 0.0),
        ('command_loss', 1.1),
        ('start_distance', 0.9),
        ('start_distance', 2.1),
        ('start_displacement', 0.4),
        ('start_rotation', 4.0),
        ('wheel_radius_scale', 0),
        ('wheel_separation_scale', True),
        ('robots', 'all'),
        ('seed', -1),
        ('seed', 0.0),
    ],
)
def test_a_wrong_value_is_named(field, value):
    with pytest.raises(ValueError, match=f'^{field} is .*, expected '):
        Perturbations(**{field: value})
