"""What a MarxBot senses: infrared, camera, ground, traction (paper A1, A2), for the 16 robots of a `Lanes`."""

import math

import numba
import numpy as np
from simd_lanes import (
    absolute,
    any_lane,
    arcsine,
    arctan2,
    fma,
    inverse_square_root,
    load,
    maximum,
    minimum,
    reciprocal,
    select,
    splat,
    square_root,
    store,
    swap_halves,
)

from .layout import CAMERA, CONTACT, COSINE, GROUND, HALF_SIZE, INFRARED, SINE, TOUCH, X, Y
from .parameters import BODY_RADIUS, CAMERA_SECTORS, GROUND_POSITIONS, INFRARED_RANGE, INFRARED_RAYS, OBSTACLE_RADIUS

_QUARTER = INFRARED_RAYS // 4
_RAY_ANGLES = np.radians(7.5 + 15.0 * np.arange(_QUARTER))
_RAY_COSINES = np.cos(_RAY_ANGLES).astype(np.float32)
_RAY_SINES = np.sin(_RAY_ANGLES).astype(np.float32)

_BLIND_DISTANCE = 0.2
_LEAST_INVERSE = 1.0 / _BLIND_DISTANCE
_NEAR = 0.201  # what is farther from a robot's centre than this cannot raise an inverse distance above the least
_NEAR_ROBOT_SQUARED = (_NEAR + BODY_RADIUS) ** 2
_NEAR_OBSTACLE_SQUARED = (_NEAR + OBSTACLE_RADIUS) ** 2

_SECTORS_PER_RADIAN = CAMERA_SECTORS / (2.0 * math.pi)
_SECTOR_MIDDLES = (np.arange(CAMERA_SECTORS) + 0.5).astype(np.float32)

_GROUND_X, _GROUND_Y = GROUND_POSITIONS[0]
_GROUND_RADIUS_SQUARED = _GROUND_X**2 + _GROUND_Y**2


@numba.njit(forceinline=True)
def _infrared_walls(readings, x, y, cosine, sine, half_size):
    """Set the inverse distance, 1/m, along each ray from the centre to the nearest wall.

    A ray whose direction has the component c toward a wall at distance D meets it after D/c. Inverse distances need
    no division by c, and where c is negative the wall drops out by itself in the maximum. Six directions and their
    quarter turns make the 24 rays; of two opposite walls only the near one can be in reach.
    """
    toward_x = reciprocal(half_size - absolute(x))
    toward_y = reciprocal(half_size - absolute(y))
    toward_x = select(x < 0.0, -toward_x, toward_x)
    toward_y = select(y < 0.0, -toward_y, toward_y)
    for i in range(_QUARTER):
        ray_x = fma(cosine, _RAY_COSINES[i], -(sine * _RAY_SINES[i]))
        ray_y = fma(sine, _RAY_COSINES[i], cosine * _RAY_SINES[i])
        along_x, along_y = ray_x * toward_x, ray_y * toward_y
        turned_x, turned_y = ray_y * toward_x, ray_x * toward_y
        store(readings, INFRARED + i, maximum(along_x, along_y))
        store(readings, INFRARED + i + _QUARTER, maximum(-turned_x, turned_y))
        store(readings, INFRARED + i + 2 * _QUARTER, -minimum(along_x, along_y))
        store(readings, INFRARED + i + 3 * _QUARTER, maximum(turned_x, -turned_y))


@numba.njit(forceinline=True)
def _infrared_disc(readings, forward, left, power):
    """Raise the inverse distance along each ray that meets a disc.

    With the disc's centre at (forward, left) in the body frame and the power p of the robot's centre to it (distance
    squared less radius squared), a ray with the component b toward the centre enters after b - sqrt(b^2 - p), the
    inverse of which is (b + sqrt(b^2 - p)) / p.
    """
    inverse_power = reciprocal(power)
    for i in range(_QUARTER):
        ahead = fma(forward, _RAY_COSINES[i], left * _RAY_SINES[i])
        aside = fma(left, _RAY_COSINES[i], -(forward * _RAY_SINES[i]))
        ahead_gap, aside_gap = fma(ahead, ahead, -power), fma(aside, aside, -power)
        ahead_root = select(ahead_gap < 0.0, -100.0, square_root(ahead_gap))
        aside_root = select(aside_gap < 0.0, -100.0, square_root(aside_gap))
        _raise(readings, INFRARED + i, (ahead_root + ahead) * inverse_power)
        _raise(readings, INFRARED + i + _QUARTER, (aside_root + aside) * inverse_power)
        _raise(readings, INFRARED + i + 2 * _QUARTER, (ahead_root - ahead) * inverse_power)
        _raise(readings, INFRARED + i + 3 * _QUARTER, (aside_root - aside) * inverse_power)


@numba.njit(forceinline=True)
def _raise(rows, row, value):
    store(rows, row, maximum(load(rows, row), value))


@numba.njit(forceinline=True)
def _share(bearing, half_width, middle):
    """Return which fraction of a camera sector is covered by an interval of bearings; the unit is one sector."""
    apart = absolute(bearing - middle)
    apart = minimum(apart, absolute(8.0 - apart))
    overlap = maximum(half_width + 0.5 - apart, 0.0)
    return minimum(overlap, minimum(half_width + half_width, 1.0))


@numba.njit(forceinline=True)
def _bearing(forward, left):
    """Return the direction of a point in the body frame in sectors counter-clockwise from the heading, 0..8."""
    angle = arctan2(left, forward) * _SECTORS_PER_RADIAN
    return select(angle < 0.0, angle + 8.0, angle)


@numba.njit(forceinline=True)
def _half_width(radius, distance_squared):
    """Return half the angle under which a disc is seen, in sectors."""
    return arcsine(inverse_square_root(distance_squared) * radius) * _SECTORS_PER_RADIAN


@numba.njit(forceinline=True)
def sense(bodies, arena, obstacle, readings):
    """Fill `readings` with what the 16 robots sense where they are.

    Parameters
    ----------
    bodies : float32 array, shape (BODY_ROWS, 16)
    arena : float32 array, shape (ARENA_ROWS, 16)
    obstacle : bool
        Whether the cylinder stands at the centre.
    readings : float32 array, shape (READING_ROWS, 16)
        Written.
    """
    x, y = load(bodies, X), load(bodies, Y)
    cosine, sine = load(bodies, COSINE), load(bodies, SINE)
    half_size = load(arena, HALF_SIZE)

    away_x, away_y = swap_halves(x) - x, swap_halves(y) - y
    forward = fma(away_x, cosine, away_y * sine)
    left = fma(away_y, cosine, -(away_x * sine))
    distance_squared = fma(away_x, away_x, away_y * away_y)
    power = distance_squared - BODY_RADIUS * BODY_RADIUS

    centre_forward = -fma(x, cosine, y * sine)
    centre_left = fma(x, sine, -(y * cosine))
    centre_squared = fma(x, x, y * y)
    obstacle_power = centre_squared - OBSTACLE_RADIUS * OBSTACLE_RADIUS

    near_wall = any_lane(maximum(absolute(x), absolute(y)) > half_size - _NEAR)
    near_robot = any_lane(distance_squared < _NEAR_ROBOT_SQUARED)
    near_obstacle = obstacle and any_lane(centre_squared < _NEAR_OBSTACLE_SQUARED)
    if near_wall or near_robot or near_obstacle:
        _infrared_walls(readings, x, y, cosine, sine, half_size)
        if near_robot:
            _infrared_disc(readings, forward, left, power)
        if near_obstacle:
            _infrared_disc(readings, centre_forward, centre_left, obstacle_power)
        for i in range(INFRARED_RAYS):
            inverse = maximum(load(readings, INFRARED + i), _LEAST_INVERSE)
            store(readings, INFRARED + i, reciprocal(inverse) - BODY_RADIUS)
    else:
        nothing = reciprocal(splat(_LEAST_INVERSE)) - BODY_RADIUS
        for i in range(INFRARED_RAYS):
            store(readings, INFRARED + i, nothing)

    bearing = _bearing(forward, left)
    half_width = _half_width(BODY_RADIUS, distance_squared)
    if obstacle:
        hiding = _half_width(OBSTACLE_RADIUS, centre_squared)
        offset = _bearing(centre_forward, centre_left) - bearing
        offset = select(offset > 4.0, offset - 8.0, select(offset < -4.0, offset + 8.0, offset))
        low = maximum(offset - hiding, -half_width)
        high = minimum(offset + hiding, half_width)
        hidden_width = select(obstacle_power < power, maximum((high - low) * 0.5, 0.0), 0.0)
        hidden_bearing = fma(high + low, 0.5, bearing)
        for i in range(CAMERA_SECTORS):
            seen = _share(bearing, half_width, _SECTOR_MIDDLES[i])
            hidden = _share(hidden_bearing, hidden_width, _SECTOR_MIDDLES[i])
            store(readings, CAMERA + i, maximum(seen - hidden, 0.0))
    else:
        for i in range(CAMERA_SECTORS):
            store(readings, CAMERA + i, _share(bearing, half_width, _SECTOR_MIDDLES[i]))

    _ground(readings, centre_forward, centre_left, centre_squared, half_size)
    store(readings, TOUCH, load(bodies, CONTACT))


@numba.njit(forceinline=True)
def _ground(readings, centre_forward, centre_left, centre_squared, half_size):
    """Set the darkness under the four ground sensors: distance from the centre over half the diagonal."""
    per_metre = reciprocal(half_size * math.sqrt(2.0))
    middle = centre_squared + _GROUND_RADIUS_SQUARED
    along, across = centre_forward * (-2.0 * _GROUND_X), centre_left * (-2.0 * _GROUND_Y)
    front, back = middle + along, middle - along
    store(readings, GROUND, square_root(front + across) * per_metre)
    store(readings, GROUND + 1, square_root(front - across) * per_metre)
    store(readings, GROUND + 2, square_root(back + across) * per_metre)
    store(readings, GROUND + 3, square_root(back - across) * per_metre)
