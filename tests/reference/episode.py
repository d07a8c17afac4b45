"""A tick and an episode: sense, decide, move, meet."""

from dataclasses import dataclass

import numpy as np

from reference.controller import (
    WINDOW,
    decide,
    inputs,
    spent_energy,
    split,
    tiredness,
    wheel_commands,
)
from reference.motion import gap, press
from reference.sensing import sense

START = np.array([(-0.5, 0, 0), (0.5, 0, np.pi)])


@dataclass(frozen=True)
class Model:
    """The conditions of an episode."""

    obstacle: bool = False
    motor_map: str = 'signed'
    wall_contact: str = 'rigid'
    infrared_response: str = 'squared'
    ground_coding: str = 'relative'
    ticks: int = 1000
    friction: float = 0.5

    @property
    def max_speed(self):
        """Of predator and prey, rad/s."""
        return np.array([10.0 if self.obstacle else 8.5, 10.0])


@dataclass(frozen=True)
class State:
    """Everything that a tick starts from, of n pairs."""

    poses: np.ndarray  # (n, 2, 3) m, m, rad
    contact: np.ndarray  # (n, 2) 0 or 1
    hidden: np.ndarray  # (n, 2, 10)
    spent: np.ndarray  # (n, 2, 200) rs of the last 200 ticks
    passed: np.ndarray  # (n,) ticks passed

    @classmethod
    def start(cls, n, poses=START):
        """The beginning of n episodes."""
        return cls(
            np.broadcast_to(poses, (n, 2, 3)).astype(float),
            np.zeros((n, 2)),
            np.zeros((n, 2, 10)),
            np.zeros((n, 2, WINDOW)),
            np.zeros(n, int),
        )

    def __getitem__(self, rows):
        return State(*(getattr(self, name)[rows] for name in self.__dataclass_fields__))


def behave(state, genes, model):
    """One tick of n pairs.

    Parameters
    ----------
    state : State
    genes : dict
        Genes by name of both robots, each array (n, 2, ...).
    model : Model

    Returns
    -------
    state : State
        After the tick.
    gap : array (n,)
        Least distance of the two rims during the tick, m; not positive = captured.
    record : dict
        ``readings`` (n, 2, 37), ``inputs`` (n, 2, 25), ``hidden`` (n, 2, 10),
        ``outputs`` (n, 2, 2), ``wheels`` (n, 2, 2).
    """
    readings = sense(state.poses, state.contact, model.obstacle)
    tired = tiredness(state.spent)
    clock = np.repeat(state.passed[:, None] / model.ticks, 2, axis=1)
    sensors = inputs(readings, clock, tired, model.infrared_response, model.ground_coding)
    hidden, outputs = decide(genes, sensors, state.hidden)
    wheels = wheel_commands(outputs, tired, model.max_speed, model.motor_map)

    poses, contact = press(state.poses, wheels, model.friction, model.obstacle, model.wall_contact)
    spent = np.concatenate(
        [state.spent[..., 1:], spent_energy(wheels, model.max_speed)[..., None]], axis=-1
    )
    after = State(
        poses,
        contact.astype(float),
        hidden,
        spent,
        state.passed + 1,
    )
    record = {
        'readings': readings,
        'inputs': sensors,
        'hidden': hidden,
        'outputs': outputs,
        'wheels': wheels,
    }
    return after, gap(state.poses[..., :2], poses[..., :2]), record


def play(predators, prey, model, poses=START):
    """Whole episodes of n pairs.

    Parameters
    ----------
    predators, prey : array (n, 442)
    model : Model
    poses : array (2, 3) or (n, 2, 3)
        Where the robots start.

    Returns
    -------
    ticks : int array (n,)
        Capture tick, counted from 1; ``model.ticks`` where there was no capture.
    complexity : array (n, 2)
        Of the behaviour of predator and prey (paper, section 4), rad/s.
    """
    n = len(predators)
    ticks = np.full(n, model.ticks)
    change = np.zeros((n, 2))
    state, speeds = State.start(n, poses), np.zeros((n, 2, 2))
    genes = split(np.stack([predators, prey], axis=1))
    running = np.arange(n)
    for tick in range(1, model.ticks + 1):
        state, distance, record = behave(state, genes, model)
        left, right = np.moveaxis(record['wheels'], -1, 0)
        desired = np.stack([left + right, right - left], axis=-1) / 2
        change[running] += np.abs(desired - speeds).sum(axis=-1)
        speeds = desired
        caught = distance <= 0
        if caught.any():
            ticks[running[caught]] = tick
            free = ~caught
            running, state, speeds = running[free], state[free], speeds[free]
            genes = {name: values[free] for name, values in genes.items()}
    return ticks, change / (2 * ticks[:, None])
