"""The reference itself, checked by other means: sampling, small steps, hand."""

import numpy as np
import pytest
from reference import arc, gap, sense
from reference.motion import TICK, WHEEL_RADIUS, WHEEL_SEPARATION
from reference.samples import scattered
from reference.sensing import BODY_RADIUS, OBSTACLE_RADIUS, ray_to_disc


@pytest.mark.parametrize('obstacle', [False, True])
def test_camera_equals_a_count_of_rays_that_end_on_the_opponent(obstacle):
    poses = scattered(np.random.default_rng(1), 60, obstacle)
    rays = 2000
    angles = poses[..., 2:] + 2 * np.pi * (np.arange(8 * rays) + 0.5) / (8 * rays)
    direction = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    origin = poses[..., None, :2]
    opponent = ray_to_disc(origin, direction, poses[:, ::-1, None, :2], BODY_RADIUS)
    if obstacle:
        hidden = ray_to_disc(origin, direction, np.zeros(2), OBSTACLE_RADIUS)
        opponent = np.where(hidden < opponent, np.inf, opponent)
    counted = np.isfinite(opponent).reshape(60, 2, 8, rays).mean(axis=-1)
    camera = sense(poses, np.zeros((60, 2)), obstacle)[..., 24:32]
    assert np.abs(camera - counted).max() < 2 / rays
    assert camera.max() > 0.9


def test_infrared_ends_on_a_surface():
    poses = scattered(np.random.default_rng(2), 300, True)
    distance = sense(poses, np.zeros((300, 2)), True)[..., :24]
    angles = poses[..., 2:] + np.radians(7.5 + 15 * np.arange(24))
    direction = np.stack([np.cos(angles), np.sin(angles)], axis=-1)

    def clearance(length):
        at = poses[..., None, :2] + (BODY_RADIUS + length[..., None]) * direction
        wall = 1.5 - np.abs(at).max(axis=-1)
        obstacle = np.hypot(at[..., 0], at[..., 1]) - OBSTACLE_RADIUS
        away = at - poses[:, ::-1, None, :2]
        return np.minimum.reduce(
            [wall, obstacle, np.hypot(away[..., 0], away[..., 1]) - BODY_RADIUS]
        )

    assert np.abs(clearance(distance)).max() < 1e-12
    for part in np.linspace(0, 0.999, 30):
        assert clearance(part * distance).min() > -1e-12


def test_arc_equals_many_small_straight_steps():
    rng = np.random.default_rng(3)
    heading, wheels = rng.uniform(-np.pi, np.pi, 50), rng.uniform(-10, 10, (50, 2))
    wheels[0] = 4.0
    displacement, turn = arc(heading, wheels)
    steps = 20000
    speed = WHEEL_RADIUS * wheels.mean(axis=1) * TICK / steps
    angular = WHEEL_RADIUS * (wheels[:, 1] - wheels[:, 0]) / WHEEL_SEPARATION * TICK / steps
    middle = heading[:, None] + angular[:, None] * (np.arange(steps) + 0.5)
    assert np.allclose(turn, angular * steps, atol=1e-12)
    assert np.allclose(displacement[:, 0], speed * np.cos(middle).sum(axis=1), atol=1e-9)
    assert np.allclose(displacement[:, 1], speed * np.sin(middle).sum(axis=1), atol=1e-9)


def test_gap_equals_the_least_of_many_moments():
    rng = np.random.default_rng(4)
    starts, ends = rng.uniform(-0.3, 0.3, (2, 100, 2, 2))
    moments = np.linspace(0, 1, 5001)[:, None, None, None]
    between = (1 - moments) * starts + moments * ends
    apart = np.hypot(*np.moveaxis(between[:, :, 1] - between[:, :, 0], -1, 0))
    assert np.allclose(gap(starts, ends), apart.min(axis=0) - 2 * BODY_RADIUS, atol=2e-4)
