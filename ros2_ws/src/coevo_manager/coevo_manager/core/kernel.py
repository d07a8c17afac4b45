"""The fused episode: eight pairs of robots side by side, lanes refilled as episodes end."""

import numba

from marxbot_sim.core.disturbance import begin_at, disturb_readings, disturb_wheels
from marxbot_sim.core.layout import LEFT, RIGHT
from marxbot_sim.core.motion import move
from marxbot_sim.core.sensing import sense
from neuro_controller.core.genome import GENE_RANGE, GENES, HIDDEN, HIDDEN_BIASES, LEAKS
from neuro_controller.core.network import FATIGUE_TICKS, MEMORY_ROWS, RECALL, TICKS, control
from simd_lanes import HALF, absolute, compile_kernel, lane_bits, load, store

from .numbering import episode_number
from .schedule import IDLE, end_episode, next_episode, row

VARIATION, LAST_ADVANCE, LAST_TURN = range(3)
COMPLEXITY_ROWS = 3


@numba.njit(forceinline=True)
def decide(
    bodies,
    arena,
    obstacle,
    readings,
    weights,
    settings,
    memory,
    history,
    slot,
    inputs,
    wheels,
    disturbance,
):
    """Let the robots of eight episodes sense and set their wheels.

    With ``disturbance`` None, a type of its own, this is compiled as if perturbations did not
    exist; otherwise ``disturbance.rolling`` has the wheel speeds with which the robots move.
    """
    sense(bodies, arena, obstacle, readings)
    if disturbance is not None:
        disturb_readings(disturbance, readings)
    control(readings, weights, settings, memory, history, slot, inputs, wheels)
    if disturbance is not None:
        disturb_wheels(disturbance, wheels)


@numba.njit(forceinline=True)
def _move(bodies, wheels, arena, obstacle, disturbance):
    """Move the robots of eight episodes; return where the prey was captured, as lane bits."""
    if disturbance is not None:
        return lane_bits(move(bodies, disturbance.rolling, arena, obstacle))
    return lane_bits(move(bodies, wheels, arena, obstacle))


@numba.njit(forceinline=True)
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


@numba.njit
def start_robot(lane, genome, start, bodies, weights, memory, complexity):
    """Put a robot at its start, at rest, with that genome's weights in its lane."""
    for i in range(bodies.shape[0]):
        bodies[i, lane] = start[i, lane]
    for i in range(GENES):
        weights[i, lane] = genome[i]
    for i in range(LEAKS, LEAKS + HIDDEN):
        weights[i, lane] = abs(genome[i]) / GENE_RANGE
    for i in range(MEMORY_ROWS):
        memory[i, lane] = 0.0
    for i in range(HIDDEN):
        memory[RECALL + i, lane] = genome[HIDDEN_BIASES + i]
    for i in range(COMPLEXITY_ROWS):
        complexity[i, lane] = 0.0


@compile_kernel
def run_episodes(
    lane_episode,
    clock,
    start,
    bodies,
    arena,
    obstacle,
    readings,
    weights,
    settings,
    memory,
    history,
    inputs,
    wheels,
    complexity,
    measure,
    episode_ticks,
    disturbance,
    seed,
    rings,
):
    """Run episodes until a request is finished, or an episode ends and no other takes its lanes.

    Parameters
    ----------
    lane_episode : int64 array, shape (8,)
        Number of the episode in each pair of lanes, or `schedule.IDLE`; updated.
    clock : int64 array, shape (1,)
        Ticks run so far; updated.
    start, bodies, ..., complexity : float32 arrays, shape (rows, 16)
        State of the lanes, see `marxbot_sim.core.layout` and `neuro_controller.core.network`.
    measure : bool
        Whether to sum the behaviours' variation.
    episode_ticks : int
        Length of an episode that no capture ends.
    disturbance : marxbot_sim.core.disturbance.Disturbance or None
        State of the lanes' perturbations; None where there are none.
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
                    start_robot(pair, predator, start, bodies, weights, memory, complexity)
                    start_robot(pair + HALF, prey, start, bodies, weights, memory, complexity)
                    if disturbance is not None:
                        begin_at(disturbance, pair, seed, episode_number(prey), bodies)
                        begin_at(disturbance, pair + HALF, seed, episode_number(predator), bodies)
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
            decide(
                bodies,
                arena,
                obstacle,
                readings,
                weights,
                settings,
                memory,
                history,
                slot,
                inputs,
                wheels,
                disturbance,
            )
            captured = _move(bodies, wheels, arena, obstacle, disturbance)
            if measure:
                add_variation(wheels, complexity)
            ended = (captured | lane_bits(load(memory, TICKS) >= episode_ticks)) & busy
        for pair in range(HALF):
            if ended >> pair & 1:
                ticks = int(memory[TICKS, pair])
                ended_request = end_episode(
                    rings,
                    lane_episode[pair],
                    ticks,
                    complexity[VARIATION, pair] / (2 * ticks),
                    complexity[VARIATION, pair + HALF] / (2 * ticks),
                )
                finished = finished or ended_request
                lane_episode[pair] = IDLE
