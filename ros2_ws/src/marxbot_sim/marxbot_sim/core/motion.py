"""How MarxBots move, touch walls and each other, for the 16 robots of a `Lanes`."""

import numba

from marxbot_sim.core.layout import (
    CONTACT,
    COSINE,
    HALF_SIZE,
    LEFT,
    RIGHT,
    SINE,
    WALL_FRICTION,
    X,
    Y,
)
from marxbot_sim.core.parameters import (
    BODY_RADIUS,
    CONTACT_DEPTH,
    OBSTACLE_RADIUS,
    TICK,
    WHEEL_RADIUS,
    WHEEL_SEPARATION,
)
from simd_lanes import (
    absolute,
    any_lane,
    copy_sign,
    fma,
    load,
    maximum,
    minimum,
    select,
    sine_over,
    splat,
    square_root,
    store,
    swap_halves,
)
from simd_lanes import (
    cosine as cosine_of,
)

_METRES_PER_SPEED = 0.5 * WHEEL_RADIUS * TICK
_HALF_TURN_PER_SPEED = 0.5 * WHEEL_RADIUS / WHEEL_SEPARATION * TICK
_OBSTACLE_CLEARANCE = OBSTACLE_RADIUS + BODY_RADIUS
_FELT_WITHIN = _OBSTACLE_CLEARANCE - CONTACT_DEPTH
_TOUCH_SQUARED = (2.0 * BODY_RADIUS) ** 2


@numba.njit(forceinline=True)
def _shorten(displacement, cost):
    """Return the displacement, its length less `cost` but not below zero."""
    return copy_sign(maximum(absolute(displacement) - cost, 0.0), displacement)


@numba.njit(forceinline=True)
def _clamp(x, limit):
    return minimum(maximum(x, -limit), limit)


@numba.njit(forceinline=True)
def _touched(x0, y0, x1, y1):
    """Return where two bodies touched during the tick.

    The opponent moves, seen from the robot, from (x0, y0) to (x1, y1) along a straight line (each
    path is taken as its chord, at most 0.4 mm from the arc at full speed). They touched if the
    line's nearest point to the robot is within two radii: the end point, or the foot of the
    perpendicular where it lies between the two.
    """
    step_x, step_y = x1 - x0, y1 - y0
    length_squared = fma(step_x, step_x, step_y * step_y)
    approach = -fma(x0, step_x, y0 * step_y)
    start_gap = fma(x0, x0, fma(y0, y0, -_TOUCH_SQUARED))
    end_gap = fma(x1, x1, fma(y1, y1, -_TOUCH_SQUARED))
    passing = (approach > 0.0) & (approach < length_squared)
    return (end_gap <= 0.0) | (passing & (approach * approach >= start_gap * length_squared))


@numba.njit(forceinline=True)
def move(bodies, wheels, arena, obstacle):
    """Move the 16 robots by one tick, all at once.

    Each follows the exact arc of a differential drive. A wall or the obstacle stops it along the
    normal; the sliding that is left is shortened by Coulomb friction times the stopped part.
    Contact never turns a robot.

    Parameters
    ----------
    bodies : float32 array, shape (BODY_ROWS, 16)
        Moved.
    wheels : float32 array, shape (WHEEL_ROWS, 16)
    arena : float32 array, shape (ARENA_ROWS, 16)
    obstacle : bool
        Whether the cylinder stands at the centre.

    Returns
    -------
    Mask
        Where robot and opponent touched at any moment of the tick; the same in both halves.
    """
    x0, y0 = load(bodies, X), load(bodies, Y)
    cosine, sine = load(bodies, COSINE), load(bodies, SINE)
    left, right = load(wheels, LEFT), load(wheels, RIGHT)
    limit = load(arena, HALF_SIZE) - BODY_RADIUS
    friction = load(arena, WALL_FRICTION)

    half_turn = (right - left) * _HALF_TURN_PER_SPEED
    ratio, turn_cosine = sine_over(half_turn), cosine_of(half_turn)
    turn_sine = half_turn * ratio
    chord = (left + right) * (ratio * _METRES_PER_SPEED)
    middle_cosine = fma(cosine, turn_cosine, -(sine * turn_sine))
    middle_sine = fma(sine, turn_cosine, cosine * turn_sine)
    end_cosine = fma(middle_cosine, turn_cosine, -(middle_sine * turn_sine))
    end_sine = fma(middle_sine, turn_cosine, middle_cosine * turn_sine)
    norm_squared = fma(end_cosine, end_cosine, end_sine * end_sine)
    correction = fma(norm_squared, -0.5, 1.5)
    store(bodies, COSINE, end_cosine * correction)
    store(bodies, SINE, end_sine * correction)

    wanted_x, wanted_y = fma(chord, middle_cosine, x0), fma(chord, middle_sine, y0)
    x1, y1 = _clamp(wanted_x, limit), _clamp(wanted_y, limit)
    stopped_x, stopped_y = absolute(wanted_x - x1), absolute(wanted_y - y1)
    stopped = maximum(stopped_x, stopped_y)
    contact = stopped > CONTACT_DEPTH
    at_wall = stopped > 0.0
    if any_lane(at_wall):
        slid_x = _clamp(x0 + _shorten(x1 - x0, friction * stopped_y), limit)
        slid_y = _clamp(y0 + _shorten(y1 - y0, friction * stopped_x), limit)
        x1, y1 = select(at_wall, slid_x, x1), select(at_wall, slid_y, y1)
    if obstacle:
        centre_squared = fma(x1, x1, y1 * y1)
        inside = centre_squared < _OBSTACLE_CLEARANCE * _OBSTACLE_CLEARANCE
        if any_lane(inside):
            pushed_x, pushed_y = _push_out(x0, y0, x1, y1, centre_squared, friction)
            x1, y1 = select(inside, pushed_x, x1), select(inside, pushed_y, y1)
            contact = contact | (centre_squared < _FELT_WITHIN * _FELT_WITHIN)

    store(bodies, X, x1)
    store(bodies, Y, y1)
    store(bodies, CONTACT, select(contact, splat(1.0), 0.0))
    return _touched(
        swap_halves(x0) - x0, swap_halves(y0) - y0, swap_halves(x1) - x1, swap_halves(y1) - y1
    )


@numba.njit(forceinline=True)
def _push_out(x0, y0, x1, y1, centre_squared, friction):
    """Return where a robot that would end inside the obstacle is held by it."""
    distance = square_root(centre_squared)
    per_distance = 1.0 / distance
    normal_x, normal_y = x1 * per_distance, y1 * per_distance
    stopped = _OBSTACLE_CLEARANCE - distance
    held_x, held_y = normal_x * _OBSTACLE_CLEARANCE, normal_y * _OBSTACLE_CLEARANCE
    slide = fma(held_y - y0, normal_x, -((held_x - x0) * normal_y))
    lost = slide - _shorten(slide, friction * stopped)
    return fma(lost, normal_y, held_x), fma(-lost, normal_x, held_y)
