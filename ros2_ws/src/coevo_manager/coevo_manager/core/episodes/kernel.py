"""The fused episode: eight pairs of robots side by side, lanes refilled as episodes end."""

from typing import NamedTuple

import numba
import numpy as np

from coevo_manager.core.episodes.numbering import episode_number, repeated
from coevo_manager.core.episodes.schedule import IDLE, end_episode, next_episode, row
from marxbot_sim.core.disturbance import begin, disturb_readings, disturb_wheels
from marxbot_sim.core.layout import LEFT, RIGHT
from marxbot_sim.core.motion import move
from marxbot_sim.core.sensing import sense
from marxbot_sim.core.starts import place
from neuro_controller.core.genome import GENE_RANGE
from neuro_controller.core.network import FATIGUE_TICKS, TICKS, control, recall_row
from simd_lanes import HALF, absolute, compile_kernel, kernel_part, lane_bits, load, store

VARIATION, LAST_ADVANCE, LAST_TURN = range(3)
COMPLEXITY_ROWS = 3


class Rows(NamedTuple):
    """The state of the robots of eight episodes, float32 arrays of shape (rows, 16).

    See `marxbot_sim.core.layout` and `neuro_controller.core.network` for their rows; ``start`` has
    the bodies at the start of an episode, ``complexity`` what `add_variation` sums.
    """

    start: np.ndarray
    bodies: np.ndarray
    arena: np.ndarray
    readings: np.ndarray
    weights: np.ndarray
    settings: np.ndarray
    memory: np.ndarray
    history: np.ndarray
    inputs: np.ndarray
    wheels: np.ndarray
    complexity: np.ndarray


@kernel_part
def decide(layout, rows, obstacle, slot, disturbance):
    """Let the robots of eight episodes sense and set their wheels.

    With ``disturbance`` None, a type of its own, this is compiled as if perturbations did not
    exist; otherwise ``disturbance.rolling`` has the wheel speeds with which the robots move.
    """
    sense(layout.robot, rows.bodies, rows.arena, obstacle, rows.readings)
    if disturbance is not None:
        disturb_readings(disturbance, rows.readings)
    control(
        layout,
        rows.readings,
        rows.weights,
        rows.settings,
        rows.memory,
        rows.history,
        slot,
        rows.inputs,
        rows.wheels,
    )
    if disturbance is not None:
        disturb_wheels(disturbance, rows.wheels)


@kernel_part
def move_robots(rows, obstacle, disturbance):
    """Move the robots of eight episodes; return where the prey was captured, as lane bits."""
    if disturbance is not None:
        return lane_bits(move(rows.bodies, disturbance.rolling, rows.arena, obstacle))
    return lane_bits(move(rows.bodies, rows.wheels, rows.arena, obstacle))


@kernel_part
def add_variation(wheels, complexity):
    """Add how much both desired speeds changed since the last tick (paper section 4)."""
    left, right = load(wheels, LEFT), load(wheels, RIGHT)
    advance, turn = (left + right) * 0.5, (right - left) * 0.5
    change = absolute(advance - load(complexity, LAST_ADVANCE)) + absolute(
        turn - load(complexity, LAST_TURN)
    )
    store(complexity, VARIATION, load(complexity, VARIATION) + change)
    store(complexity, LAST_ADVANCE, advance)
    store(complexity, LAST_TURN, turn)


@kernel_part
def _tick(layout, rows, obstacle, slot, measure, episode_ticks, disturbance):
    """Make a tick of eight episodes; return in which of them it was the last, as lane bits."""
    decide(layout, rows, obstacle, slot, disturbance)
    captured = move_robots(rows, obstacle, disturbance)
    if measure:
        add_variation(rows.wheels, rows.complexity)
    return captured | lane_bits(load(rows.memory, TICKS) >= episode_ticks)


@numba.njit
def start_robot(layout, lane, genome, rows):
    """Put a robot at its start, at rest, with that genome's weights in its lane."""
    for i in range(rows.bodies.shape[0]):
        rows.bodies[i, lane] = rows.start[i, lane]
    for i in range(layout.genes):
        rows.weights[i, lane] = genome[i]
    for i in range(layout.leaks, layout.leaks + layout.hidden):
        rows.weights[i, lane] = abs(genome[i]) / GENE_RANGE
    for i in range(recall_row(layout)):
        rows.memory[i, lane] = 0.0
    for i in range(layout.hidden):
        rows.memory[recall_row(layout) + i, lane] = genome[i]
    for i in range(COMPLEXITY_ROWS):
        rows.complexity[i, lane] = 0.0


@numba.njit
def begin_numbered(episode, lane, rows, disturbance, starts, seed):
    """Begin what is random for a robot in its episode of that number."""
    place(starts, lane, seed, episode, rows.bodies)
    if disturbance is not None:
        begin(disturbance, lane, seed, episode)


@numba.njit
def begin_against(opponent, repetition, lane, rows, disturbance, starts, seed):
    """Begin what is random for a robot in one of its episodes against a genome."""
    if disturbance is not None or starts.any():
        episode = repeated(episode_number(opponent), repetition)
        begin_numbered(episode, lane, rows, disturbance, starts, seed)


@compile_kernel
def run_episodes(
    layout,
    lane_episode,
    clock,
    rows,
    obstacle,
    measure,
    episode_ticks,
    disturbance,
    starts,
    seed,
    rings,
):
    """Run episodes until a request is finished, or an episode ends and no other takes its lanes.

    Parameters
    ----------
    layout : neuro_controller.core.genome.Layout
        Of all genomes; its robot is that of all episodes.
    lane_episode : int64 array, shape (8,)
        Number of the episode in each pair of lanes, or `schedule.IDLE`; updated.
    clock : int64 array, shape (1,)
        Ticks run so far; updated.
    rows : Rows
        Updated.
    obstacle : bool
        Whether the cylinder stands at the centre.
    measure : bool
        Whether to sum the behaviours' variation.
    episode_ticks : int
        Length of an episode that no capture ends.
    disturbance : marxbot_sim.core.disturbance.Disturbance or None
        State of the lanes' perturbations; None where there are none after the start.
    starts : float64 array, shape (2, 2)
        How far starts are perturbed, see `marxbot_sim.core.starts.make_starts`.
    seed : int
        Seed of the perturbations.
    rings : schedule.Rings
        What to play; updated.

    Returns
    -------
    bool
        Whether a request was finished.
    """
    finished = played = False
    while True:
        busy = 0
        idle = False
        for pair in range(HALF):
            if lane_episode[pair] == IDLE:
                lane_episode[pair] = next_episode(rings)
                if lane_episode[pair] != IDLE:
                    episode = row(rings.episodes, lane_episode[pair])
                    predator = row(rings.genomes, episode['predator'])
                    prey = row(rings.genomes, episode['prey'])
                    start_robot(layout, pair, predator, rows)
                    start_robot(layout, pair + HALF, prey, rows)
                    number = episode['repetition']
                    begin_against(prey, number, pair, rows, disturbance, starts, seed)
                    begin_against(predator, number, pair + HALF, rows, disturbance, starts, seed)
            if lane_episode[pair] != IDLE:
                busy |= 1 << pair
            else:
                idle = True
        if finished or busy == 0 or (idle and played):
            return finished
        played = True
        ended = 0
        while ended == 0:
            slot = clock[0] % FATIGUE_TICKS
            clock[0] += 1
            ended = _tick(layout, rows, obstacle, slot, measure, episode_ticks, disturbance) & busy
        for pair in range(HALF):
            if ended >> pair & 1:
                ticks = int(rows.memory[TICKS, pair])
                ended_request = end_episode(
                    rings,
                    lane_episode[pair],
                    ticks,
                    rows.complexity[VARIATION, pair] / (2 * ticks),
                    rows.complexity[VARIATION, pair + HALF] / (2 * ticks),
                )
                finished = finished or ended_request
                lane_episode[pair] = IDLE
