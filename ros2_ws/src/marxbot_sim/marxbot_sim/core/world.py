"""One arena with a predator and a prey, stepped from Python by the batch's own kernels."""

import math

import numpy as np

from marxbot_sensors import MARXBOT
from marxbot_sim.core.layout import (
    ARENA_ROWS,
    BODY_ROWS,
    COSINE,
    HALF_SIZE,
    RIM_TURN,
    SINE,
    UNDO,
    WALL_FRICTION,
    WHEEL_ROWS,
    X,
    Y,
)
from marxbot_sim.core.motion import move
from marxbot_sim.core.parameters import (
    BODY_RADIUS,
    OBSTACLE_RADIUS,
    RIM_TURN_PER_METRE,
    START_POSES,
    Arena,
)
from marxbot_sim.core.sensing import sense
from simd_lanes import HALF, aligned_rows, compile_kernel, lane_bits

PREDATOR, PREY = 0, 1
"""Indices of the two robots wherever an axis stands for them."""

ROBOT_LANES = (0, HALF)
"""The lanes of the two robots of episode 0."""


@compile_kernel
def _sense(robot, bodies, arena, obstacle, readings):
    sense(robot, bodies, arena, obstacle, readings)


@compile_kernel
def _move(bodies, wheels, arena, obstacle):
    return lane_bits(move(bodies, wheels, arena, obstacle))


def arena_rows(arena):
    """Return the arena's numbers as the kernels take them, float32 of shape (ARENA_ROWS, 16)."""
    rows = aligned_rows(ARENA_ROWS)
    rows[HALF_SIZE] = 0.5 * arena.size
    rows[WALL_FRICTION] = arena.wall_friction
    rows[RIM_TURN] = RIM_TURN_PER_METRE if arena.wall_contact == 'rigid' else 0.0
    rows[UNDO] = arena.wall_contact == 'undo'
    return rows


def start_bodies(poses=START_POSES):
    """Return bodies at rest, every episode of the batch starting alike.

    Parameters
    ----------
    poses : array_like, shape (2, 3)
        x and y in m and heading in rad, of predator and prey.

    Returns
    -------
    float32 array, shape (BODY_ROWS, 16)
    """
    bodies = aligned_rows(BODY_ROWS)
    for robot, (x, y, heading) in enumerate(poses):
        lanes = slice(robot * HALF, robot * HALF + HALF)
        bodies[X, lanes], bodies[Y, lanes] = x, y
        bodies[COSINE, lanes], bodies[SINE, lanes] = math.cos(heading), math.sin(heading)
    return bodies


def check_poses(poses, arena):
    """Return the poses as a float64 array of shape (2, 3), or raise ValueError in one sentence.

    Both robots must stand inside the arena, clear of the obstacle and of each other.
    """
    poses = np.asarray(poses, dtype=np.float64)
    if poses.shape != (2, 3) or not np.isfinite(poses).all():
        raise ValueError(f'poses are {poses.tolist()}, expected two finite triples x, y, heading')
    limit = 0.5 * arena.size - BODY_RADIUS
    for name, (x, y, _) in zip(('predator', 'prey'), poses, strict=True):
        if max(abs(x), abs(y)) > limit:
            raise ValueError(
                f'{name} position is ({x}, {y}), expected both within +-{limit} m of the centre'
            )
        if arena.obstacle and math.hypot(x, y) < OBSTACLE_RADIUS + BODY_RADIUS:
            raise ValueError(
                f'{name} position is ({x}, {y}), '
                f'expected at least {OBSTACLE_RADIUS + BODY_RADIUS} m from the obstacle'
            )
    distance = math.hypot(*(poses[1, :2] - poses[0, :2]))
    if distance <= 2 * BODY_RADIUS:
        raise ValueError(
            f'the robots are {distance} m apart, expected more than {2 * BODY_RADIUS} m'
        )
    return poses


class World:
    """One arena under kinematic physics.

    Parameters
    ----------
    arena : Arena
    robot : marxbot_sensors.Robot
        Whose sensors both robots have.
    """

    def __init__(self, arena=Arena(), robot=MARXBOT):
        self.arena = arena
        self._robot = robot
        self._arena = arena_rows(arena)
        self._wheels = aligned_rows(WHEEL_ROWS)
        self._readings = aligned_rows(robot.readings)
        self.reset()

    def reset(self, poses=START_POSES):
        """Place the robots at rest.

        Parameters
        ----------
        poses : array_like, shape (2, 3)
            x and y in m and heading in rad, of predator and prey.

        Raises
        ------
        ValueError
            If a robot would stand in a wall, the obstacle or the other robot.
        """
        self._bodies = start_bodies(check_poses(poses, self.arena))

    def step(self, wheel_speeds):
        """Move both robots by one tick.

        Parameters
        ----------
        wheel_speeds : array_like, shape (2, 2)
            Left and right wheel of predator and prey, rad/s.

        Returns
        -------
        bool
            Whether the bodies touched at any moment of the tick: the prey is captured.
        """
        self._wheels[:, ROBOT_LANES] = np.asarray(wheel_speeds, dtype=np.float32).T
        return bool(_move(self._bodies, self._wheels, self._arena, self.arena.obstacle) & 1)

    @property
    def readings(self):
        """What both robots sense now, float32 of shape (2, readings), see `layout`."""
        _sense(self._robot, self._bodies, self._arena, self.arena.obstacle, self._readings)
        return self._readings[:, ROBOT_LANES].T.copy()

    @property
    def bodies(self):
        """Float32 of shape (2, 5): x and y in m, cosine and sine of the heading, contact."""
        return self._bodies[:, ROBOT_LANES].T.copy()

    @property
    def poses(self):
        """Float32 of shape (2, 3): x and y in m, heading in rad."""
        bodies = self.bodies
        return np.column_stack(
            [bodies[:, X], bodies[:, Y], np.arctan2(bodies[:, SINE], bodies[:, COSINE])]
        )
