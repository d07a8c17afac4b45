"""Where robots start; a perturbed start is drawn anew for each episode."""

import math

import numba
import numpy as np

from marxbot_sim.core.layout import CONTACT, COSINE, SINE, X, Y
from marxbot_sim.core.parameters import START_DISTANCE, START_POSES
from marxbot_sim.core.perturbations import PERFECT
from marxbot_sim.core.randomness import random_bits, uniform
from simd_lanes import HALF, compile_kernel

_X, _Y, _HEADING, _DISPLACEMENT, _ROTATION = range(5)
_NOISE, _PLACE, _TURN = range(3)  # the numbers of an episode


def make_starts(perturbations):
    """Return where robots start and how far their starts are perturbed at most.

    Returns
    -------
    float64 array, shape (2, 5)
        Of predator and prey x and y, m, heading, rad, greatest displacement, m, and turn, rad.
    """
    starts = np.empty((2, 5))
    for robot, (x, y, heading) in enumerate(START_POSES):
        own = perturbations if perturbations.affects(robot) else PERFECT
        x *= perturbations.start_distance / START_DISTANCE
        starts[robot] = x, y, heading, own.start_displacement, own.start_rotation
    return starts


@numba.njit
def _robot_key(seed, episode, robot):
    return random_bits(random_bits(np.uint64(seed), episode), robot)


@numba.njit
def episode_key(seed, episode, robot):
    """Return the key, uint64, of what a robot, 0 or 1, draws in the ticks of an episode."""
    return random_bits(_robot_key(seed, episode, robot), _NOISE)


@compile_kernel
def start_pose(starts, robot, seed, episode):
    """Return where that episode starts for a robot, 0 or 1: x and y in m, heading in rad."""
    key = _robot_key(seed, episode, robot)
    place, turn = random_bits(key, _PLACE), random_bits(key, _TURN)
    radius = starts[robot, _DISPLACEMENT] * math.sqrt(uniform(place))
    direction = 2.0 * math.pi * uniform(place << np.uint64(24))
    rotation = starts[robot, _ROTATION] * (2.0 * uniform(turn) - 1.0)
    return (
        starts[robot, _X] + radius * math.cos(direction),
        starts[robot, _Y] + radius * math.sin(direction),
        starts[robot, _HEADING] + rotation,
    )


@numba.njit
def place(starts, lane, seed, episode, bodies):
    """Put the robot of a lane where that episode starts, at rest."""
    x, y, heading = start_pose(starts, lane // HALF, seed, episode)
    bodies[X, lane], bodies[Y, lane], bodies[CONTACT, lane] = x, y, 0.0
    bodies[COSINE, lane], bodies[SINE, lane] = math.cos(heading), math.sin(heading)
