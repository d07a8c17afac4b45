"""The arena under rigid-body physics: Chipmunk 2D through pymunk, a witness of `motion`.

A MarxBot is a rigid disc on two wheels that turn as they are told. In each sub-step each tyre
pushes its part of the body toward rolling without slip, as hard as its friction on the floor
allows, in whatever direction; Chipmunk does the rest: collisions, friction at walls, obstacle and
the other robot. What the robots sense is computed by the same kernel as under kinematic physics.
"""

import math

import numpy as np
import pymunk
from pymunk import batch

from marxbot_sensors import MARXBOT
from marxbot_sim.core.layout import BODY_ROWS, CONTACT, COSINE, LEFT, RIGHT, SINE, WHEEL_ROWS, X, Y
from marxbot_sim.core.parameters import (
    BODY_RADIUS,
    OBSTACLE_RADIUS,
    START_POSES,
    TICK,
    WHEEL_RADIUS,
    WHEEL_SEPARATION,
    Arena,
)
from marxbot_sim.core.world import ROBOT_LANES, World, check_poses
from simd_lanes import HALF, LANES, aligned_rows, compile_kernel

MASS = 1.8
"""Mass of a MarxBot, kg (Bonani et al. 2010; ARGoS takes 1.6 kg)."""

INERTIA = 0.5 * MASS * BODY_RADIUS**2
"""Moment of inertia about the vertical axis, kg m^2: that of a uniform disc (assumed)."""

WHEEL_FRICTION = 0.7
"""Coulomb coefficient of the wheels on the floor (assumed: rubber on a hard floor). Each tyre
bears half of the weight and pushes with at most 0.7 * 0.9 kg * 9.81 m/s^2 = 6.2 N in any
direction."""

RESTITUTION = 0.4
"""Share of the speed of approach that bodies and what they hit keep, as in FARSA, where
`wall_contact` is 'rigid'; 0 otherwise."""

BODY_FRICTION = 0.7
"""Friction factor of the bodies (as in ARGoS). Chipmunk multiplies the factors of what touches:
0.49 between two robots; walls and obstacle have the factor that makes it the arena's
`wall_friction`."""

CONTACT_THRESHOLD = 0.5
"""Force on the body, N, mean over a tick, from which the traction sensor reports a contact."""

SUBSTEPS = 20
"""Steps of the physics in a tick: 5 ms each, in which a robot at full speed goes 1.35 mm."""

SLOP = 0.0002
"""Overlap, m, that Chipmunk leaves between bodies in lasting contact."""

_STEP = TICK / SUBSTEPS
_GRAVITY = 9.81
_TYRE_GRIP = 0.5 * WHEEL_FRICTION * MASS * _GRAVITY * _STEP  # of an impulse in a sub-step, N s
_TOUCH_SQUARED = (2 * BODY_RADIUS) ** 2
_OVERLAP_KEPT = 0.7**SUBSTEPS  # of an overlap, after a tick
_WALL_THICKNESS = 0.2
_ROBOTS, _FIXTURES = 1, 2  # collision categories
_SPARE = 8  # pymunk asks for more memory when a buffer is nearly full, and this one is not its own

_STATE = (
    batch.BodyFields.POSITION
    | batch.BodyFields.ANGLE
    | batch.BodyFields.VELOCITY
    | batch.BodyFields.ANGULAR_VELOCITY
)
_FORCE = batch.BodyFields.FORCE | batch.BodyFields.TORQUE


@compile_kernel
def _grip(ahead, aside):
    """Return as much of an impulse on a tyre, N s, as the floor gives: its traction circle."""
    size = math.hypot(ahead, aside)
    share = _TYRE_GRIP / size if size > _TYRE_GRIP else 1.0
    return share * ahead, share * aside


@compile_kernel
def _drive(state, wheels, contacts, forces):
    """Set the force and torque of the wheels on each body during the coming sub-step.

    They are what rolling without slip takes, against the contacts of the last sub-step too, as far
    as the floor gives it to each tyre. Chipmunk moves a body with its old velocity and then
    changes the velocity; the new one is therefore aimed along the heading in the middle of the
    sub-step after this one.
    """
    for body in range(len(state)):
        turning = state[body, 5]
        block, pair = divmod(body // 2, HALF)
        lane = pair + HALF * (body % 2)
        left = WHEEL_RADIUS * float(wheels[block, LEFT, lane])
        right = WHEEL_RADIUS * float(wheels[block, RIGHT, lane])
        wanted_turning = (right - left) / WHEEL_SEPARATION
        heading = state[body, 2] + (turning + 0.5 * wanted_turning) * _STEP
        speed = 0.5 * (left + right)

        push_x = MASS * (speed * math.cos(heading) - state[body, 3]) - contacts[body, 0]
        push_y = MASS * (speed * math.sin(heading) - state[body, 4]) - contacts[body, 1]
        twist = INERTIA * (wanted_turning - turning) - contacts[body, 2]
        cosine, sine = math.cos(heading), math.sin(heading)
        ahead = 0.5 * (push_x * cosine + push_y * sine)
        aside = 0.5 * (push_y * cosine - push_x * sine)
        left_ahead, left_aside = _grip(ahead - twist / WHEEL_SEPARATION, aside)
        right_ahead, right_aside = _grip(ahead + twist / WHEEL_SEPARATION, aside)
        ahead, aside = left_ahead + right_ahead, left_aside + right_aside
        forces[body, 0] = (ahead * cosine - aside * sine) / _STEP
        forces[body, 1] = (ahead * sine + aside * cosine) / _STEP
        forces[body, 2] = 0.5 * WHEEL_SEPARATION * (right_ahead - left_ahead) / _STEP


@compile_kernel
def _account(before, after, forces, contacts, impulses, captured):
    """Find what contacts did in a sub-step, and note which robots touched during it.

    What changed a body's momentum, and was not its wheels, was a contact.
    """
    for body in range(len(after)):
        contacts[body, 0] = MASS * (after[body, 3] - before[body, 3]) - forces[body, 0] * _STEP
        contacts[body, 1] = MASS * (after[body, 4] - before[body, 4]) - forces[body, 1] * _STEP
        contacts[body, 2] = INERTIA * (after[body, 5] - before[body, 5]) - forces[body, 2] * _STEP
        impulses[body, 0] += contacts[body, 0]
        impulses[body, 1] += contacts[body, 1]
    for arena in range(len(captured)):
        predator, prey = 2 * arena, 2 * arena + 1
        x0, y0 = before[prey, 0] - before[predator, 0], before[prey, 1] - before[predator, 1]
        x1, y1 = after[prey, 0] - after[predator, 0], after[prey, 1] - after[predator, 1]
        step_x, step_y = x1 - x0, y1 - y0
        length_squared = step_x * step_x + step_y * step_y
        share = 1.0
        if length_squared > 0.0:
            share = min(max(-(x0 * step_x + y0 * step_y) / length_squared, 0.0), 1.0)
        near_x, near_y = x0 + share * step_x, y0 + share * step_y
        if near_x * near_x + near_y * near_y <= _TOUCH_SQUARED:
            captured[arena] = True


@compile_kernel
def _report(state, impulses, limit, obstacle, bodies):
    """Write poses and contacts to the lanes; what overlaps is reported where it touches."""
    for body in range(len(state)):
        block, pair = divmod(body // 2, HALF)
        lane = pair + HALF * (body % 2)
        x = min(max(state[body, 0], -limit), limit)
        y = min(max(state[body, 1], -limit), limit)
        distance = math.hypot(x, y)
        if obstacle and distance < OBSTACLE_RADIUS + BODY_RADIUS:
            x *= (OBSTACLE_RADIUS + BODY_RADIUS) / distance
            y *= (OBSTACLE_RADIUS + BODY_RADIUS) / distance
        bodies[block, X, lane], bodies[block, Y, lane] = x, y
        bodies[block, COSINE, lane] = math.cos(state[body, 2])
        bodies[block, SINE, lane] = math.sin(state[body, 2])
        force = math.hypot(impulses[body, 0], impulses[body, 1]) / TICK
        bodies[block, CONTACT, lane] = 1.0 if force > CONTACT_THRESHOLD else 0.0


class PymunkArenas:
    """Many equal arenas, with a predator and a prey in each, in one pymunk space.

    The arenas lie on top of each other and share walls and obstacle, so what happens in one is the
    same, bit for bit, whatever the others do.

    Parameters
    ----------
    arena : Arena
    count : int
        Number of arenas.
    pushing : bool
        Whether the robots of an arena collide, for episodes that go on after a capture; one arena
        only. Otherwise they pass through each other from the moment of the capture on.

    Attributes
    ----------
    bodies : float32 array, shape (blocks, BODY_ROWS, 16)
        Arena i is pair ``i % 8`` of block ``i // 8``, see `layout`.
    wheels : float32 array, shape (blocks, WHEEL_ROWS, 16)
        Speeds that the wheels shall have during the next tick, rad/s; written by the caller.
    """

    def __init__(self, arena, count, pushing=False):
        self.arena = arena
        self.count = count
        self._limit = 0.5 * arena.size - BODY_RADIUS
        blocks = -(-count // HALF)
        self.bodies = aligned_rows(blocks * BODY_ROWS).reshape(blocks, BODY_ROWS, LANES)
        self.wheels = aligned_rows(blocks * WHEEL_ROWS).reshape(blocks, WHEEL_ROWS, LANES)

        self._space = pymunk.Space()
        self._space.collision_slop = SLOP
        self._space.collision_persistence = 1  # an episode inherits no contact from the last one
        self._space.collision_bias = _OVERLAP_KEPT ** (1 / TICK)
        # Chipmunk multiplies the elasticities of what touches.
        self._elasticity = math.sqrt(RESTITUTION) if arena.wall_contact == 'rigid' else 0.0
        self._add_fixtures()
        mask = _FIXTURES | (_ROBOTS if pushing else 0)
        self._robots = [self._add_robot(mask) for _ in range(2 * count)]

        robots = len(self._robots)
        memory = np.zeros(6 * robots + _SPARE)
        self._state = memory[: 6 * robots].reshape(robots, 6)
        self._before = np.zeros_like(self._state)
        self._forces = np.zeros((robots, 3))
        self._contacts = np.zeros((robots, 3))  # impulses and angular impulse of the last sub-step
        self._impulses = np.zeros((robots, 2))
        self._state_buffer, self._force_buffer = batch.Buffer(), batch.Buffer()
        self._state_buffer.set_float_buf(memory)
        self._force_buffer.set_float_buf(self._forces.reshape(-1))
        for index in range(count):
            self.place(index)

    def _add_fixtures(self):
        half, space = 0.5 * self.arena.size, self._space
        wall, end = half + 0.5 * _WALL_THICKNESS, half + _WALL_THICKNESS
        corners = [((sign * wall, -end), (sign * wall, end)) for sign in (-1, 1)]
        corners += [((y0, x0), (y1, x1)) for (x0, y0), (x1, y1) in corners]
        shapes: list[pymunk.Shape] = [
            pymunk.Segment(space.static_body, *ends, 0.5 * _WALL_THICKNESS) for ends in corners
        ]
        if self.arena.obstacle:
            shapes.append(pymunk.Circle(space.static_body, OBSTACLE_RADIUS))
        for shape in shapes:
            shape.friction = self.arena.wall_friction / BODY_FRICTION
            shape.elasticity = self._elasticity
            shape.filter = pymunk.ShapeFilter(categories=_FIXTURES)
            space.add(shape)

    def _add_robot(self, mask):
        body = pymunk.Body(MASS, INERTIA)
        shape = pymunk.Circle(body, BODY_RADIUS)
        shape.friction = BODY_FRICTION
        shape.elasticity = self._elasticity
        shape.filter = pymunk.ShapeFilter(categories=_ROBOTS, mask=mask)
        self._space.add(body, shape)
        return body

    def place(self, index, poses=START_POSES):
        """Put the robots of an arena at rest.

        Parameters
        ----------
        index : int
        poses : array_like, shape (2, 3)
            x and y in m and heading in rad, of predator and prey.
        """
        block, pair = divmod(index, HALF)
        for robot, (x, y, heading) in enumerate(poses):
            self._put(2 * index + robot, x, y, heading)
            self._impulses[2 * index + robot] = 0.0
            self._contacts[2 * index + robot] = 0.0
            lane = pair + HALF * robot
            self.bodies[block, :, lane] = x, y, math.cos(heading), math.sin(heading), 0.0

    def _put(self, robot, x, y, heading):
        """Put one robot somewhere, at rest."""
        body = self._robots[robot]
        body.update_position(body, 0.0)  # drops the correction of an overlap still to come
        body.position, body.angle = (float(x), float(y)), float(heading)
        body.velocity, body.angular_velocity = (0.0, 0.0), 0.0

    def _undo(self, start):
        """Put the robots that overlap a wall or the obstacle back where they were."""
        places = self._state[:, :2]
        inside = np.abs(places).max(axis=1) > self._limit
        if self.arena.obstacle:
            inside |= np.hypot(*places.T) < OBSTACLE_RADIUS + BODY_RADIUS
        for robot in np.flatnonzero(inside):
            self._put(robot, *start[robot, :3])
        self._read()

    def step(self):
        """Move all robots by one tick.

        Returns
        -------
        bool array, shape (count,)
            Whether the bodies in each arena touched at any moment of the tick.
        """
        captured = np.zeros(self.count, np.bool_)
        self._impulses[:] = 0.0
        self._read()
        start = self._state.copy()
        for _ in range(SUBSTEPS):
            _drive(self._state, self.wheels, self._contacts, self._forces)
            batch.set_space_bodies(self._space, _FORCE, self._force_buffer)
            self._before[:] = self._state
            self._space.step(_STEP)
            self._read()
            _account(
                self._before, self._state, self._forces, self._contacts, self._impulses, captured
            )
        if self.arena.wall_contact == 'undo':
            self._undo(start)
        _report(self._state, self._impulses, self._limit, self.arena.obstacle, self.bodies)
        return captured

    def _read(self):
        self._state_buffer.clear()
        batch.get_space_bodies(self._space, _STATE, self._state_buffer)

    @property
    def contact_forces(self):
        """Mean force of all contacts on each robot during the last tick, N, shape (count, 2)."""
        return np.hypot(*self._impulses.T).reshape(self.count, 2) / TICK


class PymunkWorld(World):
    """One arena under rigid-body physics; after a capture the robots push each other.

    Parameters
    ----------
    arena : Arena
    """

    def __init__(self, arena=Arena(), robot=MARXBOT):
        self._arenas = PymunkArenas(arena, 1, pushing=True)
        super().__init__(arena, robot)

    def reset(self, poses=START_POSES):
        """Place the robots at rest, see `World.reset`."""
        self._arenas.place(0, check_poses(poses, self.arena))
        self._bodies = self._arenas.bodies[0]

    def step(self, wheel_speeds):
        """Move both robots by one tick, see `World.step`."""
        self._arenas.wheels[0][:, ROBOT_LANES] = np.asarray(wheel_speeds, dtype=np.float32).T
        return bool(self._arenas.step()[0])

    @property
    def contact_forces(self):
        """Mean force of all contacts on each robot during the last tick, N, shape (2,)."""
        return self._arenas.contact_forces[0]
