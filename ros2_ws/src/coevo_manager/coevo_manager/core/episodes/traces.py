"""Many episodes, recorded tick by tick: the batch's functions, eight pairs at a time."""

from collections.abc import Iterator

import numpy as np

from coevo_manager.core.environment import Environment
from coevo_manager.core.episodes.kernel import begin_against, decide, start_robot
from coevo_manager.core.episodes.lanes import EpisodeLanes
from coevo_manager.core.episodes.trace import Trace, trace_pair
from marxbot_sim.core.layout import BODY_ROWS, COSINE, SINE, WHEEL_ROWS, X, Y
from marxbot_sim.core.motion import move
from neuro_controller.core.genome import OUTPUTS
from neuro_controller.core.network import FATIGUE_TICKS, MOTORS, STATE, recall_row
from simd_lanes import HALF, LANES, compile_kernel, lane_bits


@compile_kernel
def _start(layout, pair, predator, prey, rows, disturbance, starts, seed):
    """Start an episode in a pair of lanes."""
    start_robot(layout, pair, predator, rows)
    start_robot(layout, pair + HALF, prey, rows)
    begin_against(prey, 0, pair, rows, disturbance, starts, seed)
    begin_against(predator, 0, pair + HALF, rows, disturbance, starts, seed)


@compile_kernel
def _tick(layout, rows, obstacle, slot, disturbance):
    """Run one tick of eight episodes; return where the prey was captured, as lane bits."""
    decide(layout, rows, obstacle, slot, disturbance)
    if disturbance is not None:
        return lane_bits(move(rows.bodies, disturbance.rolling, rows.arena, obstacle))
    return lane_bits(move(rows.bodies, rows.wheels, rows.arena, obstacle))


def trace_pairs(
    predators: np.ndarray,
    prey: np.ndarray,
    predator_index: np.ndarray,
    prey_index: np.ndarray,
    environment: Environment = Environment(),
) -> Iterator[Trace]:
    """Yield the `Trace` of each pair, in order; some forty times faster than `trace_pair`.

    Parameters
    ----------
    predators, prey : float32 arrays, shapes (p, genes) and (q, genes)
    predator_index, prey_index : integer arrays, shape (n,)
        Which predator meets which prey.
    environment : Environment

    Examples
    --------
    >>> import numpy as np
    >>> import red_queen as rq
    >>> hunters, hunted = rq.random_genomes(6, np.random.default_rng(1)).reshape(2, 3, -1)
    >>> [trace.ticks for trace in rq.trace_pairs(hunters, hunted, [0, 2], [1, 1])]
    [1000, 1000]
    """
    pairs = list(zip(predators[predator_index], prey[prey_index], strict=True))
    if environment.physics != 'kinematic':
        for pair in pairs:
            yield trace_pair(*pair, environment)
        return
    for start in range(0, len(pairs), HALF):
        yield from _trace_eight(pairs[start : start + HALF], environment)


def _trace_eight(
    pairs: list[tuple[np.ndarray, np.ndarray]], environment: Environment
) -> Iterator[Trace]:
    lanes = EpisodeLanes(environment)
    rows, disturbance = lanes.rows, lanes.disturbance
    for k, pair in enumerate(pairs):
        _start(
            lanes.layout, k, *pair, rows, disturbance, lanes.starts, environment.perturbations.seed
        )
    longest = environment.episode_ticks
    bodies = np.empty((longest + 1, BODY_ROWS, LANES), np.float32)
    wheels = np.empty((longest, WHEEL_ROWS, LANES), np.float32)
    readings = np.empty((longest, *rows.readings.shape), np.float32)
    inputs = np.empty((longest, *rows.inputs.shape), np.float32)
    neurons = recall_row(lanes.layout)
    memory = np.empty((longest, neurons, LANES), np.float32)
    bodies[0] = rows.bodies
    ticks = np.full(len(pairs), longest)
    captured = np.zeros(len(pairs), bool)
    tick = 0
    while tick < longest and not captured.all():
        bits = _tick(lanes.layout, rows, environment.obstacle, tick % FATIGUE_TICKS, disturbance)
        wheels[tick], readings[tick], inputs[tick] = rows.wheels, rows.readings, rows.inputs
        memory[tick] = rows.memory[:neurons]
        tick += 1
        bodies[tick] = rows.bodies
        for k in range(len(pairs)):
            if bits >> k & 1 and not captured[k]:
                captured[k], ticks[k] = True, tick
    for k in range(len(pairs)):
        own, end = [k, k + HALF], int(ticks[k])

        def of_robots(tape: np.ndarray, first: int, last: int, end: int, own=own) -> np.ndarray:
            return np.ascontiguousarray(tape[:end, first:last, own].swapaxes(1, 2))

        body = of_robots(bodies, 0, BODY_ROWS, end + 1)
        heading = np.arctan2(body[..., SINE], body[..., COSINE])
        yield Trace(
            np.stack([body[..., X], body[..., Y], heading], axis=-1),
            of_robots(wheels, 0, WHEEL_ROWS, end),
            of_robots(readings, 0, len(rows.readings), end),
            of_robots(inputs, 0, len(rows.inputs), end),
            of_robots(memory, STATE, neurons, end),
            of_robots(memory, MOTORS, MOTORS + OUTPUTS, end),
            end,
            bool(captured[k]),
        )
