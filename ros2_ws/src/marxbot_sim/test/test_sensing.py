"""Known answers, by hand, for every sensor; and what must hold wherever the robots stand."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from marxbot_sim.core.parameters import (
    BODY_RADIUS,
    GROUND_POSITIONS,
    INFRARED_RANGE,
    OBSTACLE_RADIUS,
    Arena,
)
from marxbot_sim.core.world import World

FAR = (1.2, -1.2, 0.0)
OPEN, OBSTACLE = Arena(), Arena(obstacle=True)
LIMIT = 1.5 - BODY_RADIUS


def readings(predator, prey=FAR, arena=OPEN):
    """What the predator at that pose senses."""
    world = World(arena)
    world.reset(np.array([predator, prey]))
    return world.readings[0].astype(float)


def infrared(*arguments, **options):
    return readings(*arguments, **options)[:24]


def camera(*arguments, **options):
    return readings(*arguments, **options)[24:32]


def degrees(angle):
    return math.radians(angle)


def test_infrared_sees_nothing_beyond_its_range():
    assert (infrared((0, 0, 0)) > INFRARED_RANGE).all()


def test_infrared_to_a_wall():
    # the centre 0.1 m from the wall: a ray reaches it after 0.1 / cos, less the body's radius
    seen = infrared((1.4, 0, 0))
    for ray, angle in ((0, 7.5), (23, 7.5), (1, 22.5), (22, 22.5)):
        assert seen[ray] == pytest.approx(0.1 / math.cos(degrees(angle)) - 0.085, abs=1e-6)
    assert seen[0] == pytest.approx(0.015863, abs=1e-6)
    assert (seen[6:18] > INFRARED_RANGE).all()


@pytest.mark.parametrize('side', range(4))
def test_infrared_to_each_wall_and_a_corner(side):
    turn = side * math.pi / 2
    cos, sin = round(math.cos(turn)), round(math.sin(turn))
    seen = infrared((1.4 * cos, 1.4 * sin, turn), prey=(0, 0, 0))
    assert seen[0] == pytest.approx(0.015863, abs=1e-6)
    # in the corner, heading into it: ray 2 at 37.5 degrees from the diagonal is 82.5 from one axis
    x, y = 1.4 * cos - 1.4 * sin, 1.4 * sin + 1.4 * cos
    corner = infrared((x, y, turn + math.pi / 4), prey=(0, 0, 0))
    nearest = 0.1 / math.cos(degrees(7.5)) - 0.085
    for ray in (2, 3, 20, 21):
        assert corner[ray] == pytest.approx(nearest, abs=1e-6)
    assert corner[0] == pytest.approx(0.1 / math.cos(degrees(37.5)) - 0.085, abs=1e-6)


def test_infrared_to_the_opponent_and_the_obstacle():
    # ray 0 points at the disc's centre when the heading is 7.5 degrees to its right
    ahead = -degrees(7.5)
    assert infrared((-0.2, 0, ahead), arena=OBSTACLE)[0] == pytest.approx(0.065, abs=1e-6)
    assert infrared((-0.2, 0, ahead), prey=(0.03, 0, 1.0))[0] == pytest.approx(0.06, abs=1e-6)
    # ray 1 passes the centre of a disc 0.23 m off at 0.23 sin 15 degrees
    beside = 0.23 * math.sin(degrees(15))
    expected = 0.23 * math.cos(degrees(15)) - math.sqrt(0.085**2 - beside**2) - 0.085
    seen = infrared((-0.2, 0, ahead), prey=(0.03, 0, 1.0))
    assert seen[1] == pytest.approx(expected, abs=1e-6)
    assert (infrared((-0.2, 0, ahead), arena=OPEN) > INFRARED_RANGE).all()


def test_every_ray_points_where_it_should():
    for ray in range(24):
        heading = -degrees(7.5 + 15 * ray)
        seen = infrared((-0.2, 0, heading), prey=(0, 0, 0))
        assert seen[ray] == pytest.approx(0.03, abs=2e-6)
        assert seen.argmin() == ray


def test_infrared_sees_the_nearer_of_two():
    # the obstacle stands before the opponent, which stands before the wall
    seen = infrared((-0.2, 0, -degrees(7.5)), prey=(0.14, 0, 0), arena=OBSTACLE)
    assert seen[0] == pytest.approx(0.065, abs=1e-6)
    seen = infrared((1.17, 0, -degrees(7.5)), prey=(1.4, 0, 0))
    assert seen[0] == pytest.approx(0.06, abs=1e-6)


def test_camera_at_the_start():
    # the prey is 1 m ahead: half of its width, asin 0.085, lies in each of the sectors 0 and 7
    expected = np.zeros(8)
    expected[[0, 7]] = math.asin(0.085) / degrees(45)
    assert camera((-0.5, 0, 0), (0.5, 0, math.pi)) == pytest.approx(expected, abs=1e-6)
    world = World(OPEN)
    world.reset()
    assert world.readings[:, 24:32] == pytest.approx(np.stack([expected] * 2), abs=1e-6)


@pytest.mark.parametrize('sector', range(8))
def test_camera_sector_in_whole_and_part(sector):
    middle = degrees(22.5 + 45 * sector)
    # 1 m off in the middle of the sector: all of it in there
    far = camera((0, 0, 0.3), (math.cos(middle + 0.3), math.sin(middle + 0.3), 0))
    assert far[sector] == pytest.approx(2 * math.asin(0.085) / degrees(45), abs=1e-6)
    assert far.sum() == pytest.approx(far[sector], abs=1e-6)
    # 0.2 m off: half-width asin 0.425 = 25.15 degrees, 2.65 beyond the sector on either side
    near = camera((0, 0, 0.3), (0.2 * math.cos(middle + 0.3), 0.2 * math.sin(middle + 0.3), 0))
    assert near[sector] == pytest.approx(1, abs=1e-6)
    beside = (math.degrees(math.asin(0.425)) - 22.5) / 45
    assert near[[sector - 1, (sector + 1) % 8]] == pytest.approx([beside] * 2, abs=1e-6)


def test_obstacle_hides_the_opponent_behind_it_and_not_before_it():
    # from 0.5 m the obstacle's half-width is asin 0.1, the prey's at 1 m only asin 0.085
    assert camera((-0.5, 0, 0), (0.5, 0, 0), OBSTACLE).max() == 0
    before = camera((-0.6, 0, 0), (-0.2, 0, 0), OBSTACLE)
    assert before.sum() == pytest.approx(2 * math.asin(0.085 / 0.4) / degrees(45), abs=1e-6)


def test_obstacle_hides_a_part():
    # the prey at bearing b shows what lies beyond the obstacle's edge, asin 0.1
    for bearing in (0.05, 0.1, 0.15, -0.15):
        prey = (-0.5 + 0.9 * math.cos(bearing), 0.9 * math.sin(bearing), 0)
        half = math.asin(0.085 / 0.9)
        beyond = max(0, abs(bearing) + half - max(math.asin(0.1), abs(bearing) - half))
        within = max(0, -math.asin(0.1) - (abs(bearing) - half))
        seen = camera((-0.5, 0, degrees(-22.5)), prey, OBSTACLE)
        assert seen.sum() == pytest.approx((beyond + within) / degrees(45), abs=1e-6)


def test_ground_is_white_in_the_middle_and_black_in_the_corners():
    at_centre = math.hypot(0.0435, 0.049) / (1.5 * math.sqrt(2))
    assert readings((0, 0, 0.7))[32:36] == pytest.approx([at_centre] * 4, abs=1e-6)
    assert readings((LIMIT, LIMIT, 0), prey=(0, 0, 0))[32:36].max() > 0.96
    assert sorted(map(tuple, np.abs(GROUND_POSITIONS).tolist())) == [(0.0435, 0.049)] * 4
    assert len({tuple(np.sign(p)) for p in np.asarray(GROUND_POSITIONS).tolist()}) == 4


def test_a_ground_sensor_over_the_centre_reads_white():
    for heading in np.linspace(-3, 3, 200):
        cos, sin = math.cos(heading), math.sin(heading)
        for sensor, (forward, left) in enumerate(GROUND_POSITIONS):
            x, y = -(forward * cos - left * sin), -(forward * sin + left * cos)
            assert 0 <= readings((x, y, heading))[32 + sensor] < 1e-4


@pytest.mark.parametrize('heading', [0, math.pi / 2, 2.0, -1.0])
def test_ground_darkness_is_the_distance_from_the_centre(heading):
    seen = readings((0.8, -0.6, heading))[32:36]
    for darkness, (forward, left) in zip(seen, GROUND_POSITIONS, strict=True):
        x = 0.8 + forward * math.cos(heading) - left * math.sin(heading)
        y = -0.6 + forward * math.sin(heading) + left * math.cos(heading)
        assert darkness == pytest.approx(math.hypot(x, y) / (1.5 * math.sqrt(2)), abs=1e-6)


def test_contact_lasts_as_long_as_the_push():
    world = World(OPEN)
    world.reset(np.array([(LIMIT - 0.03, 0, 0), FAR]))
    felt = []
    for speed in (10, 10, 10, -10, -10):
        felt.append(world.readings[0, 36])
        world.step(np.array([(speed, speed), (0, 0)], np.float32))
    felt.append(world.readings[0, 36])
    assert felt == [0, 0, 1, 1, 0, 0]
    assert world.readings[1, 36] == 0


@pytest.mark.parametrize(('start', 'arena'), [((1.415, 0, 0), OPEN), ((-0.135, 0, 0), OBSTACLE)])
def test_a_push_of_less_than_a_hundredth_of_a_millimetre_is_not_felt(start, arena):
    for push, felt in ((0, 0), (0.9e-5, 0), (1.1e-5, 1)):
        world = World(arena)
        world.reset(np.array([start, FAR]))
        world.step(np.array([(push / 0.0027, push / 0.0027), (0, 0)], np.float32))
        assert world.readings[0, 36] == felt


def test_contact_with_the_obstacle_is_felt():
    world = World(OBSTACLE)
    world.reset(np.array([(-BODY_RADIUS - OBSTACLE_RADIUS - 0.01, 0, 0), FAR]))
    world.step(np.full((2, 2), 10, np.float32))
    assert world.readings[0, 36] == 1
    world.reset()
    assert world.readings[0, 36] == 0


coordinate = st.floats(-LIMIT, LIMIT)
pose = st.tuples(coordinate, coordinate, st.floats(-3.1, 3.1))
near_pose = st.tuples(st.floats(-0.4, 0.4), st.floats(-0.4, 0.4), st.floats(-3.1, 3.1))


def sensed(poses, arena):
    poses = np.array(poses, np.float32).astype(float)
    assume(math.dist(poses[0, :2], poses[1, :2]) > 2 * BODY_RADIUS + 1e-4)
    if arena.obstacle:
        assume((np.hypot(*poses[:, :2].T) > BODY_RADIUS + OBSTACLE_RADIUS + 1e-4).all())
    world = World(arena)
    world.reset(poses)
    return poses, world.readings.astype(float)


@given(pose | near_pose, near_pose | pose)
@settings(max_examples=200, deadline=None)
def test_camera_sectors_sum_to_the_visible_width(predator, prey):
    poses, seen = sensed([predator, prey], OPEN)
    distance = math.dist(poses[0, :2], poses[1, :2])
    width = 2 * math.asin(BODY_RADIUS / distance) / degrees(45)
    assert seen[:, 24:32].sum(axis=1) == pytest.approx([width] * 2, abs=3e-6)


@given(pose | near_pose, near_pose | pose)
@settings(max_examples=200, deadline=None)
def test_the_obstacle_hides_from_both_or_shows_less(predator, prey):
    _, hidden = sensed([predator, prey], OBSTACLE)
    _, shown = sensed([predator, prey], OPEN)
    assert (hidden[:, 24:32] <= shown[:, 24:32] + 1e-6).all()
    assert (hidden[:, :24] <= shown[:, :24]).all()
    assert (hidden[:, 32:36] == shown[:, 32:36]).all()


@given(pose | near_pose, near_pose | pose, st.booleans())
@settings(max_examples=200, deadline=None)
def test_readings_stay_in_their_ranges(predator, prey, obstacle):
    _, seen = sensed([predator, prey], Arena(obstacle=obstacle))
    assert not np.isnan(seen).any()
    assert seen[:, :24].min() >= 0
    assert seen[:, 24:].min() >= 0
    assert seen[:, 24:].max() <= 1


@given(pose | near_pose, near_pose | pose, st.booleans())
@settings(max_examples=200, deadline=None)
def test_mirrored_robots_sense_the_mirror_image(predator, prey, obstacle):
    arena = Arena(obstacle=obstacle)
    poses, seen = sensed([predator, prey], arena)
    _, mirrored = sensed(poses * (1, -1, -1), arena)
    # a ray along the edge of a disc may hit in one image and miss in the other
    edge = grazing(poses, arena)
    ours = np.minimum(seen[:, :24], INFRARED_RANGE)
    theirs = np.minimum(mirrored[:, 23::-1], INFRARED_RANGE)
    assert np.abs(ours - theirs)[~edge].max() < 2e-5
    assert mirrored[:, 31:23:-1] == pytest.approx(seen[:, 24:32], abs=2e-5)
    left_right = [
        [tuple(p) for p in np.round(GROUND_POSITIONS, 6).tolist()].index((x, -y))
        for x, y in np.round(GROUND_POSITIONS, 6).tolist()
    ]
    assert mirrored[:, 32:36][:, left_right] == pytest.approx(seen[:, 32:36], abs=1e-6)


def grazing(poses, arena):
    """Whether each ray passes within 1e-4 m of the edge of a disc, (2, 24)."""
    angles = poses[:, 2:] + np.radians(7.5 + 15 * np.arange(24))
    edge = np.zeros((2, 24), bool)
    discs = [(poses[::-1, :2], BODY_RADIUS)]
    if arena.obstacle:
        discs.append((np.zeros((2, 2)), OBSTACLE_RADIUS))
    for centre, radius in discs:
        x, y = (centre - poses[:, :2]).T
        beside = np.abs(x[:, None] * np.sin(angles) - y[:, None] * np.cos(angles))
        edge |= np.abs(beside - radius) < 1e-4
    return edge
