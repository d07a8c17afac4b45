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
    WALL_CONTACTS,
    WHEEL_RADIUS,
    WHEEL_SEPARATION,
    Arena,
)
from marxbot_sim.core.world import World

LIMIT = 1.5 - BODY_RADIUS
RIM_TURN = 0.085 / 0.06325**2  # rad a metre: R / b^2
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
def test_a_wall_that_it_faces_stops_the_robot_and_does_not_turn_it(wall):
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
    for wall_contact in ('rigid', 'slide'):
        arena = Arena(wall_friction=100, wall_contact=wall_contact)
        for heading in (0.2, -0.2, 1.4):
            x, y, _ = after((1.415, 0.3, heading), *[(10, 10)] * 5, arena=arena)
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
    # facing it is the direction of -normal; the turn is capped, and does not overshoot
    to_face = math.remainder(math.atan2(-normal[1], -normal[0]) - heading, 2 * math.pi)
    turn = min(RIM_TURN * abs(held), 0.5, abs(to_face)) * math.copysign(1, to_face)
    assert end[2] == pytest.approx(heading + turn, abs=2e-6)
    assert depth > 0.005


@pytest.mark.parametrize('degrees', [1, 10, 20, 26, 27, 45, 60, 80, 89])
@pytest.mark.parametrize('side', [-1, 1])
@pytest.mark.parametrize('way', [10, -10])
def test_a_rigid_wall_turns_a_robot_toward_the_normal(degrees, side, way):
    # a robot that drives into x = 1.5, or backs into it, that many degrees off the wall's normal
    off = side * math.radians(degrees)
    heading = off if way > 0 else off + math.pi
    _, y, end = after((1.415, 0, heading), (way, way))
    along, stopped = STEP * math.sin(abs(off)), STEP * math.cos(off)
    lost = min(0.5 * stopped, along)
    turn = min(RIM_TURN * lost, abs(off))
    assert y == pytest.approx(side * (along - lost), abs=1e-6)
    assert math.remainder(end - heading, 2 * math.pi) == pytest.approx(-side * turn, abs=2e-6)


def test_a_rigid_wall_never_turns_a_robot_past_the_normal():
    # at 30 rad/s friction could turn it by 1.7 times its angle; facing the wall it stays
    arena = Arena(wall_friction=100)
    for off in (0.02, -0.05):
        end = after((1.415, 0, off), (30, 30), arena=arena)
        assert end == pytest.approx((1.415, 0, 0), abs=1e-6)
    assert after((1.415, 0, 1.2), *[(10, 10)] * 40)[2] == pytest.approx(0, abs=1e-5)


def test_a_rigid_wall_turns_by_half_a_radian_in_a_tick_at_most():
    _, _, heading = after((1.415, 0, 1.5), (30, 30), arena=Arena(wall_friction=100))
    assert heading == pytest.approx(1.0, abs=2e-6)


def test_both_walls_of_a_corner_turn_a_robot():
    # each wall turns it by what friction took along it: here both took all there was
    arena = Arena(wall_friction=0.2)
    heading = math.radians(40)
    x, y, end = after((1.415, 1.415, heading), (10, 10), arena=arena)
    assert (x, y) == pytest.approx((1.415, 1.415), abs=1e-6)
    assert end == pytest.approx(heading, abs=1e-6)  # no slide is left that friction could take
    # 1 mm of slide is left along each: the walls turn it by as much, one against the other
    x, y, end = after((1.414, 1.412, heading), (10, 10), arena=arena)
    assert (x, y) == pytest.approx((1.414, 1.412), abs=1e-6)
    assert end == pytest.approx(heading - RIM_TURN * 0.003 + RIM_TURN * 0.001, abs=2e-6)


@pytest.mark.parametrize('obstacle', [False, True])
def test_undo_keeps_position_and_heading(obstacle):
    arena = Arena(obstacle=obstacle, wall_contact='undo')
    start = (-0.14, 0.01, 0.3) if obstacle else (1.41, 0.3, 0.5)
    for speeds in ((10, 10), (10, 9), (-10, -10)):
        if speeds[0] < 0:
            start = (*start[:2], start[2] + math.pi)
        assert turned(after(start, speeds, arena=arena)) == pytest.approx(turned(start), abs=1e-6)
    # turning on the spot is no move that ends inside
    end = after(start, (-10, 10), arena=arena)
    assert turned(end) == pytest.approx(
        turned((*start[:2], start[2] + 2 * 0.027 / 0.1265)), abs=1e-6
    )


@pytest.mark.parametrize('wall_contact', ['rigid', 'slide', 'undo'])
def test_contact_is_felt_however_it_ends(wall_contact):
    for pose, obstacle in (((1.41, 0, 0.4), False), ((-0.14, 0, 0.1), True)):
        world = World(Arena(obstacle=obstacle, wall_contact=wall_contact))
        world.reset([pose, FAR])
        world.step([(10, 10), (0, 0)])
        assert world.bodies[:, 4].tolist() == [1, 0]
        world.step([(-10, -10), (0, 0)])
        assert world.bodies[:, 4].tolist() == [0, 0]


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
wall_contacts = st.sampled_from(WALL_CONTACTS)


def worlds(poses, arena):
    poses = np.array(poses, np.float32)
    assume(math.dist(poses[0, :2], poses[1, :2]) > 2 * BODY_RADIUS)
    if arena.obstacle:
        assume((np.hypot(*poses[:, :2].T) >= BODY_RADIUS + OBSTACLE_RADIUS).all())
    world = World(arena)
    world.reset(poses)
    return world


arenas = st.builds(
    Arena, obstacle=st.booleans(), wall_friction=frictions, wall_contact=wall_contacts
)


@given(pose, pose, st.lists(speeds, min_size=1, max_size=4), arenas)
@settings(max_examples=300, deadline=None)
def test_no_robot_ends_a_tick_inside_anything(predator, prey, commands, arena):
    world = worlds([predator, prey], arena)
    for command in commands:
        world.step(np.array(command, np.float32))
        x, y, _ = world.poses.T.astype(float)
        assert np.abs([x, y]).max() <= LIMIT + 1e-6
        if arena.obstacle:
            assert np.hypot(x, y).min() >= BODY_RADIUS + OBSTACLE_RADIUS - 1e-6


@given(pose, speeds, st.booleans(), frictions)
@settings(max_examples=300, deadline=None)
def test_contact_that_slides_never_changes_the_heading(predator, command, obstacle, friction):
    arena = Arena(obstacle=obstacle, wall_friction=friction, wall_contact='slide')
    world = worlds([predator, FAR], arena)
    world.step(np.array(command, np.float32))
    left, right = command[0]
    heading = predator[2] + (right - left) * WHEEL_RADIUS * TICK / WHEEL_SEPARATION
    cos, sin = world.bodies[0, 2:4]
    assert (cos, sin) == pytest.approx((math.cos(heading), math.sin(heading)), abs=1e-6)


@given(pose, speeds, st.booleans(), frictions)
@settings(max_examples=300, deadline=None)
def test_rigid_and_sliding_contact_end_at_the_same_place(predator, command, obstacle, friction):
    ends = []
    for wall_contact in ('rigid', 'slide'):
        world = worlds([predator, FAR], Arena(3.0, obstacle, friction, wall_contact))
        world.step(np.array(command, np.float32))
        ends.append(world.bodies)
    assert (ends[0][:, [0, 1, 4]] == ends[1][:, [0, 1, 4]]).all()
    assert np.hypot(*ends[0][:, 2:4].T) == pytest.approx([1, 1], abs=1e-6)


@given(pose, speeds, frictions)
@settings(max_examples=300, deadline=None)
def test_walls_never_carry_a_robot_further_than_its_wheels(predator, command, friction):
    world = worlds([predator, FAR], Arena(wall_friction=friction))
    before = world.poses.copy()
    world.step(np.array(command, np.float32))
    way = np.hypot(*(world.poses - before)[:, :2].T)
    assert (way <= np.abs(np.array(command)).mean(axis=1) * WHEEL_RADIUS * TICK + 1e-6).all()


@given(pose, pose, speeds, arenas)
@settings(max_examples=300, deadline=None)
def test_mirrored_robots_move_as_the_mirror_image(predator, prey, command, arena):
    ours = worlds([predator, prey], arena)
    theirs = worlds(np.array([predator, prey]) * (1, -1, -1), arena)
    command = np.array(command, np.float32)
    apart = math.dist(predator[:2], prey[:2])
    same = ours.step(command) == theirs.step(np.ascontiguousarray(command[:, ::-1]))
    assert same or abs(apart - 2 * BODY_RADIUS) < 0.06
    flipped = theirs.bodies * np.array([1, -1, 1, -1, 1], np.float32)
    assert ours.bodies[:, :4] == pytest.approx(flipped[:, :4], abs=2e-6)
