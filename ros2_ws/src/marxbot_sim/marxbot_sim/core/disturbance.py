"""Perturbations at work on the 16 robots of a batch, and on the two of one arena."""

import math
from collections import namedtuple

import numba
import numpy as np

from marxbot_sim.core.layout import (
    CAMERA,
    GROUND,
    INFRARED,
    LEFT,
    RIGHT,
    WHEEL_ROWS,
)
from marxbot_sim.core.parameters import (
    BODY_RADIUS,
    CAMERA_SECTORS,
    GROUND_POSITIONS,
    INFRARED_RANGE,
    INFRARED_RAYS,
)
from marxbot_sim.core.perturbations import MAX_LATENCY_TICKS, PERFECT
from marxbot_sim.core.randomness import (
    NORMAL_DEVIATION,
    eight_normals,
    fractions,
    mix_tick,
    random_words,
)
from marxbot_sim.core.starts import episode_key, make_starts, start_pose
from marxbot_sim.core.world import ROBOT_LANES
from simd_lanes import (
    HALF,
    aligned_rows,
    any_lane,
    compile_kernel,
    fma,
    kernel_part,
    load,
    maximum,
    minimum,
    select,
    store,
)

(
    INFRARED_NOISE,
    CAMERA_NOISE,
    GROUND_NOISE,
    MOTOR_NOISE,
    LATENCY,
    SPEED_LIMIT,
    LOSS,
    ADVANCE_SCALE,
    TURN_SCALE,
) = range(9)
SETTING_ROWS = 9

_FIRST_KEY, _SECOND_KEY, _AGE = range(3)
_COUNTER_ROWS = 3

_SLOTS = MAX_LATENCY_TICKS + 1

# Rows of `words`. A word makes eight normal values: those of eight rays, of the eight sectors, of
# the four ground sensors and the two wheels.
_FOR_RAYS, _FOR_SECTORS, _FOR_GROUND_AND_WHEELS, _FOR_LOSS = 0, 3, 4, 5
_WORD_ROWS = 6

Disturbance = namedtuple(
    'Disturbance', 'settings counters words held queue clock latency worn turning rolling'
)
"""State of the perturbations of 16 robots.

settings : float32 (SETTING_ROWS, 16), by robot; noise in units of `NORMAL_DEVIATION`
counters : uint32 (3, 16), two words of the episode's key, and ticks since the episode's start
words : uint32 (6, 16), random bits of the tick to come
held : float32 (2, 16), last command that was not lost, rad/s
queue : float32 (22, 16), commands of the last ticks, rad/s
clock : int64 (1,), ticks in which commands were late, of whatever episodes
latency : int, ticks by which a command takes effect late where it does
worn : bool, whether a robot's battery is not full, or its wheels are not as they should be
turning : float32 (2, 16), speeds of the wheels as their encoders count them, rad/s
rolling : float32 (2, 16), wheel speeds with which a perfect robot would move as this one does
"""


def make_disturbance(perturbations, max_wheel_speeds):
    """Return the state for a batch of robots that are all at the start of episode 0.

    Parameters
    ----------
    perturbations : Perturbations
    max_wheel_speeds : sequence of two floats
        Highest wheel speeds of predator and prey, rad/s: what a full battery gives.

    Returns
    -------
    Disturbance, or None where nothing but starts is imperfect
    """
    p = perturbations
    if not p.active:
        return None
    settings = aligned_rows(SETTING_ROWS)
    for robot, speed in enumerate(max_wheel_speeds):
        own = p if p.affects(robot) else PERFECT
        settings[:, robot * HALF : robot * HALF + HALF] = np.array(
            [
                own.infrared_noise / NORMAL_DEVIATION,
                own.camera_noise / NORMAL_DEVIATION,
                own.ground_noise / NORMAL_DEVIATION,
                own.motor_noise / NORMAL_DEVIATION,
                own.latency_ticks,
                own.battery * speed if own.battery < 1 else math.inf,
                own.command_loss,
                own.wheel_radius_scale,
                own.wheel_radius_scale / own.wheel_separation_scale,
            ]
        )[:, None]
    disturbance = Disturbance(
        settings,
        aligned_rows(_COUNTER_ROWS, np.uint32),
        aligned_rows(_WORD_ROWS, np.uint32),
        aligned_rows(WHEEL_ROWS),
        aligned_rows(WHEEL_ROWS * _SLOTS),
        np.zeros(1, np.int64),
        p.latency_ticks,
        p.battery < 1 or p.wheel_radius_scale != 1 or p.wheel_separation_scale != 1,
        aligned_rows(WHEEL_ROWS),
        aligned_rows(WHEEL_ROWS),
    )
    for lane in range(2 * HALF):
        begin(disturbance, lane, p.seed, 0)
    return disturbance


@compile_kernel
def begin(disturbance, lane, seed, episode):
    """Begin the episode of that number, an integer >= 0, in a robot's lane."""
    key = episode_key(seed, episode, lane // HALF)
    disturbance.counters[_FIRST_KEY, lane] = key >> np.uint64(32)
    disturbance.counters[_SECOND_KEY, lane] = key & np.uint64(0xFFFFFFFF)
    disturbance.counters[_AGE, lane] = 0
    for row in range(WHEEL_ROWS):
        disturbance.held[row, lane] = 0.0
    for row in range(WHEEL_ROWS * _SLOTS):
        disturbance.queue[row, lane] = 0.0
    _draw(disturbance)


@kernel_part
def _draw(disturbance):
    """Draw the random bits of the tick to come, so that nothing in it waits for them."""
    counters, words = disturbance.counters, disturbance.words
    tick = mix_tick(load(counters, _FIRST_KEY), load(counters, _SECOND_KEY), load(counters, _AGE))
    for row in range(_FOR_LOSS):
        store(words, row, random_words(tick, row))
    if any_lane(load(disturbance.settings, LOSS) > 0.0):
        store(words, _FOR_LOSS, random_words(tick, _FOR_LOSS))


@kernel_part
def disturb_readings(disturbance, readings):
    """Add the tick's noise to what the robots sense, float32 (readings, 16)."""
    settings, words = disturbance.settings, disturbance.words
    infrared = load(settings, INFRARED_NOISE)
    camera, ground = load(settings, CAMERA_NOISE), load(settings, GROUND_NOISE)
    if any_lane(infrared > 0.0):
        for first in range(0, INFRARED_RAYS, 8):
            normals = eight_normals(load(words, _FOR_RAYS + first // 8))
            for i in range(8):
                _disturb_distance(readings, INFRARED + first + i, infrared, normals[i])
    if any_lane((camera > 0.0) | (ground > 0.0)):
        normals = eight_normals(load(words, _FOR_SECTORS))
        for i in range(CAMERA_SECTORS):
            _disturb_fraction(readings, CAMERA + i, camera, normals[i])
        normals = eight_normals(load(words, _FOR_GROUND_AND_WHEELS))
        for i in range(len(GROUND_POSITIONS)):
            _disturb_fraction(readings, GROUND + i, ground, normals[i])


@numba.njit(forceinline=True)
def _disturb_distance(readings, row, deviation, normal):
    """Disturb an infrared distance; one beyond the range stays.

    As every distance it is what a float32 distance from the centre, less the radius, can be.
    """
    true = load(readings, row)
    noisy = maximum(fma(deviation, normal, true), 0.0)
    noisy = (noisy + BODY_RADIUS) - BODY_RADIUS
    store(readings, row, select(true > INFRARED_RANGE, true, noisy))


@numba.njit(forceinline=True)
def _disturb_fraction(readings, row, deviation, normal):
    noisy = fma(deviation, normal, load(readings, row))
    store(readings, row, minimum(maximum(noisy, 0.0), 1.0))


@kernel_part
def disturb_wheels(disturbance, commands):
    """Set how the wheels turn, and the robots move, in this tick; the next call is the next tick.

    Parameters
    ----------
    disturbance : Disturbance
        `turning` and `rolling` are written.
    commands : float32 array, shape (2, 16)
        Wheel speeds asked for, rad/s.
    """
    settings, words = disturbance.settings, disturbance.words
    left, right = load(commands, LEFT), load(commands, RIGHT)
    loss = load(settings, LOSS)
    if any_lane(loss > 0.0):
        lost = fractions(load(words, _FOR_LOSS)) < loss
        left = select(lost, load(disturbance.held, LEFT), left)
        right = select(lost, load(disturbance.held, RIGHT), right)
        store(disturbance.held, LEFT, left)
        store(disturbance.held, RIGHT, right)
    if disturbance.latency > 0:
        late = load(settings, LATENCY) > 0.0
        left, right = _delay(disturbance, late, left, right)
    if disturbance.worn:
        limit = load(settings, SPEED_LIMIT)
        left = minimum(maximum(left, -limit), limit)
        right = minimum(maximum(right, -limit), limit)
    store(disturbance.turning, LEFT, left)
    store(disturbance.turning, RIGHT, right)
    noise = load(settings, MOTOR_NOISE)
    normals = eight_normals(load(words, _FOR_GROUND_AND_WHEELS))
    left = left * fma(noise, normals[len(GROUND_POSITIONS) + LEFT], 1.0)
    right = right * fma(noise, normals[len(GROUND_POSITIONS) + RIGHT], 1.0)
    if disturbance.worn:
        mean = (left + right) * 0.5 * load(settings, ADVANCE_SCALE)
        spread = (right - left) * 0.5 * load(settings, TURN_SCALE)
        left, right = mean - spread, mean + spread
    store(disturbance.rolling, LEFT, left)
    store(disturbance.rolling, RIGHT, right)
    store(disturbance.counters, _AGE, load(disturbance.counters, _AGE) + 1)
    _draw(disturbance)


@numba.njit(forceinline=True)
def _delay(disturbance, late, left, right):
    """Remember the commands of this tick; return those that take effect in it."""
    clock, queue = disturbance.clock, disturbance.queue
    write = WHEEL_ROWS * (clock[0] % _SLOTS)
    read = WHEEL_ROWS * ((clock[0] - disturbance.latency) % _SLOTS)
    clock[0] += 1
    store(queue, write + LEFT, left)
    store(queue, write + RIGHT, right)
    return select(late, load(queue, read + LEFT), left), select(
        late, load(queue, read + RIGHT), right
    )


@compile_kernel
def _disturb_readings(disturbance, readings):
    disturb_readings(disturbance, readings)


@compile_kernel
def _disturb_wheels(disturbance, commands):
    disturb_wheels(disturbance, commands)


class PerturbedRobots:
    """The perturbations of the two robots of one arena.

    Parameters
    ----------
    perturbations : Perturbations
    max_wheel_speeds : sequence of two floats
        Highest wheel speeds of predator and prey, rad/s.
    """

    def __init__(self, perturbations, max_wheel_speeds):
        self._seed = perturbations.seed
        self._starts = make_starts(perturbations)
        self._disturbance = make_disturbance(perturbations, max_wheel_speeds)
        self._commands = aligned_rows(WHEEL_ROWS)

    def starts(self, episodes=(0, 0)):
        """Return where the robots start in the episodes that `begin` takes.

        Returns
        -------
        tuple of two triples
            x and y in m, heading in rad.
        """
        return tuple(
            start_pose(self._starts, robot, self._seed, np.uint64(episode))
            for robot, episode in enumerate(episodes)
        )

    def begin(self, episodes=(0, 0)):
        """Begin an episode.

        Parameters
        ----------
        episodes : sequence of two integers
            Numbers of predator's and prey's episode, 0 to 2**64 - 1: those of equal number are
            disturbed equally.
        """
        if self._disturbance is not None:
            for lane, episode in zip(ROBOT_LANES, episodes, strict=True):
                begin(self._disturbance, lane, self._seed, np.uint64(episode))

    def sense(self, readings):
        """Return what robots read whose true readings are these, float32 (2, readings)."""
        if self._disturbance is None:
            return readings
        rows = aligned_rows(readings.shape[1])
        rows[:, ROBOT_LANES] = readings.T
        _disturb_readings(self._disturbance, rows)
        return rows[:, ROBOT_LANES].T.copy()

    def drive(self, commands):
        """Carry out a tick's commands.

        Parameters
        ----------
        commands : array_like, shape (2, 2)
            Left and right wheel speed asked of predator and prey, rad/s.

        Returns
        -------
        turning, rolling : float32 arrays, shape (2, 2)
            Speeds of the wheels as their encoders count them, and those with which perfect robots
            would move as these do, rad/s.
        """
        if self._disturbance is None:
            exact = np.asarray(commands, dtype=np.float32)
            return exact, exact
        self._commands[:, ROBOT_LANES] = np.asarray(commands, dtype=np.float32).T
        _disturb_wheels(self._disturbance, self._commands)
        turning, rolling = self._disturbance.turning, self._disturbance.rolling
        return turning[:, ROBOT_LANES].T.copy(), rolling[:, ROBOT_LANES].T.copy()
