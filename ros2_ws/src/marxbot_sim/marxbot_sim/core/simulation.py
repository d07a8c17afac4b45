"""Two robots in an arena, tick by tick, with imperfect sensors and motors: what the simulator node runs."""

import numpy as np

from .drive import dead_reckon
from .layout import CONTACT
from .parameters import START_POSES, Arena
from .perturbations import PerturbedRobot, Perturbations
from .physics import make_world

ROBOTS = ('predator', 'prey')
"""Names of the robots, in the order of every axis that stands for them."""

CONTACT_FORCE = 1.0
"""Force that stands for a contact in kinematic physics, N."""


class Simulation:
    """An endless sequence of episodes in one arena.

    Parameters
    ----------
    arena : Arena
    physics : str
        'kinematic' or 'pymunk'.
    perturbations : Perturbations
        Applied to both robots; each has random streams of its own.

    Attributes
    ----------
    episode : int
        Number of the episode, from 0.
    tick : int
        Ticks made in the episode.
    captured : bool
        Whether the bodies touched during the last tick.
    readings : float32 array, shape (2, 37)
        What each robot reads now, noise included.
    wheels : float32 array, shape (2, 2)
        Speeds of the wheels during the last tick, rad/s.
    odometry : list of two tuples
        x, y in m and heading in rad of each robot by dead reckoning, from 0 at the episode's start.
    """

    def __init__(self, arena=Arena(), physics='kinematic', perturbations=Perturbations()):  # noqa: B008  frozen
        self._physics = physics
        self._world = make_world(physics, arena)
        self.episode = -1
        self.perturb(perturbations)
        self.reset()

    @property
    def arena(self):
        """The arena of this episode."""
        return self._world.arena

    @property
    def bodies(self):
        """Float32 of shape (2, 5): x and y in m, cosine and sine of the heading, contact 0 or 1."""
        return self._world.bodies

    @property
    def contact_forces(self):
        """Force of walls and obstacle on each robot during the last tick, N, shape (2,).

        Kinematic physics knows no forces: a contact counts as `CONTACT_FORCE`.
        """
        if self._physics == 'pymunk':
            return self._world.contact_forces
        return self.bodies[:, CONTACT] * CONTACT_FORCE

    def perturb(self, perturbations):
        """Change how imperfect the robots are, from now on."""
        self._robots = [PerturbedRobot(perturbations, robot) for robot in range(len(ROBOTS))]
        for robot in self._robots:
            robot.reset(max(self.episode, 0))

    def reset(self, poses=START_POSES):
        """Start the next episode.

        Raises
        ------
        ValueError
            A robot would stand in a wall, the obstacle or the other robot; nothing changes then.
        """
        self._world.reset(poses)
        self.episode += 1
        self.tick = 0
        self.captured = False
        self.wheels = np.zeros((2, 2), np.float32)
        self.odometry = [(0.0, 0.0, 0.0)] * len(ROBOTS)
        for robot in self._robots:
            robot.reset(self.episode)
        self._sense()

    def rebuild(self, arena):
        """Start the next episode in another arena.

        Raises
        ------
        ValueError
            The robots' start poses do not fit in it; nothing changes then.
        """
        world = make_world(self._physics, arena)
        self._world = world
        self.reset()

    def step(self, commands):
        """Make one tick.

        Parameters
        ----------
        commands : array_like, shape (2, 2)
            Left and right wheel speed for predator and prey, rad/s.

        Returns
        -------
        bool
            Whether the prey was captured.
        """
        self.wheels = np.stack(
            [robot.drive(command) for robot, command in zip(self._robots, commands, strict=True)]
        )
        self.captured = self._world.step(self.wheels)
        self.odometry = [
            dead_reckon(pose, wheels) for pose, wheels in zip(self.odometry, self.wheels, strict=True)
        ]
        self.tick += 1
        self._sense()
        return self.captured

    def _sense(self):
        readings = self._world.readings
        self.readings = np.stack(
            [robot.sense(reading) for robot, reading in zip(self._robots, readings, strict=True)]
        )
