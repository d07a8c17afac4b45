"""Differential drive: between the speeds of a body and those of its wheels, and dead reckoning."""

import math

import numpy as np

from marxbot_sim.core.parameters import TICK, WHEEL_RADIUS, WHEEL_SEPARATION

COMMAND_GRID = 2.0**-16
"""Wheel speeds are rounded to multiples of this, rad/s: a command survives the way to a body's
speeds in float64 and back without loss."""


_ABSURD_SPEED = 1e100  # m/s or rad/s: what is faster overflows in float64 on its way to the wheels


def wheel_speeds(linear, angular, limit=math.inf):
    """Return the wheel speeds that move the body as asked.

    Both are slowed down alike where one exceeds the limit, so that the curve stays.

    Parameters
    ----------
    linear : float
        Forward speed, m/s.
    angular : float
        Turning speed, rad/s, counter-clockwise.
    limit : float
        Highest speed of a wheel, rad/s.

    Returns
    -------
    wheels : float32 array, shape (2,)
        Left and right wheel, rad/s.
    limited : bool
        Whether the limit was exceeded.

    Raises
    ------
    ValueError
        A speed is not finite.
    """
    if not (math.isfinite(linear) and math.isfinite(angular)):
        raise ValueError(f'speeds are {linear} m/s and {angular} rad/s, expected finite numbers')
    linear, angular = np.clip((linear, angular), -_ABSURD_SPEED, _ABSURD_SPEED)
    half_turn = angular * WHEEL_SEPARATION / 2
    wheels = np.array([linear - half_turn, linear + half_turn]) / WHEEL_RADIUS
    fastest = np.abs(wheels).max()
    limited = bool(fastest > limit + COMMAND_GRID)
    if limited:
        wheels = np.clip(wheels / (fastest / limit), -limit, limit)
    return (np.rint(wheels / COMMAND_GRID) * COMMAND_GRID).astype(np.float32), limited


def body_speeds(wheels):
    """Return the body's forward speed, m/s, and turning speed, rad/s, of its wheels', rad/s."""
    left, right = float(wheels[0]), float(wheels[1])
    return WHEEL_RADIUS * (left + right) / 2, WHEEL_RADIUS * (right - left) / WHEEL_SEPARATION


def dead_reckon(pose, wheels):
    """Return the pose after one tick along an exact arc, as wheel encoders see it.

    Contacts go unnoticed.

    Parameters
    ----------
    pose : tuple of float
        x and y in m, heading in rad.
    wheels : array_like, shape (2,)
        Left and right wheel, rad/s.
    """
    x, y, heading = pose
    linear, angular = body_speeds(wheels)
    turn = angular * TICK
    chord = linear * TICK * np.sinc(turn / (2 * math.pi))
    middle = heading + turn / 2
    return x + chord * math.cos(middle), y + chord * math.sin(middle), heading + turn
