"""The fused episode: eight pairs of robots side by side, lanes refilled as episodes end."""

import numba

from marxbot_sim.core.disturbance import begin_at, disturb_readings, disturb_wheels
from marxbot_sim.core.layout import LEFT, RIGHT
from marxbot_sim.core.motion import move
from marxbot_sim.core.sensing import sense
from neuro_controller.core.genome import GENES, HIDDEN, HIDDEN_BIASES
from neuro_controller.core.network import FATIGUE_TICKS, MEMORY_ROWS, RECALL, TICKS, control
from simd_lanes import HALF, absolute, compile_kernel, lane_bits, load, store

IDLE = -1
"""In `lane_episode`: no episode runs in this pair of lanes."""

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
    for row in range(bodies.shape[0]):
        bodies[row, lane] = start[row, lane]
    for row in range(GENES):
        weights[row, lane] = genome[row]
    for row in range(MEMORY_ROWS):
        memory[row, lane] = 0.0
    for row in range(HIDDEN):
        memory[RECALL + row, lane] = genome[HIDDEN_BIASES + row]
    for row in range(COMPLEXITY_ROWS):
        complexity[row, lane] = 0.0


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
    genomes,
    genome_number,
    predator_row,
    prey_row,
    request,
    unfinished,
    result_ticks,
    result_complexity,
    first,
    end,
):
    """Run queued episodes until a request is finished or none is left.

    Parameters
    ----------
    lane_episode : int64 array, shape (8,)
        Number of the episode in each pair of lanes, or IDLE; updated.
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
    genomes, genome_number : float32 array, shape (g, 442), and uint64 array, shape (g,)
        Rings of weights and of their opponents' episode numbers, g a power of two.
    predator_row, prey_row, request : int64 arrays, shape (e,), e a power of two
        Ring of episodes: the rows of `genomes`, modulo g, and the request that asked.
    unfinished : int64 array, shape (r,), r a power of two
        Ring of requests: episodes left of each; updated.
    result_ticks, result_complexity : int32 array, shape (e,), and float32 array, shape (e, 2)
        Written as episodes end.
    first, end : int
        Number of the next episode to start and of the one after the last.

    Returns
    -------
    (int, bool)
        Number of the next episode to start, and whether a request was finished.
    """
    episode_mask = len(request) - 1
    genome_mask = len(genomes) - 1
    request_mask = len(unfinished) - 1
    finished = False
    while True:
        busy = 0
        for pair in range(HALF):
            if lane_episode[pair] == IDLE and first < end:
                row = first & episode_mask
                predator = genomes[predator_row[row] & genome_mask]
                prey = genomes[prey_row[row] & genome_mask]
                start_robot(pair, predator, start, bodies, weights, memory, complexity)
                start_robot(pair + HALF, prey, start, bodies, weights, memory, complexity)
                if disturbance is not None:
                    number = genome_number[predator_row[row] & genome_mask]
                    begin_at(disturbance, pair + HALF, seed, number, bodies)
                    number = genome_number[prey_row[row] & genome_mask]
                    begin_at(disturbance, pair, seed, number, bodies)
                lane_episode[pair] = first
                first += 1
            if lane_episode[pair] != IDLE:
                busy |= 1 << pair
        if finished or busy == 0:
            return first, finished
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
                row = lane_episode[pair] & episode_mask
                ticks = int(memory[TICKS, pair])
                result_ticks[row] = ticks
                result_complexity[row, 0] = complexity[VARIATION, pair] / (2 * ticks)
                result_complexity[row, 1] = complexity[VARIATION, pair + HALF] / (2 * ticks)
                asker = request[row] & request_mask
                unfinished[asker] -= 1
                finished = finished or unfinished[asker] == 0
                lane_episode[pair] = IDLE
