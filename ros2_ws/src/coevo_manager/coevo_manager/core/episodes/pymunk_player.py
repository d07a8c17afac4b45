"""Episodes under rigid-body physics: the compiled sensors and controllers, moved by pymunk."""

import numpy as np

from coevo_manager.core.episodes.kernel import VARIATION, add_variation, decide, start_robot
from coevo_manager.core.episodes.lanes import EpisodeLanes
from coevo_manager.core.episodes.numbering import episode_numbers
from coevo_manager.core.episodes.schedule import IDLE, end_episode, next_episode, row
from marxbot_sim.core.disturbance import begin
from marxbot_sim.core.pymunk_world import PymunkArenas
from marxbot_sim.core.starts import start_pose
from neuro_controller.core.network import FATIGUE_TICKS, TICKS
from simd_lanes import HALF, compile_kernel

ARENAS = 32
"""Arenas in a space: more wait for each other's collision search, fewer for Python."""


@compile_kernel
def _start(layout, lane, genome, rows):
    start_robot(layout, lane, genome, rows)


@compile_kernel
def _decide(layout, rows, obstacle, slot, disturbance):
    decide(layout, rows, obstacle, slot, disturbance)
    add_variation(rows.wheels, rows.complexity)


class PymunkPlayer:
    """Plays queued episodes, 32 at a time; what it offers is that of `KinematicPlayer`.

    Parameters
    ----------
    environment : Environment
    measure : bool
        Whether to report the complexity of the behaviours.
    """

    def __init__(self, environment, measure):
        self._environment = environment
        self._measure = measure
        self._arenas = PymunkArenas(environment.arena, ARENAS)
        self._commands = [np.zeros_like(wheels) for wheels in self._arenas.wheels]
        self._blocks = [
            EpisodeLanes(environment, bodies, wheels)
            for bodies, wheels in zip(self._arenas.bodies, self._commands, strict=True)
        ]
        self._clock = 0

    def play(self, rings):
        """Play on, see `KinematicPlayer.play`."""
        finished = played = False
        while True:
            self._fill(rings)
            busy = np.array([block.episode for block in self._blocks]) != IDLE
            if finished or not busy.any() or (played and not busy.all()):
                return finished
            played = True
            ended = np.zeros_like(busy)
            while not ended.any():
                ended = self._tick() & busy
            for block, pair in np.argwhere(ended):
                lanes = self._blocks[block]
                ticks = int(lanes.rows.memory[TICKS, pair])
                complexity = np.zeros(2)
                if self._measure:
                    variation = lanes.rows.complexity[VARIATION, [pair, pair + HALF]]
                    complexity = variation.astype(np.float64) / (2 * ticks)
                ended_request = end_episode(rings, lanes.episode[pair], ticks, *complexity)
                finished = finished or ended_request
                lanes.episode[pair] = IDLE

    def _fill(self, rings):
        """Start waiting episodes where none is running."""
        for number, lanes in enumerate(self._blocks):
            for pair in np.flatnonzero(lanes.episode == IDLE):
                lanes.episode[pair] = next_episode(rings)
                if lanes.episode[pair] == IDLE:
                    return
                episode = row(rings.episodes, lanes.episode[pair])
                players = [
                    row(rings.genomes, episode[species]) for species in ('predator', 'prey')
                ]
                poses = self._begin(lanes, pair, players, episode['repetition'])
                self._arenas.place(number * HALF + pair, poses)

    def _begin(self, lanes, pair, players, repetition):
        """Put two genomes in their lanes and return where the robots start."""
        poses = []
        opponents = episode_numbers(players[::-1], repetition)
        for robot, genome in enumerate(players):
            lane = pair + robot * HALF
            key = self._environment.perturbations.seed, opponents[robot]
            _start(lanes.layout, lane, genome, lanes.rows)
            if lanes.disturbance is not None:
                begin(lanes.disturbance, lane, *key)
            poses.append(start_pose(lanes.starts, robot, *key))
        return poses

    def _tick(self):
        """Make a tick in all arenas; return where an episode would end, shape (blocks, 8)."""
        slot = self._clock % FATIGUE_TICKS
        self._clock += 1
        for lanes, wheels in zip(self._blocks, self._arenas.wheels, strict=True):
            _decide(lanes.layout, lanes.rows, self._environment.obstacle, slot, lanes.disturbance)
            moved = lanes.rows.wheels if lanes.disturbance is None else lanes.disturbance.rolling
            wheels[:] = moved
        captured = self._arenas.step().reshape(-1, HALF)
        ticks = np.array([lanes.rows.memory[TICKS, :HALF] for lanes in self._blocks])
        return captured | (ticks >= self._environment.episode_ticks)
