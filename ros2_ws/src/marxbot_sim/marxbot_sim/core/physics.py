"""Choosing the physics of an arena by name."""

from marxbot_sensors import MARXBOT
from marxbot_sim.core.fields import check_choice
from marxbot_sim.core.parameters import PHYSICS
from marxbot_sim.core.world import World


def make_world(physics, arena, robot=MARXBOT):
    """Return a world in which two robots can be stepped.

    Parameters
    ----------
    physics : str
        'kinematic' (exact motion, compiled) or 'pymunk' (rigid bodies).
    arena : Arena
    robot : marxbot_sensors.Robot
        Whose sensors both robots have.

    Raises
    ------
    ValueError
        The name is none of `PHYSICS`.
    """
    check_choice('physics', physics, PHYSICS)
    if physics == 'kinematic':
        return World(arena, robot)
    from marxbot_sim.core.pymunk_world import PymunkWorld

    return PymunkWorld(arena, robot)
