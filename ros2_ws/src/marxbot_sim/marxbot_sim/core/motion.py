"""How MarxBots move, touch walls and each other, for the 16 robots of a `Lanes`."""

import numba

from marxbot_sim.core.layout import (
    CONTACT,
    COSINE,
    HALF_SIZE,
    LEFT,
    RIGHT,
    RIM_TURN,
    SINE,
    UNDO,
    WALL_FRICTION,
    X,
    Y,
)
from marxbot_sim.core.parameters import (
    BODY_RADIUS,
    CONTACT_DEPTH,
    MAX_RIM_TURN,
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
    kernel_part,
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
def _lost(displacement, cost):
    """Return the part of a displacement that friction takes: `cost`, but not more than all."""
    return copy_sign(minimum(cost, absolute(displacement)), displacement)


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


@kernel_part
def move(bodies, wheels, arena, obstacle):
    """Move the 16 robots by one tick, all at once.

    Each follows the exact arc of a differential drive. A wall or the obstacle stops it along the
    normal; the sliding that is left is shortened by Coulomb friction times the stopped part, and
    the robot turns toward facing what it presses against, or toward turning its back to it where
    it backs up, by `RIM_TURN` times what friction took (derived in docs/physics.md). Where `UNDO`
    is set, a robot that would end inside keeps its pose instead.

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

    wanted_x, wanted_y = fma(chord, middle_cosine, x0), fma(chord, middle_sine, y0)
    x1, y1 = _clamp(wanted_x, limit), _clamp(wanted_y, limit)
    stopped_x, stopped_y = absolute(wanted_x - x1), absolute(wanted_y - y1)
    stopped = maximum(stopped_x, stopped_y)
    contact = stopped > CONTACT_DEPTH
    at_wall = stopped > 0.0
    before = x0, y0, cosine, sine
    after = x1, y1, end_cosine * correction, end_sine * correction
    if any_lane(at_wall):
        held = _hold_at_walls(before, after, stopped_x, stopped_y, limit, chord, arena)
        after = _choose(at_wall, held, after)
    if obstacle:
        x1, y1 = after[0], after[1]
        centre_squared = fma(x1, x1, y1 * y1)
        inside = centre_squared < _OBSTACLE_CLEARANCE * _OBSTACLE_CLEARANCE
        if any_lane(inside):
            held = _hold_at_obstacle(before, after, centre_squared, chord, arena)
            after = _choose(inside, held, after)
            contact = contact | (centre_squared < _FELT_WITHIN * _FELT_WITHIN)

    x1, y1, cosine, sine = after
    store(bodies, X, x1)
    store(bodies, Y, y1)
    store(bodies, COSINE, cosine)
    store(bodies, SINE, sine)
    store(bodies, CONTACT, select(contact, splat(1.0), 0.0))
    return _touched(
        swap_halves(x0) - x0, swap_halves(y0) - y0, swap_halves(x1) - x1, swap_halves(y1) - y1
    )


@numba.njit(forceinline=True)
def _choose(mask, pose, other):
    """Return x, y, cosine and sine of the one pose where the mask is true, else of the other."""
    return (
        select(mask, pose[0], other[0]),
        select(mask, pose[1], other[1]),
        select(mask, pose[2], other[2]),
        select(mask, pose[3], other[3]),
    )


@numba.njit(forceinline=True)
def _turn(cosine, sine, toward, angle):
    """Return a heading turned by an angle, or as far as the normal where that is nearer.

    Parameters
    ----------
    cosine, sine : Lanes
        The heading.
    toward : Lanes
        Sine of the angle from the direction of drive to the normal; its sign is that of the turn.
    angle : Lanes
        rad, at least 0; at most `MAX_RIM_TURN` of it counts.
    """
    angle = minimum(angle, MAX_RIM_TURN)
    turn = copy_sign(minimum(angle * sine_over(angle), absolute(toward)), toward)
    stay = square_root(fma(-turn, turn, 1.0))
    return fma(cosine, stay, -(sine * turn)), fma(sine, stay, cosine * turn)


@numba.njit(forceinline=True)
def _hold_at_walls(before, after, stopped_x, stopped_y, limit, chord, arena):
    """Return the pose of a robot that walls stopped by so much along x and y."""
    x0, y0, _, _ = before
    x1, y1, cosine, sine = after
    friction, rim_turn = load(arena, WALL_FRICTION), load(arena, RIM_TURN)
    lost_x = _lost(x1 - x0, friction * stopped_y)
    lost_y = _lost(y1 - y0, friction * stopped_x)
    slid_x = _clamp(x0 + (x1 - x0 - lost_x), limit)
    slid_y = _clamp(y0 + (y1 - y0 - lost_y), limit)
    toward_x = copy_sign(1.0, x1 * chord) * -sine
    toward_y = copy_sign(1.0, y1 * chord) * cosine
    cosine, sine = _turn(cosine, sine, toward_x, rim_turn * absolute(lost_y))
    cosine, sine = _turn(cosine, sine, toward_y, rim_turn * absolute(lost_x))
    return _choose(load(arena, UNDO) > 0.0, before, (slid_x, slid_y, cosine, sine))


@numba.njit(forceinline=True)
def _hold_at_obstacle(before, after, centre_squared, chord, arena):
    """Return the pose of a robot that would end inside the obstacle."""
    x0, y0, _, _ = before
    x1, y1, cosine, sine = after
    distance = square_root(centre_squared)
    per_distance = 1.0 / distance
    normal_x, normal_y = x1 * per_distance, y1 * per_distance
    stopped = _OBSTACLE_CLEARANCE - distance
    held_x, held_y = normal_x * _OBSTACLE_CLEARANCE, normal_y * _OBSTACLE_CLEARANCE
    slide = fma(held_y - y0, normal_x, -((held_x - x0) * normal_y))
    lost = _lost(slide, load(arena, WALL_FRICTION) * stopped)
    slid_x, slid_y = fma(lost, normal_y, held_x), fma(-lost, normal_x, held_y)
    toward = copy_sign(1.0, chord) * fma(sine, normal_x, -(cosine * normal_y))
    cosine, sine = _turn(cosine, sine, toward, load(arena, RIM_TURN) * absolute(lost))
    return _choose(load(arena, UNDO) > 0.0, before, (slid_x, slid_y, cosine, sine))
