"""Known answers, by hand, for motion, contact and capture; and what must hold for any tick."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from marxbot_sim.core.parameters import (
    BODY_RADIUS,
    OBSTACLE_RADIUS,
    START_POSES,
    TICK,
    WHEEL_RADIUS,
    WHEEL_SEPARATION,
    Arena,
)
from marxbot_sim.core.world import World

LIMIT = 1.5 - BODY_RADIUS
STEP = 10 * WHEEL_RADIUS * TICK  # m, a tick at 10 rad/s
FAR = (1.2, -1.2, 0.0)


def after(pose, *wheels, arena=Arena(), other=FAR):
    """Pose of the predator after one tick for each pair of wheel speeds; the prey stands."""
    world = World(arena)
    world.reset(np.array([pose, other]))
    for speeds in wheels:
        world.step(np.array([speeds, (0, 0)], np.float32))
    return world.poses[0].astype(float)


def turned(pose):
    """A pose with its heading as a direction, to compare across the turn of the angle."""
    return [pose[0], pose[1], math.cos(pose[2]), math.sin(pose[2])]


def test_the_start():
    world = World(Arena())
    world.reset()
    assert world.poses == pytest.approx(np.array([(-0.5, 0, 0), (0.5, 0, math.pi)]), abs=1e-6)
    assert np.asarray(START_POSES) == pytest.approx(world.poses, abs=1e-6)
    bodies = [(-0.5, 0, 1, 0, 0), (0.5, 0, -1, 0, 0)]
    assert world.bodies == pytest.approx(np.array(bodies), abs=1e-6)


@pytest.mark.parametrize('heading', [0, 1, math.pi / 2, -2.5])
def test_equal_wheels_drive_straight(heading):
    for speed in (10, -10, 0.25):
        way = speed / 10 * 0.027
        expected = (0.2 + way * math.cos(heading), 0.3 + way * math.sin(heading), heading)
        end = after((0.2, 0.3, heading), (speed, speed))
        assert turned(end) == pytest.approx(turned(expected), abs=1e-6)


def test_opposite_wheels_turn_on_the_spot():
    # rims roll 0.027 m, 0.1265 m apart
    expected = (0.2, 0.3, 1 + 2 * 0.027 / 0.1265)
    assert after((0.2, 0.3, 1), (-10, 10)) == pytest.approx(expected, abs=1e-6)
    assert after((0.2, 0.3, 1), (10, -10)) == pytest.approx((0.2, 0.3, 2 - expected[2]), abs=1e-6)


def test_one_wheel_pivots_about_the_other():
    # the left wheel stands at (0, 0.06325); the right one carries the robot round it
    turn = 0.027 / 0.1265
    expected = (0.06325 * math.sin(turn), 0.06325 - 0.06325 * math.cos(turn), turn)
    assert after((0, 0, 0), (0, 10)) == pytest.approx(expected, abs=1e-6)
    mirrored = (expected[0], -expected[1], -turn)
    assert after((0, 0, 0), (10, 0)) == pytest.approx(mirrored, abs=1e-6)


@given(st.floats(-3.1, 3.1), st.floats(-10, 10), st.floats(-10, 10))
@settings(max_examples=200, deadline=None)
def test_free_motion_is_an_arc_so_two_ticks_at_half_speed_equal_one(heading, left, right):
    whole = after((0.5, 0.5, heading), (left, right))
    halves = after((0.5, 0.5, heading), (left / 2, right / 2), (left / 2, right / 2))
    assert turned(whole) == pytest.approx(turned(halves), abs=1e-6)


def test_a_full_circle_ends_where_it_began():
    # turning 2 pi in 50 ticks about a centre 0.3 m to the left
    turn = 2 * math.pi / 50
    speeds = [turn * (0.3 + side * 0.1265 / 2) / 0.0027 for side in (-1, 1)]
    assert turned(after((0.1, 0.2, 0.5), *[speeds] * 50)) == pytest.approx(
        turned((0.1, 0.2, 0.5)), abs=1e-5
    )
    half = after((0.1, 0.2, 0), *[speeds] * 25)
    assert turned(half) == pytest.approx(turned((0.1, 0.8, math.pi)), abs=1e-5)


@pytest.mark.parametrize('wall', range(4))
def test_a_wall_stops_the_robot_and_not_its_heading(wall):
    turn = wall * math.pi / 2
    cos, sin = round(math.cos(turn)), round(math.sin(turn))
    x, y, heading = after((1.4 * cos, 1.4 * sin, turn), (10, 10), (10, 10))
    assert (x, y) == pytest.approx((1.415 * cos, 1.415 * sin), abs=1e-6)
    assert (math.cos(heading), math.sin(heading)) == pytest.approx((cos, sin), abs=1e-6)


@pytest.mark.parametrize('friction', [0, 0.25, 0.5, 1])
def test_sliding_along_a_wall_loses_friction_times_what_was_stopped(friction):
    # against the wall x = 1.415, heading 60 degrees off the wall's normal
    heading = math.radians(60)
    arena = Arena(wall_friction=friction)
    x, y, _ = after((1.415, 0, heading), (10, 10), arena=arena)
    along, stopped = STEP * math.sin(heading), STEP * math.cos(heading)
    assert x == pytest.approx(1.415, abs=1e-6)
    assert y == pytest.approx(along - friction * stopped, abs=1e-6)
    # only what was stopped counts: starting 0.01 m before the wall
    x, y, _ = after((1.405, 0, -heading), (10, 10), arena=arena)
    assert x == pytest.approx(1.415, abs=1e-6)
    assert y == pytest.approx(-(along - friction * (stopped - 0.01)), abs=1e-6)


def test_large_friction_holds_the_robot():
    for heading in (0.2, -0.2, 1.4):
        x, y, _ = after((1.415, 0.3, heading), *[(10, 10)] * 5, arena=Arena(wall_friction=100))
        assert (x, y) == pytest.approx((1.415, 0.3), abs=1e-6)


def test_a_corner_holds_both_axes():
    for friction in (0, 0.5, 100):
        arena = Arena(wall_friction=friction)
        x, y, _ = after((1.41, 1.41, math.pi / 4), *[(10, 10)] * 3, arena=arena)
        assert max(x, y) <= 1.415 + 1e-6
        if friction == 0:
            assert (x, y) == pytest.approx((1.415, 1.415), abs=1e-6)


def test_the_obstacle_stops_the_robot():
    arena = Arena(obstacle=True)
    for heading in (0, 2.0):
        start = (-0.15 * math.cos(heading), -0.15 * math.sin(heading), heading)
        x, y, _ = after(start, *[(10, 10)] * 3, arena=arena)
        expected = (-0.135 * math.cos(heading), -0.135 * math.sin(heading))
        assert (x, y) == pytest.approx(expected, abs=1e-6)
    x, *_ = after((-0.15, 0, 0), (10, 10))
    assert x == pytest.approx(-0.123, abs=1e-6)


@pytest.mark.parametrize('friction', [0, 0.5, 100])
def test_sliding_along_the_obstacle(friction):
    # touching it from the left, heading 60 degrees off its normal: the straight step ends at
    # (x, y), which is pushed out along its radius and then held back along the tangent there
    arena = Arena(obstacle=True, wall_friction=friction)
    heading = math.radians(60)
    x, y = -0.135 + STEP * math.cos(heading), STEP * math.sin(heading)
    normal = np.array([x, y]) / math.hypot(x, y)
    tangent = np.array([-normal[1], normal[0]])
    depth = 0.135 - math.hypot(x, y)
    along = np.dot((x + 0.135, y), tangent)
    held = min(friction * depth, abs(along)) * math.copysign(1, along)
    expected = np.array([x, y]) + depth * normal - held * tangent
    end = after((-0.135, 0, heading), (10, 10), arena=arena)
    assert end[:2] == pytest.approx(expected, abs=1e-6)
    assert end[2] == pytest.approx(heading, abs=1e-6)
    assert depth > 0.005


def captured(starts, headings, speeds, arena=Arena()):
    world = World(arena)
    world.reset(np.column_stack([starts, headings]))
    return bool(world.step(np.repeat(np.array(speeds, np.float32)[:, None], 2, axis=1)))


def test_capture_is_the_touch_of_the_bodies():
    assert not captured([(-0.09, 0), (0.09, 0)], (0, 0), (0, 0))
    assert not captured([(0, 0), (0.198, 0)], (0, 0), (10, 0))
    assert captured([(0, 0), (0.196, 0)], (0, 0), (10, 0))
    assert not captured([(0, 0), (0.196, 0)], (0, 0), (10, 1))
    assert captured([(0, 0), (0.196, 0)], (0, math.pi), (9, 1))


def test_capture_is_swept_along_the_tick():
    # robots pass each other 0.169 m apart; before and after the tick they are 0.1711 m apart
    passing = [(-0.0135, 0), (0.0135, 0.169)]
    assert captured(passing, (0, math.pi), (10, 10))
    ends = [(0.0135, 0), (-0.0135, 0.169)]
    assert math.dist(*passing) > 0.171 and math.dist(*ends) > 0.171
    assert not captured([(-0.0135, 0), (0.0135, 0.1701)], (0, math.pi), (10, 10))
    # side by side at the same speed they never meet
    assert not captured([(0, 0), (0, 0.1701)], (0, 0), (10, 10))


def test_capture_at_the_wall_counts_where_the_robot_stopped():
    # without the wall both would have moved on together
    assert captured([(1.415, 0), (1.24, 0)], (0, 0), (10, 10))


coordinate = st.floats(-LIMIT, LIMIT) | st.sampled_from([-LIMIT, LIMIT])
small = st.floats(-0.25, 0.25)
angle = st.floats(-3.1, 3.1)
pose = st.tuples(coordinate, coordinate, angle) | st.tuples(small, small, angle)
speed = st.floats(-10, 10) | st.just(10.0)
speeds = st.tuples(st.tuples(speed, speed), st.tuples(speed, speed))
frictions = st.sampled_from([0.0, 0.5, 3.0])


def worlds(poses, arena):
    poses = np.array(poses, np.float32)
    assume(math.dist(poses[0, :2], poses[1, :2]) > 2 * BODY_RADIUS)
    if arena.obstacle:
        assume((np.hypot(*poses[:, :2].T) >= BODY_RADIUS + OBSTACLE_RADIUS).all())
    world = World(arena)
    world.reset(poses)
    return world


@given(pose, pose, st.lists(speeds, min_size=1, max_size=4), st.booleans(), frictions)
@settings(max_examples=300, deadline=None)
def test_no_robot_ends_a_tick_inside_anything(predator, prey, commands, obstacle, friction):
    world = worlds([predator, prey], Arena(obstacle=obstacle, wall_friction=friction))
    for command in commands:
        world.step(np.array(command, np.float32))
        x, y, _ = world.poses.T.astype(float)
        assert np.abs([x, y]).max() <= LIMIT + 1e-6
        if obstacle:
            assert np.hypot(x, y).min() >= BODY_RADIUS + OBSTACLE_RADIUS - 1e-6


@given(pose, speeds, st.booleans(), frictions)
@settings(max_examples=300, deadline=None)
def test_contact_never_changes_the_heading(predator, command, obstacle, friction):
    world = worlds([predator, FAR], Arena(obstacle=obstacle, wall_friction=friction))
    world.step(np.array(command, np.float32))
    left, right = command[0]
    heading = predator[2] + (right - left) * WHEEL_RADIUS * TICK / WHEEL_SEPARATION
    cos, sin = world.bodies[0, 2:4]
    assert (cos, sin) == pytest.approx((math.cos(heading), math.sin(heading)), abs=1e-6)


@given(pose, speeds, frictions)
@settings(max_examples=300, deadline=None)
def test_walls_never_carry_a_robot_further_than_its_wheels(predator, command, friction):
    world = worlds([predator, FAR], Arena(wall_friction=friction))
    before = world.poses.copy()
    world.step(np.array(command, np.float32))
    way = np.hypot(*(world.poses - before)[:, :2].T)
    assert (way <= np.abs(np.array(command)).mean(axis=1) * WHEEL_RADIUS * TICK + 1e-6).all()


@given(pose, pose, speeds, st.booleans(), frictions)
@settings(max_examples=300, deadline=None)
def test_mirrored_robots_move_as_the_mirror_image(predator, prey, command, obstacle, friction):
    arena = Arena(obstacle=obstacle, wall_friction=friction)
    ours = worlds([predator, prey], arena)
    theirs = worlds(np.array([predator, prey]) * (1, -1, -1), arena)
    command = np.array(command, np.float32)
    apart = math.dist(predator[:2], prey[:2])
    same = ours.step(command) == theirs.step(np.ascontiguousarray(command[:, ::-1]))
    assert same or abs(apart - 2 * BODY_RADIUS) < 0.06
    flipped = theirs.bodies * np.array([1, -1, 1, -1, 1], np.float32)
    assert ours.bodies[:, :4] == pytest.approx(flipped[:, :4], abs=2e-6)
