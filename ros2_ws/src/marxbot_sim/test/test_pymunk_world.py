"""Rigid-body physics against the kinematic kernel, and against what Newton says."""

import math

import numpy as np
import pytest

from marxbot_sim.core.layout import CONTACT, READING_ROWS
from marxbot_sim.core.parameters import (
    BODY_RADIUS,
    OBSTACLE_RADIUS,
    TICK,
    WALL_CONTACTS,
    WHEEL_RADIUS,
    Arena,
)
from marxbot_sim.core.physics import make_world
from marxbot_sim.core.pymunk_world import (
    CONTACT_THRESHOLD,
    MASS,
    RESTITUTION,
    WHEEL_FRICTION,
    PymunkArenas,
    PymunkWorld,
)
from marxbot_sim.core.world import World, _move, arena_rows

FULL = 10.0
WEIGHT = MASS * 9.81
DEEPEST = 0.0015  # docs/physics.md: a body overlaps what it meets by less than this, m
FAR = ((-50.0, 0.0, 0.0), (50.0, 0.0, math.pi))


def commands(rng, ticks, change):
    """Yield wheel speeds of two robots that change by at most `change` rad/s in a tick."""
    wheels = np.zeros((2, 2))
    for _ in range(ticks):
        step = rng.uniform(-FULL, FULL, (2, 2)) - wheels
        wheels = wheels + np.clip(step, -change, change)
        yield wheels


def turned(angle):
    return np.abs((angle + math.pi) % (2 * math.pi) - math.pi)


@pytest.mark.parametrize(
    ('change', 'metres', 'radians'), [(1.0, 0.002, 0.015), (2.0, 0.01, 0.04), (20.0, 0.5, 2.0)]
)
def test_free_motion_agrees_with_the_kernel_over_an_episode(change, metres, radians):
    """The bounds are those of docs/physics.md, which says where the difference comes from."""
    worst = np.zeros(2)
    for seed in range(3):
        arena = Arena(size=300.0)
        kernel, rigid = World(arena), PymunkWorld(arena)
        kernel.reset(FAR)
        rigid.reset(FAR)
        for wheels in commands(np.random.default_rng(seed), 1000, change):
            kernel.step(wheels)
            rigid.step(wheels)
            apart = kernel.poses - rigid.poses
            worst[0] = max(worst[0], np.hypot(apart[:, 0], apart[:, 1]).max())
            worst[1] = max(worst[1], turned(apart[:, 2]).max())
    assert worst[0] < metres
    assert worst[1] < radians
    if change > FULL:
        assert worst[0] > 0.02, 'wheels slip under abrupt commands, which the kernel leaves out'


@pytest.mark.parametrize('obstacle', [False, True])
def test_sensors_are_exactly_those_of_the_kernel(obstacle):
    rng = np.random.default_rng(0)
    arena = Arena(obstacle=obstacle)
    kernel, rigid = World(arena), PymunkWorld(arena)
    seen = 0
    while seen < 300:
        poses = rng.uniform(-1.41, 1.41, (2, 3)) * [1, 1, 3]
        try:
            kernel.reset(poses)
        except ValueError:
            continue
        rigid.reset(poses)
        np.testing.assert_array_equal(rigid.readings, kernel.readings)
        assert rigid.readings.shape == (2, READING_ROWS)
        seen += 1


@pytest.mark.parametrize('obstacle', [False, True])
def test_bodies_never_sink_in_and_contact_is_felt_where_the_kernel_feels_it(obstacle):
    rng = np.random.default_rng(1)
    arena = Arena(obstacle=obstacle)
    arenas = PymunkArenas(arena, 32)
    for index in range(32):
        y = rng.uniform(-1.4, 1.4, 2)
        arenas.place(index, [(-0.2, y[0], rng.uniform(0, 7)), (0.2, y[1], rng.uniform(0, 7))])
    felt, expected = [], []
    for tick in range(300):
        if tick % 10 == 0:
            arenas.wheels[:] = rng.uniform(-4, FULL, arenas.wheels.shape)
        kernel = arenas.bodies.copy()
        arenas.step()
        for places, overlap in ((arenas._state[:, :2].T, DEEPEST), (arenas.bodies[:, :2], 1e-7)):
            assert np.abs(places).max() < 1.5 - BODY_RADIUS + overlap
            if obstacle:
                distance = np.hypot(*np.moveaxis(places, -2, 0))
                assert distance.min() > OBSTACLE_RADIUS + BODY_RADIUS - overlap
        for bodies, wheels in zip(kernel, arenas.wheels, strict=True):
            _move(bodies, wheels, arena_rows(arena), obstacle)
        felt.append(arenas.bodies[:, CONTACT].copy())
        expected.append(kernel[:, CONTACT])
    felt, expected = np.array(felt) > 0, np.array(expected) > 0
    assert expected.mean() > 0.03
    assert (felt & expected).sum() > 0.9 * (felt | expected).sum()


def test_a_robot_slides_along_a_wall_and_friction_slows_it():
    length = {}
    for friction in (0.0, 0.5):
        world = PymunkWorld(Arena(wall_friction=friction))
        world.reset([(0.0, 1.4, 0.4), (0.5, -1.0, 0.0)])
        path = []
        for _ in range(20):
            world.step([(FULL, FULL), (0, 0)])
            path.append(world.poses[0])
        length[friction] = path[-1][0]
        assert world.bodies[0, CONTACT] == 1
        assert abs(path[-1][1] - (1.5 - BODY_RADIUS)) < DEEPEST
    free = FULL * WHEEL_RADIUS * 20 * TICK
    assert 0.05 < length[0.5] < length[0.0] <= free + 1e-6


def test_no_place_holds_a_robot_for_good():
    """After pressing into a wall, a corner or the obstacle for 5 s every robot backs off."""
    for heading in np.linspace(0, 2 * math.pi, 16, endpoint=False):
        world = PymunkWorld(Arena(obstacle=True))
        world.reset([(1.2, 1.2, heading), (-0.4, 0.02, 0.0)])
        for _ in range(50):
            world.step([(FULL, FULL), (FULL, FULL)])
        stuck = world.poses
        for _ in range(10):
            world.step([(-FULL, -FULL), (-FULL, -FULL)])
        moved = np.hypot(*(world.poses - stuck)[:, :2].T)
        assert moved.min() > 0.5 * FULL * WHEEL_RADIUS
        assert (world.bodies[:, CONTACT] == 0).all()


def pressing(physics, degrees, ticks=40, **arena):
    """Headings off the wall's normal, degrees, of a robot that drives into it, from the hit on."""
    world = make_world(physics, Arena(**arena))
    world.reset([(1.5 - BODY_RADIUS - 0.02, 0.0, math.radians(degrees)), (-0.5, 0.0, 0.0)])
    headings = []
    while len(headings) < ticks:
        world.step([(FULL, FULL), (0, 0)])
        if headings or world.bodies[0, CONTACT]:
            headings.append(math.degrees(world.poses[0, 2]))
    return np.array(headings)


@pytest.mark.parametrize('degrees', [-70, -40, 10, 40, 80])
def test_rim_friction_turns_a_robot_to_face_the_wall_in_both_physics(degrees):
    faced = {}
    for physics in ('kinematic', 'pymunk'):
        headings = pressing(physics, degrees)
        assert abs(headings[-1]) < 0.5
        assert (np.sign(degrees) * headings > -3).all(), 'it does not swing past the normal'
        faced[physics] = np.argmax(np.abs(headings) < 5) * TICK
    # docs/physics.md shows both: the kernel is the faster one
    assert 0.1 < faced['pymunk'] - faced['kinematic'] + 0.15 < 0.6
    assert np.abs(pressing('pymunk', degrees, wall_friction=0.0) - degrees).max() < 0.1


def test_a_rigid_wall_holds_a_robot_that_only_drives_forward():
    """One wheel turns, the other stands; turning on the spot frees it, or a wall without grip.

    In the kernel friction at the rim does not hold back the wheels' own turn: see docs/physics.md.
    """
    for physics, friction, wheels, free in (
        ('pymunk', 0.5, (0, FULL), False),
        ('pymunk', 0.5, (-FULL, FULL), True),
        ('pymunk', 0.0, (0, FULL), True),
        ('kinematic', 0.5, (0, FULL), True),
        ('kinematic', 0.5, (-FULL, FULL), True),
    ):
        world = make_world(physics, Arena(wall_friction=friction))
        world.reset([(1.3, 0.0, 0.1), (-0.5, 0.0, 0.0)])
        for _ in range(30):
            world.step([(FULL, FULL), (0, 0)])
        assert world.bodies[0, CONTACT] == 1
        turned_away = False
        for _ in range(100):
            world.step([wheels, (0, 0)])
            turned_away |= math.cos(world.poses[0, 2]) < -0.5
        assert turned_away == free


def test_a_robot_rebounds_from_rigid_walls_alone():
    speeds = {}
    for wall_contact in WALL_CONTACTS:
        world = PymunkWorld(Arena(wall_contact=wall_contact))
        world.reset([(1.38, 0.0, 0.0), (-0.5, 0.0, 0.0)])
        body = world._arenas._robots[0]
        body.velocity = FULL * WHEEL_RADIUS, 0.0
        lowest = 0.0
        step = world._arenas._space.step

        def watch(duration, step=step, body=body):
            nonlocal lowest
            step(duration)
            lowest = min(lowest, body.velocity.x)

        world._arenas._space.step = watch
        for _ in range(3):
            world.step([(FULL, FULL), (0, 0)])
        speeds[wall_contact] = -lowest / (FULL * WHEEL_RADIUS)
    assert speeds['rigid'] == pytest.approx(RESTITUTION, rel=0.15)
    assert speeds['slide'] == speeds['undo'] == pytest.approx(0, abs=0.01)


@pytest.mark.parametrize('obstacle', [False, True])
def test_undo_puts_a_robot_back_where_it_was(obstacle):
    world = PymunkWorld(Arena(obstacle=obstacle, wall_contact='undo'))
    start = (-0.2, 0.01, 0.1) if obstacle else (1.35, 0.0, 0.5)
    world.reset([start, (-0.5, -1.0, 0.0)])
    places, felt = [world.poses[0]], []
    for _ in range(20):
        world.step([(FULL, FULL), (0, 0)])
        places.append(world.poses[0])
        felt.append(world.bodies[0, CONTACT])
    assert felt[0] == 0 and felt[-1] == 1
    # from rest it may come nearer once more, until a tick carries it into the thing again
    moves = np.diff(places, axis=0)
    assert (moves[np.array(felt) == 1] == 0).all()
    assert (moves[-5:] == 0).all()
    assert np.hypot(*(places[-1] - places[0])[:2]) > 0.02


def test_acceleration_is_limited_by_traction():
    """From rest to v takes v / (mu g); the way lost meanwhile is v^2 / (2 mu g)."""
    world = PymunkWorld(Arena())
    world.step([(FULL, FULL), (0, 0)])
    speed = FULL * WHEEL_RADIUS
    lost = speed * TICK - (world.poses[0, 0] + 0.5)
    assert lost == pytest.approx(speed**2 / (2 * WHEEL_FRICTION * 9.81), rel=0.6)
    assert lost > 0.004


def test_a_robot_pushes_a_wall_with_all_its_traction():
    world = PymunkWorld(Arena())
    world.reset([(1.4, 0.0, 0.0), (-0.5, 0.0, 0.0)])
    for _ in range(20):
        world.step([(FULL, FULL), (0, 0)])
    assert world.contact_forces[0] == pytest.approx(WHEEL_FRICTION * WEIGHT, rel=0.01)
    assert world.contact_forces[1] == 0
    # the same from Chipmunk's own account of the last sub-step
    impulses = []
    body = world._arenas._robots[0]
    body.each_arbiter(lambda arbiter: impulses.append(arbiter.total_impulse))
    assert np.hypot(*np.sum(impulses, axis=0)) * 200 == pytest.approx(
        world.contact_forces[0], rel=0.01
    )


def test_a_gentle_push_is_below_the_threshold():
    world = PymunkWorld(Arena())
    world.reset([(1.5 - BODY_RADIUS - 1e-4, 0.0, 0.0), (-0.5, 0.0, 0.0)])
    world.step([(0.01, 0.01), (0, 0)])
    assert world.contact_forces[0] < CONTACT_THRESHOLD
    assert world.bodies[0, CONTACT] == 0


def test_after_a_capture_the_robots_push_each_other():
    world = PymunkWorld(Arena())
    world.reset([(-0.2, 0.0, 0.0), (0.2, 0.03, 0.0)])
    captured = [world.step([(FULL, FULL), (0, 0)]) for _ in range(30)]
    assert not captured[0]
    assert captured[-1]
    assert world.poses[1, 0] > 0.201
    predator, prey = world.contact_forces
    assert predator == pytest.approx(prey, rel=1e-6)
    assert predator > CONTACT_THRESHOLD
    assert np.hypot(*(world.poses[1] - world.poses[0])[:2]) > 2 * BODY_RADIUS - 2 * DEEPEST
    for _ in range(10):
        world.step([(-FULL, -FULL), (0, 0)])
    assert (world.contact_forces < 1e-9).all()


def test_an_arena_does_not_depend_on_the_others():
    rng = np.random.default_rng(2)
    count, ticks = 19, 150
    wheels = rng.uniform(-3, FULL, (ticks // 10, count, 2, 2)).astype(np.float32)
    together = PymunkArenas(Arena(obstacle=True), count)
    pairs = [(i // 8, i % 8) for i in range(count)]
    alive = np.ones(count, bool)
    alone = [PymunkWorld(Arena(obstacle=True)) for _ in range(count)]
    for tick in range(ticks):
        for (block, pair), speeds in zip(pairs, wheels[tick // 10], strict=True):
            together.wheels[block][:, (pair, pair + 8)] = speeds.T
        captured = together.step()
        for i, world in enumerate(alone):
            if not alive[i]:
                continue
            assert world.step(wheels[tick // 10, i]) == captured[i]
            if not captured[i]:
                block, pair = pairs[i]
                bodies = together.bodies[block][:, (pair, pair + 8)].T
                np.testing.assert_array_equal(world.bodies, bodies)
        alive &= ~captured
    assert alive.sum() < count, 'some capture should have happened'


def test_a_capture_between_two_ticks_is_seen():
    """Two robots pass each other's flank in the middle of a tick."""
    found = {}
    for physics in ('kinematic', 'pymunk'):
        world = make_world(physics, Arena())
        world.reset([(-0.4, 0.0, 0.0), (0.4, 0.165, math.pi)])
        ticks = 0
        while not world.step([(FULL, FULL), (FULL, FULL)]):
            ticks += 1
        found[physics] = ticks
    assert abs(found['pymunk'] - found['kinematic']) <= 1


def test_bad_poses_are_refused_and_change_nothing():
    world = PymunkWorld(Arena())
    world.step([(FULL, FULL), (FULL, FULL)])
    before = world.poses
    with pytest.raises(ValueError, match='predator position'):
        world.reset([(2.0, 0.0, 0.0), (0.0, 0.0, 0.0)])
    np.testing.assert_array_equal(world.poses, before)
    with pytest.raises(ValueError, match='physics'):
        make_world('newton', Arena())
