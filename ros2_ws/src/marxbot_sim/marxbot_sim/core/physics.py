"""Choosing the physics of an arena by name."""

from marxbot_sim.core.world import World

PHYSICS = ('kinematic', 'pymunk')
"""Names that `make_world` knows."""


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
    if physics == 'kinematic':
        return World(arena)
    if physics == 'pymunk':
        from marxbot_sim.core.pymunk_world import PymunkWorld

        return PymunkWorld(arena)
    raise ValueError(f'physics is {physics!r}, expected one of {", ".join(PHYSICS)}')
