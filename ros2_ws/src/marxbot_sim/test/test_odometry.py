"""Dead reckoning: exact for a perfect robot, and as wrong as its covariance says for others."""

import numpy as np
import pytest

from marxbot_sim.core.layout import INFRARED
from marxbot_sim.core.odometry import Odometry
from marxbot_sim.core.parameters import BODY_RADIUS, INFRARED_RANGE, Arena
from marxbot_sim.core.perturbations import Perturbations
from marxbot_sim.core.simulation import Simulation
from marxbot_sim.core.world import World

WIDE = Arena(size=100.0)


def driven(noise, seed=0, ticks=100, start=(-1.0, 0.0, 0.0)):
    """A predator that drove a curve, and the error of its odometry in its own frame."""
    perturbations = Perturbations(motor_noise=noise, seed=seed)
    simulation = Simulation(WIDE, perturbations=perturbations)
    simulation.reset([start, (40.0, 40.0, 0.0)])
    for tick in range(ticks):
        simulation.step([(4.0 + 2.0 * np.sin(0.1 * tick), 5.0), (0.0, 0.0)])
    x, y, heading = simulation.odometry[0].pose
    true = simulation.poses[0] - np.array(start, np.float32)
    turn = (true[2] - heading + np.pi) % (2 * np.pi) - np.pi
    return simulation.odometry[0], np.array([true[0] - x, true[1] - y, turn])


def test_a_perfect_robot_knows_where_it_is():
    odometry, error = driven(0.0)
    assert np.abs(error).max() < 1e-4
    assert np.abs(odometry.covariance).max() == 0


def test_motor_noise_makes_it_drift_as_its_covariance_says():
    # The covariance is of first order. With a noise of 0.2 headings err by 0.33 rad, and the bent
    # way alone makes the mean of the squares below 4.0, as with NumPy's normal values.
    errors, covariances = [], []
    for seed in range(120):
        odometry, error = driven(0.05, seed)
        errors.append(error)
        covariances.append(odometry.covariance)
    errors, covariance = np.array(errors), np.mean(covariances, axis=0)
    assert np.abs(errors).max() > 0.01
    assert errors.std(axis=0) == pytest.approx(np.sqrt(np.diag(covariance)), rel=0.25)
    # The squares of the errors in units of the covariance: chi-squared, of mean 3.
    inverse = np.linalg.inv(covariance)
    squares = np.einsum('ni,ij,nj->n', errors, inverse, errors)
    assert squares.mean() == pytest.approx(3, rel=0.25)


def test_a_straight_way_by_hand():
    odometry = Odometry()
    odometry.advance((10.0, 10.0), 0.1, held=False)
    way, base = 0.027 * 10 * 0.1, 0.1265
    each = (0.1 * way) ** 2  # variance of each wheel's way
    assert odometry.pose == pytest.approx((way, 0, 0))
    turn = 2 * each / base**2
    expected = [
        [each / 2, 0, 0],
        [0, turn * way**2 / 4, turn * way / 2],
        [0, turn * way / 2, turn],
    ]
    assert odometry.covariance == pytest.approx(np.array(expected))


def test_what_holds_the_robot_makes_it_unsure():
    free, held = Odometry(), Odometry()
    free.advance((5.0, 5.0), 0.0, held=False)
    held.advance((5.0, 5.0), 0.0, held=True)
    assert free.covariance.max() == 0
    assert held.covariance[0, 0] == pytest.approx((0.027 * 5 * 0.1) ** 2 / 2)


def test_ranges_from_the_centre_give_the_distances_from_the_rim_exactly():
    rng, radius, seen = np.random.default_rng(3), np.float32(BODY_RADIUS), 0
    world = World()
    for _ in range(300):
        place = rng.uniform(-1.4149, 1.4149, 2)
        place[rng.integers(2)] = rng.choice([-1, 1]) * rng.uniform(1.32, 1.4149)
        world.reset([(*place, rng.uniform(-3, 3)), (0.0, 0.0, 0.0)])
        distances = world.readings[0, INFRARED : INFRARED + 24]
        distances = distances[distances <= INFRARED_RANGE]
        seen += distances.size
        assert ((distances + radius) - radius == distances).all()
    assert seen > 1000
