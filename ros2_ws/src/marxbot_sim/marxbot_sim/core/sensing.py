"""What 16 MarxBots sense: infrared, camera, ground, traction (paper A1, A2)."""

import math

import numba
import numpy as np

from marxbot_sim.core.further_sensing import sense_further
from marxbot_sim.core.layout import (
    CAMERA,
    CONTACT,
    COSINE,
    GROUND,
    HALF_SIZE,
    INFRARED,
    SINE,
    TOUCH,
    X,
    Y,
)
from marxbot_sim.core.parameters import (
    BODY_RADIUS,
    CAMERA_SECTORS,
    GROUND_POSITIONS,
    INFRARED_RAYS,
    OBSTACLE_RADIUS,
)
from simd_lanes import (
    absolute,
    any_lane,
    arcsine,
    arctan2,
    copy_sign,
    fma,
    kernel_part,
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

_QUARTER = INFRARED_RAYS // 4
_RAY_ANGLES = np.radians(7.5 + 15.0 * np.arange(_QUARTER))
_RAY_COSINES = np.cos(_RAY_ANGLES).astype(np.float32)
_RAY_SINES = np.sin(_RAY_ANGLES).astype(np.float32)

_BLIND_DISTANCE = 0.2
_LEAST_INVERSE = 1.0 / _BLIND_DISTANCE
_NEAR = 0.201  # nothing farther from a robot's centre raises an inverse distance above the least
_NEAR_ROBOT_SQUARED = (_NEAR + BODY_RADIUS) ** 2
_NEAR_OBSTACLE_SQUARED = (_NEAR + OBSTACLE_RADIUS) ** 2

_SECTORS_PER_RADIAN = CAMERA_SECTORS / (2.0 * math.pi)
_SECTOR_MIDDLES = (np.arange(CAMERA_SECTORS) + 0.5).astype(np.float32)

_GROUND_X, _GROUND_Y = GROUND_POSITIONS[0]
_GROUND_RADIUS_SQUARED = _GROUND_X**2 + _GROUND_Y**2


@numba.njit(forceinline=True)
def _meet_walls(i, cosine, sine, toward_x, toward_y):
    """Return the inverse distance to the nearest wall along rays i, i + 6, i + 12, i + 18, 1/m.

    Distances count from the robot's centre. A ray whose direction has the component c toward a
    wall at distance D meets it after D/c. Inverse distances c/D need no division by c, and where c
    is negative the wall drops out by itself in the maximum. Four rays are quarter turns of one
    direction; of two opposite walls only the near one can be in reach.
    """
    ray_x = fma(cosine, _RAY_COSINES[i], -(sine * _RAY_SINES[i]))
    ray_y = fma(sine, _RAY_COSINES[i], cosine * _RAY_SINES[i])
    along_x, along_y = ray_x * toward_x, ray_y * toward_y
    turned_x, turned_y = ray_y * toward_x, ray_x * toward_y
    return (
        maximum(along_x, along_y),
        maximum(-turned_x, turned_y),
        -minimum(along_x, along_y),
        maximum(turned_x, -turned_y),
    )


@numba.njit(forceinline=True)
def _meet_disc(i, rays, forward, left, power, inverse_power):
    """Raise the inverse distance along the ray of i, i + 6, i + 12, i + 18 that may meet a disc.

    With the disc's centre at (forward, left) in the body frame and the power p of the robot's
    centre to it (distance squared less radius squared), a ray with the component b toward the
    centre enters after b - sqrt(b^2 - p), the inverse of which is (b + sqrt(b^2 - p)) / p. A disc
    outside the body is seen under less than 90 degrees, so of four quarter turns only the one
    nearest to it, with the greatest b, can meet it; where that misses too, the root is NaN, which
    drops out in a maximum where it comes first.
    """
    ahead = fma(forward, _RAY_COSINES[i], left * _RAY_SINES[i])
    aside = fma(left, _RAY_COSINES[i], -(forward * _RAY_SINES[i]))
    toward = maximum(absolute(ahead), absolute(aside))
    inverse = (square_root(fma(toward, toward, -power)) + toward) * inverse_power
    return (
        select(ahead >= toward, maximum(inverse, rays[0]), rays[0]),
        select(aside >= toward, maximum(inverse, rays[1]), rays[1]),
        select(-ahead >= toward, maximum(inverse, rays[2]), rays[2]),
        select(-aside >= toward, maximum(inverse, rays[3]), rays[3]),
    )


@numba.njit(forceinline=True)
def _store_distance(readings, ray, inverse):
    # A division would wait for the divider, which roots and other divisions keep busy.
    store(readings, INFRARED + ray, reciprocal(maximum(inverse, _LEAST_INVERSE)) - BODY_RADIUS)


@numba.njit(forceinline=True)
def _meet(i, view, near_robot, robot, near_obstacle, cylinder):
    """Return the inverse distance along rays i, i + 6, i + 12, i + 18 to what they meet, 1/m.

    `view` has what `_meet_walls` takes beside the ray, `robot` and `cylinder` what `_meet_disc`
    does.
    """
    rays = _meet_walls(i, *view)
    if near_robot:
        rays = _meet_disc(i, rays, *robot)
    if near_obstacle:
        rays = _meet_disc(i, rays, *cylinder)
    return rays


@numba.njit(forceinline=True)
def _below(boundary, low, width):
    """Return how much of the interval [low, low + width] lies below a boundary."""
    return minimum(maximum(boundary - low, 0.0), width)


@numba.njit(forceinline=True)
def _view(forward, left, distance_squared, radius):
    """Return the interval of bearings under which a disc is seen: its start, 0..8, and its width.

    The unit is one camera sector, the origin the heading, the sense counter-clockwise.
    """
    middle = arctan2(left, forward) * _SECTORS_PER_RADIAN
    half_width = arcsine(radius / square_root(distance_squared)) * _SECTORS_PER_RADIAN
    low = middle - half_width
    return select(low < 0.0, low + 8.0, low), half_width + half_width


@numba.njit(forceinline=True)
def _camera(readings, low, width, hidden_low, hidden_width):
    """Set the eight sectors to their shares of an interval of bearings less a hidden part of it.

    An interval that starts below 8 ends below 10: what lies in sectors 8 and 9 belongs to 0 and 1.
    """
    before = splat(0.0)
    for boundary in range(1, CAMERA_SECTORS + 3):
        below = _below(float(boundary), low, width) - _below(
            float(boundary), hidden_low, hidden_width
        )
        share = below - before
        before = below
        if boundary <= CAMERA_SECTORS:
            store(readings, CAMERA + boundary - 1, maximum(share, 0.0))
        else:
            sector = CAMERA + boundary - 1 - CAMERA_SECTORS
            store(readings, sector, load(readings, sector) + maximum(share, 0.0))


@kernel_part
def sense(robot, bodies, arena, obstacle, readings):
    """Fill `readings` with what the 16 robots sense where they are.

    Parameters
    ----------
    robot : marxbot_sensors.Robot
    bodies : float32 array, shape (BODY_ROWS, 16)
    arena : float32 array, shape (ARENA_ROWS, 16)
    obstacle : bool
        Whether the cylinder stands at the centre.
    readings : float32 array, shape (robot.readings, 16)
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
        toward_x = copy_sign(1.0 / (half_size - absolute(x)), x)
        toward_y = copy_sign(1.0 / (half_size - absolute(y)), y)
        inverse_power = 1.0 / power
        inverse_obstacle_power = 1.0 / obstacle_power
        view = cosine, sine, toward_x, toward_y
        robot_seen = forward, left, power, inverse_power
        cylinder = centre_forward, centre_left, obstacle_power, inverse_obstacle_power
        # Written out: a loop that LLVM leaves rolled takes a tenth longer with AVX2.
        rays = (
            _meet(0, view, near_robot, robot_seen, near_obstacle, cylinder),
            _meet(1, view, near_robot, robot_seen, near_obstacle, cylinder),
            _meet(2, view, near_robot, robot_seen, near_obstacle, cylinder),
            _meet(3, view, near_robot, robot_seen, near_obstacle, cylinder),
            _meet(4, view, near_robot, robot_seen, near_obstacle, cylinder),
            _meet(5, view, near_robot, robot_seen, near_obstacle, cylinder),
        )
        for i in range(_QUARTER):
            for quarter in range(4):
                _store_distance(readings, i + quarter * _QUARTER, rays[i][quarter])
    else:
        for i in range(INFRARED_RAYS):
            _store_distance(readings, i, splat(0.0))

    low, width = _view(forward, left, distance_squared, BODY_RADIUS)
    if obstacle:
        hiding_low, hiding_width = _view(
            centre_forward, centre_left, centre_squared, OBSTACLE_RADIUS
        )
        ahead = hiding_low - low
        hiding_low = select(
            ahead > 4.0, hiding_low - 8.0, select(ahead < -4.0, hiding_low + 8.0, hiding_low)
        )
        hidden_low = maximum(hiding_low, low)
        hidden_width = maximum(minimum(hiding_low + hiding_width, low + width) - hidden_low, 0.0)
        hidden_width = select(obstacle_power < power, hidden_width, 0.0)
        _camera(readings, low, width, hidden_low, hidden_width)
    else:
        _camera(readings, low, width, low, splat(0.0))

    _ground(readings, centre_forward, centre_left, centre_squared, half_size)
    store(readings, TOUCH, load(bodies, CONTACT))
    sense_further(robot, bodies, arena, readings)


@numba.njit(forceinline=True)
def _ground(readings, centre_forward, centre_left, centre_squared, half_size):
    """Set the ground's darkness: distance from the centre over half the diagonal."""
    per_metre = 1.0 / (half_size * math.sqrt(2.0))
    middle = centre_squared + _GROUND_RADIUS_SQUARED
    along, across = centre_forward * (-2.0 * _GROUND_X), centre_left * (-2.0 * _GROUND_Y)
    front, back = middle + along, middle - along
    for i, squared in enumerate((front + across, front - across, back + across, back - across)):
        store(readings, GROUND + i, square_root(maximum(squared, 0.0)) * per_metre)
