"""Choosing the physics of an arena by name."""

from marxbot_sim.core.fields import check_choice
from marxbot_sim.core.parameters import PHYSICS
from marxbot_sim.core.world import World


def make_world(physics, arena):
    """Return a world in which two robots can be stepped.

    Parameters
    ----------
    physics : str
        'kinematic' (exact motion, compiled) or 'pymunk' (rigid bodies).
    arena : Arena

    Raises
    ------
    ValueError
        The name is none of `PHYSICS`.
    """
    check_choice('physics', physics, PHYSICS)
    if physics == 'kinematic':
        return World(arena)
    from marxbot_sim.core.pymunk_world import PymunkWorld

    return PymunkWorld(arena)
