"""One episode, recorded tick by tick."""

from dataclasses import dataclass

import numpy as np

from coevo_manager.core.environment import Environment
from coevo_manager.core.episodes.numbering import episode_numbers
from marxbot_sim.core.disturbance import PerturbedRobots
from marxbot_sim.core.physics import make_world
from neuro_controller.core.controller import Controller
from neuro_controller.core.genome import check_genomes


@dataclass(frozen=True)
class Trace:
    """What happened in an episode of t ticks; the axis of length 2 is predator, prey.

    Attributes
    ----------
    poses : float32 array, shape (t + 1, 2, 3)
        x and y in m and heading in rad, at the start and after each tick.
    wheels : float32 array, shape (t, 2, 2)
        Speeds asked of left and right wheel, rad/s.
    readings : float32 array, shape (t, 2, readings)
        What the robots sensed at the start of each tick, see `marxbot_sim.core.layout`.
    inputs, hidden, outputs : float32 arrays, shapes (t, 2, n)
        Neurons after each tick, 0..1.
    ticks : int
        Length of the episode, t.
    captured : bool
        Whether the prey was captured in the last tick.
    """

    poses: np.ndarray
    wheels: np.ndarray
    readings: np.ndarray
    inputs: np.ndarray
    hidden: np.ndarray
    outputs: np.ndarray
    ticks: int
    captured: bool


def trace_pair(predator, prey, environment=Environment(), repetition=0):
    """Play one episode through `World` and `Controller`, which run the batch's functions.

    Parameters
    ----------
    predator, prey : array_like, float32, shape (genes,)
    environment : Environment
    repetition : int
        Which of the pair's episodes, from 0 to below ``environment.repetitions``.

    Returns
    -------
    Trace
        ``ticks`` is what `evaluate_pairs` gives for this pair, summed over its repetitions.

    Examples
    --------
    >>> import red_queen as rq
    >>> hunter, hunted = (
    ...     rq.select_champion('shipped/open', species).genome for species in rq.SPECIES
    ... )
    >>> trace = rq.trace_pair(hunter, hunted)
    >>> trace.poses.shape == (trace.ticks + 1, 2, 3)
    True
    """
    world = make_world(environment.physics, environment.arena, environment.robot)
    robots = PerturbedRobots(environment.perturbations, environment.max_wheel_speeds)
    players = [
        check_genomes(np.atleast_2d(genome), name, environment.layout)[0]
        for name, genome in (('predator', predator), ('prey', prey))
    ]
    opponents = episode_numbers(players[::-1], repetition)
    world.reset(robots.starts(opponents))
    robots.begin(opponents)
    controllers = [
        Controller(genome, speed, **environment.network_settings, robot=environment.robot)
        for genome, speed in zip(players, environment.max_wheel_speeds, strict=True)
    ]
    poses = [world.poses]
    wheels: list[list[np.ndarray]] = []
    readings: list[np.ndarray] = []
    neurons: list[list[tuple[np.ndarray, ...]]] = []
    captured = False
    while not captured and len(wheels) < environment.episode_ticks:
        readings.append(robots.sense(world.readings))
        wheels.append([c.step(r) for c, r in zip(controllers, readings[-1], strict=True)])
        neurons.append([(c.inputs, c.hidden, c.outputs) for c in controllers])
        captured = world.step(robots.drive(wheels[-1])[1])
        poses.append(world.poses)
    inputs, hidden, outputs = (
        np.array([[robot[i] for robot in tick] for tick in neurons]) for i in range(3)
    )
    return Trace(
        np.array(poses),
        np.array(wheels),
        np.array(readings),
        inputs,
        hidden,
        outputs,
        len(wheels),
        captured,
    )
