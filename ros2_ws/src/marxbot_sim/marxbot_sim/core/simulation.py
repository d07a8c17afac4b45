"""Two robots in an arena, tick by tick, as imperfect as asked: what the simulator node runs."""

import numpy as np

from marxbot_sim.core.disturbance import PerturbedRobots
from marxbot_sim.core.layout import CONTACT
from marxbot_sim.core.odometry import Odometry
from marxbot_sim.core.parameters import PREY_WHEEL_SPEED, ROBOTS, Arena
from marxbot_sim.core.perturbations import PERFECT
from marxbot_sim.core.physics import make_world

CONTACT_FORCE = 1.0
"""Force that stands for a contact in kinematic physics, N."""


class Simulation:
    """An endless sequence of episodes in one arena.

    Parameters
    ----------
    arena : Arena
    physics : str
        'kinematic' or 'pymunk'.
    perturbations : marxbot_sim.core.perturbations.Perturbations
    max_wheel_speed : float
        Highest speed of a wheel with a full battery, rad/s.

    Attributes
    ----------
    episode : int
        Number of the episode, from 0.
    numbers : tuple of two int or None
        Under which predator and prey draw what is random, from the next episode on, see
        `PerturbedRobots.begin`; None takes the number of the episode.
    tick : int
        Ticks made in the episode.
    captured : bool
        Whether the bodies touched during the last tick.
    readings : float32 array, shape (2, readings)
        What each robot reads now, noise included.
    wheels : float32 array, shape (2, 2)
        Speeds of the wheels during the last tick, rad/s, as their encoders count them.
    odometry : list of two Odometry
        Dead reckoning of each robot, from 0 at the episode's start.
    """

    def __init__(
        self,
        arena=Arena(),
        physics='kinematic',
        perturbations=PERFECT,
        max_wheel_speed=PREY_WHEEL_SPEED,
    ):
        self._physics = physics
        self._max_wheel_speed = max_wheel_speed
        self._world = make_world(physics, arena)
        self.episode = -1
        self.numbers = None
        self.perturb(perturbations)
        self.reset()

    @property
    def arena(self):
        """The arena of this episode."""
        return self._world.arena

    @property
    def poses(self):
        """Float32 of shape (2, 3): x and y in m, heading in rad."""
        return self._world.poses

    @property
    def contact_forces(self):
        """Force of what each robot touched, mean over the last tick, N, shape (2,).

        Kinematic physics knows no forces: a contact counts as `CONTACT_FORCE`.
        """
        if self._physics == 'pymunk':
            return self._world.contact_forces
        return self._world.bodies[:, CONTACT] * CONTACT_FORCE

    def perturb(self, perturbations):
        """Change how imperfect the robots are, from now on; starts from the next episode on."""
        self._motor_noises = perturbations.motor_noises
        self._robots = PerturbedRobots(perturbations, [self._max_wheel_speed] * len(ROBOTS))
        self._robots.begin(self._numbers(max(self.episode, 0)))

    def reset(self, poses=None):
        """Start the next episode.

        Parameters
        ----------
        poses : array_like, shape (2, 3), optional
            x and y in m and heading in rad, of predator and prey; without them the usual start, as
            far as it is not perturbed.

        Raises
        ------
        ValueError
            A robot would stand in a wall, the obstacle or the other robot; nothing changes then.
        """
        self._begin(self._world, poses)

    def rebuild(self, arena):
        """Start the next episode in another arena.

        Raises
        ------
        ValueError
            The robots' start poses do not fit in it; nothing changes then.
        """
        self._begin(make_world(self._physics, arena), None)

    def _begin(self, world, poses):
        episode = self.episode + 1
        world.reset(self._robots.starts(self._numbers(episode)) if poses is None else poses)
        self._world = world
        self.episode = episode
        self.tick = 0
        self.captured = False
        self.wheels = np.zeros((2, 2), np.float32)
        self.odometry = [Odometry() for _ in ROBOTS]
        self._robots.begin(self._numbers(episode))
        self.readings = self._robots.sense(world.readings)

    def _numbers(self, episode):
        return self.numbers or (episode,) * len(ROBOTS)

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
        self.wheels, rolling = self._robots.drive(commands)
        self.captured = self._world.step(rolling)
        forces = self.contact_forces
        for robot, odometry in enumerate(self.odometry):
            held = self.captured or bool(forces[robot] > 0)
            odometry.advance(self.wheels[robot], self._motor_noises[robot], held)
        self.tick += 1
        self.readings = self._robots.sense(self._world.readings)
        return self.captured
