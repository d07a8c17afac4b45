"""One tick of the compiled physics against the reference, from thousands of states."""

import numpy as np
import pytest
from reference import gap, press, sense
from reference.samples import compared, envelope, outside, scattered

from marxbot_sim.core.parameters import INFRARED_RANGE, Arena
from marxbot_sim.core.world import World

N = 2000


@pytest.mark.parametrize('obstacle', [False, True])
def test_sensors(obstacle):
    poses = scattered(np.random.default_rng(5), N, obstacle)
    world = World(Arena(obstacle=obstacle))
    readings = np.empty((N, 2, 37))
    for k in range(N):
        world.reset(poses[k])
        readings[k] = world.readings
    low, high = envelope(lambda poses: compared(sense(poses, np.zeros((N, 2)), obstacle)), poses)
    error = outside(compared(readings), low, high)
    assert error.max() < 1e-6
    # the envelope hides nothing: nearly everywhere it is as narrow as float32
    assert (high - low > 1e-4).mean() < 1e-3
    seen = compared(readings)
    assert (seen[..., :24] < INFRARED_RANGE).mean() > 0.05
    assert (seen[..., 24:32] > 0).mean() > 0.1


@pytest.mark.parametrize(
    ('wall_contact', 'friction'),
    [('rigid', 0.5), ('rigid', 3.0), ('slide', 0.0), ('slide', 0.5), ('undo', 0.5)],
)
@pytest.mark.parametrize('obstacle', [False, True])
def test_motion_and_capture(obstacle, wall_contact, friction):
    rng = np.random.default_rng(6)
    poses = scattered(rng, N, obstacle)
    wheels = rng.uniform(-10, 10, (N, 2, 2)).astype(np.float32)
    wheels[::2] = 10 * np.sign(wheels[::2, :, :1])
    world = World(Arena(3.0, obstacle, friction, wall_contact))
    bodies, captured = np.empty((N, 2, 5)), np.empty(N, bool)
    for k in range(N):
        world.reset(poses[k])
        captured[k] = world.step(wheels[k])
        bodies[k] = world.bodies

    def moved(poses):
        after, contact = press(poses, wheels.astype(float), friction, obstacle, wall_contact)
        x, y, heading = np.moveaxis(after, -1, 0)
        return np.stack([x, y, np.cos(heading), np.sin(heading), contact], axis=-1)

    low, high = envelope(moved, poses)
    error = outside(bodies, low, high)
    assert error[..., [0, 1, 4]].max() < 1e-6
    # a turn is 21 rad for each metre that friction took, which float32 knows to 1e-7 m
    assert error[..., 2:4].max() < (5e-6 if wall_contact == 'rigid' else 1e-6)
    assert ((high - low)[..., 4] > 0).mean() < 1e-3
    assert 0.05 < bodies[..., 4].mean() < 0.9

    apart = gap(poses[..., :2], moved(poses)[..., :2])
    clear = np.abs(apart) > 1e-6
    assert (captured == (apart <= 0))[clear].all()
    assert clear.mean() > 0.999
    assert 0.01 < captured.mean() < 0.99
