"""Many episodes tick by tick, with motor neurons that are set from outside."""

import numba
import numpy as np

from coevo_manager.core.environment import Environment
from coevo_manager.core.episodes.kernel import Rows, begin_numbered, move_robots, start_robot
from coevo_manager.core.episodes.lanes import EpisodeLanes
from marxbot_sim.core.disturbance import Disturbance, disturb_readings, disturb_wheels
from marxbot_sim.core.layout import COSINE, SINE, X, Y
from marxbot_sim.core.sensing import sense
from neuro_controller.core.genome import OUTPUTS
from neuro_controller.core.network import (
    FATIGUE_TICKS,
    MOTORS,
    TICKS,
    drive,
    perceive,
    recall,
    think,
)
from simd_lanes import HALF, aligned_rows, compile_kernel, kernel_part


@numba.njit
def _block(rows, k):
    """Return the rows of the k-th eight episodes."""
    return Rows(
        rows.start[k],
        rows.bodies[k],
        rows.arena[k],
        rows.readings[k],
        rows.weights[k],
        rows.settings[k],
        rows.memory[k],
        rows.history[k],
        rows.inputs[k],
        rows.wheels[k],
        rows.complexity[k],
    )


@numba.njit
def _own(disturbance, k):
    """Return what disturbs the k-th eight episodes."""
    if disturbance is None:
        return None
    return Disturbance(
        disturbance.settings[k],
        disturbance.counters[k],
        disturbance.words[k],
        disturbance.held[k],
        disturbance.queue[k],
        disturbance.clock[k],
        disturbance.latency,
        disturbance.worn,
        disturbance.turning[k],
        disturbance.rolling[k],
    )


@kernel_part
def _perceive(layout, rows, obstacle, disturbance):
    """Let the robots of eight episodes sense, up to their sensory neurons."""
    sense(layout.robot, rows.bodies, rows.arena, obstacle, rows.readings)
    if disturbance is not None:
        disturb_readings(disturbance, rows.readings)
    perceive(layout, rows.readings, rows.memory, rows.settings, rows.inputs)


@kernel_part
def _act(layout, rows, actions, driven, first, obstacle, slot, disturbance):
    """Make the rest of a tick of eight episodes; return where the prey was captured, as bits.

    Motor neurons are the networks', but those of robots that are driven from outside.
    """
    if not (driven[0] and driven[1]):
        think(layout, rows.weights, rows.memory, rows.inputs)
        recall(layout, rows.weights, rows.memory)
    for robot in range(2):
        if driven[robot]:
            for pair in range(HALF):
                for motor in range(OUTPUTS):
                    action = actions[robot, first + pair, motor]
                    rows.memory[MOTORS + motor, robot * HALF + pair] = min(max(action, 0.0), 1.0)
    drive(layout, rows.memory, rows.inputs, rows.settings, rows.history, slot, rows.wheels)
    if disturbance is not None:
        disturb_wheels(disturbance, rows.wheels)
    return move_robots(rows, obstacle, disturbance)


@numba.njit
def _copy_inputs(rows, driven, first, observations):
    """Copy the sensory neurons of the robots that are driven from outside."""
    for robot in range(2):
        if driven[robot]:
            for pair in range(HALF):
                for neuron in range(rows.inputs.shape[0]):
                    value = rows.inputs[neuron, robot * HALF + pair]
                    observations[robot, first + pair, neuron] = min(max(value, 0.0), 1.0)


@numba.njit
def _rest(lane, rows):
    """Put a robot that is driven from outside at its start, at rest; it has no weights."""
    for i in range(rows.bodies.shape[0]):
        rows.bodies[i, lane] = rows.start[i, lane]
    for i in range(rows.memory.shape[0]):
        rows.memory[i, lane] = 0.0


@compile_kernel
def _tick(layout, rows, actions, driven, obstacle, slot, disturbance, observations, captured):
    """Make a tick of all episodes, and let their robots sense."""
    for k in range(rows.bodies.shape[0]):
        block, own, first = _block(rows, k), _own(disturbance, k), k * HALF
        bits = _act(layout, block, actions, driven, first, obstacle, slot, own)
        for pair in range(HALF):
            captured[first + pair] = bits >> pair & 1
        _perceive(layout, block, obstacle, own)
        _copy_inputs(block, driven, first, observations)


@compile_kernel
def _begin(
    layout,
    rows,
    pairs,
    genomes,
    numbers,
    driven,
    obstacle,
    disturbance,
    starts,
    seed,
    observations,
):
    """Begin some of the episodes, and let the robots of their blocks sense.

    Where robots sense twice in a tick they find the same: their noise depends on the tick alone.
    """
    touched = np.zeros(rows.bodies.shape[0], np.bool_)
    for i in range(len(pairs)):
        k, pair = pairs[i] // HALF, pairs[i] % HALF
        touched[k] = True
        block, own = _block(rows, k), _own(disturbance, k)
        for robot in range(2):
            lane = pair + robot * HALF
            if driven[robot]:
                _rest(lane, block)
            else:
                start_robot(layout, lane, genomes[i], block)
            begin_numbered(numbers[i, robot], lane, block, own, starts, seed)
    for k in range(len(touched)):
        if touched[k]:
            block, own = _block(rows, k), _own(disturbance, k)
            _perceive(layout, block, obstacle, own)
            _copy_inputs(block, driven, k * HALF, observations)


def _stacked(arrays):
    """Return arrays of rows as one, each block of rows aligned as it was."""
    first = arrays[0]
    whole = aligned_rows(len(arrays) * len(first), first.dtype).reshape(len(arrays), *first.shape)
    whole[:] = arrays
    return whole


def _stack_disturbances(parts):
    if parts[0] is None:
        return None
    rows = {
        name: _stacked([getattr(part, name) for part in parts])
        for name in Disturbance._fields
        if np.ndim(getattr(parts[0], name)) == 2
    }
    return parts[0]._replace(**rows, clock=np.zeros((len(parts), 1), np.int64))


class SteppedEpisodes:
    """Episodes side by side, of which one robot or both are driven from outside.

    A tick is the kernel's, in the kernel's lanes; it only ends where a robot has sensed, and goes
    on where its motor neurons are known. So an episode whose motors a genome's network sets
    outside equals that genome's episode in the kernel, bit for bit.

    Parameters
    ----------
    environment : Environment
        Its physics must be kinematic.
    count : int
        Number of episodes.
    driven : tuple of two bool
        Whether predator and prey are driven from outside; the other's motors are its genome's.

    Attributes
    ----------
    actions : float32 array, shape (2, count, 2)
        Motor neurons tm and rm of predators and prey in the next tick; kept within 0..1.
    observations : float32 array, shape (2, count, inputs)
        Sensory neurons of the robots that are driven, kept within 0..1. They leave it only where
        two bodies overlap, after a capture.
    captured : bool array, shape (count,)
        Whether the prey was captured in the last tick.

    Raises
    ------
    ValueError
        The physics is another.
    """

    def __init__(self, environment=Environment(), count=1, driven=(True, True)):
        if environment.physics != 'kinematic':
            raise ValueError(f'physics is {environment.physics!r}, expected kinematic')
        self.environment = environment
        self._layout = environment.layout
        self._count = count
        lanes = [EpisodeLanes(environment) for _ in range(-(-count // HALF))]
        self._rows = Rows(*map(_stacked, zip(*(each.rows for each in lanes), strict=True)))
        self._disturbance = _stack_disturbances([each.disturbance for each in lanes])
        self._starts = lanes[0].starts
        self._driven = np.array(driven, np.bool_)
        self._clock = 0
        padded = len(lanes) * HALF
        self._actions = np.full((2, padded, OUTPUTS), 0.5, np.float32)
        self._observations = np.zeros((2, padded, self._layout.inputs), np.float32)
        self._captured = np.zeros(padded, np.bool_)
        self.actions = self._actions[:, :count]
        self.observations = self._observations[:, :count]
        self.captured = self._captured[:count]

    def begin(self, pairs, numbers, opponents=None):
        """Begin an episode in some places, whatever went on there.

        Parameters
        ----------
        pairs : int64 array, shape (k,)
            Places, from 0 to below `count`.
        numbers : uint64 array, shape (k, 2)
            Under which predator and prey draw their starts and noise, as
            `coevo_manager.core.episodes.numbering.episode_numbers` gives them for genomes.
        opponents : float32 array, shape (k, genes), optional
            Genomes of the robots that are not driven.
        """
        if opponents is None:
            opponents = np.zeros((0, self._layout.genes), np.float32)
        _begin(
            self._layout,
            self._rows,
            np.asarray(pairs, np.int64),
            opponents,
            np.asarray(numbers, np.uint64),
            self._driven,
            self.environment.obstacle,
            self._disturbance,
            self._starts,
            self.environment.perturbations.seed,
            self._observations,
        )

    def step(self):
        """Make a tick of all episodes with the `actions` there are; they go on after a capture."""
        _tick(
            self._layout,
            self._rows,
            self._actions,
            self._driven,
            self.environment.obstacle,
            self._clock % FATIGUE_TICKS,
            self._disturbance,
            self._observations,
            self._captured,
        )
        self._clock += 1

    @property
    def ticks(self):
        """Ticks made of each episode, int64, shape (count,)."""
        return self._rows.memory[:, TICKS, :HALF].reshape(-1)[: self._count].astype(np.int64)

    def poses(self, pair):
        """Return x and y in m and heading in rad of both robots, float32, shape (2, 3)."""
        block, lane = divmod(pair, HALF)
        body = self._rows.bodies[block][:, [lane, lane + HALF]]
        return np.column_stack([body[X], body[Y], np.arctan2(body[SINE], body[COSINE])])
