"""Playing episodes over topics, every message of them received."""

import math
import reprlib
import time
from dataclasses import dataclass

import numpy as np
from rclpy.exceptions import InvalidNamespaceException
from rclpy.validate_namespace import validate_namespace

from coevo_manager.core.environment import Environment
from coevo_manager.recording.episode_processes import (
    START_TIMEOUT,
    TICK_TIMEOUT,
    EpisodeProcesses,
)
from coevo_manager.recording.recorder import COMMANDS, GROUND_TRUTH, Recorder
from marxbot_sim.core.drive import wheel_speeds
from marxbot_sim.core.parameters import FASTEST, SLOWEST
from neuro_controller.core.genome import check_genomes

CHUNK = 8
"""Ticks that the simulator makes at a stretch in lockstep: the publishers of commands and neurons
keep 10 messages for a subscriber that lags, and the shared memory of the transport 512 KB."""

FIRST_TICK_TIMEOUT = 3.0
"""How long to wait for every message of a first tick before it is made again, s."""


@dataclass(frozen=True)
class Episode:
    """An episode as it was seen on topics.

    Attributes
    ----------
    ticks : int
        Tick at which it ended.
    captured : bool
        Whether the prey was captured then.
    poses : float32 array, shape (ticks + 1, 2, 3)
        x and y in m and heading in rad of predator and prey, from the ground truth.
    wheels : float32 array, shape (ticks, 2, 2)
        Commanded speeds of left and right wheel, rad/s.
    seconds : float
        Real time it took, s.
    """

    ticks: int
    captured: bool
    poses: np.ndarray
    wheels: np.ndarray
    seconds: float


class EpisodePlayer:
    """Plays episodes in processes of their own, one after the other.

    To be used as a context manager; leaving it ends the processes.

    Parameters
    ----------
    environment : Environment
    real_time_factor : float
        Simulated over real time, 0.001 to 1000; 0 plays in lockstep, as fast as possible. Then
        every episode equals the headless one bit for bit.
    namespace : str or None
        Namespace of all topics and nodes; None takes one that nothing else uses.

    Raises
    ------
    ValueError
        The pace is out of its range, the namespace is none, or a pair is to play several episodes.
    TimeoutError, RuntimeError
        The processes did not start.
    """

    def __init__(self, environment=Environment(), real_time_factor=0.0, namespace=None):
        if real_time_factor != 0 and not SLOWEST <= real_time_factor <= FASTEST:
            raise ValueError(
                f'real_time_factor is {real_time_factor}, expected 0 or a number from {SLOWEST:g} '
                f'to {FASTEST:g}'
            )
        _check_namespace(namespace or '/')
        if environment.repetitions != 1:
            raise ValueError(f'repetitions is {environment.repetitions}, expected 1 over topics')
        self._layout = environment.layout
        self._length = environment.episode_ticks
        self._lockstep = real_time_factor == 0
        self._pace = real_time_factor or 1.0
        self._processes = EpisodeProcesses(environment, real_time_factor, namespace)
        self._recorder = None

    def __enter__(self):
        self._processes.__enter__()
        return self

    def __exit__(self, *_):
        self._processes.__exit__()

    def play(self, predator, prey, bag=None, on_progress=lambda tick, poses: None):
        """Play one episode.

        Parameters
        ----------
        predator, prey : array_like, shape (genes,)
            Genomes.
        bag : BagWriter or None
            Where to write every message.
        on_progress : callable
            Called now and then with the tick and the poses, shape (2, 3).

        Returns
        -------
        Episode

        Raises
        ------
        ValueError
            A genome is not one of the environment's layout, or is refused by its controller.
        TimeoutError, RuntimeError
            A process ended or hangs, or a message was lost.
        """
        for name, genome in (('predator', predator), ('prey', prey)):
            check_genomes(np.atleast_2d(genome), name, self._layout)
        self._processes.set_genomes(predator, prey)
        if self._recorder is None:
            self._processes.activate()
            self._recorder = self._make_recorder()
        self._make_first_tick()
        started = time.monotonic()
        state = self._recorder.state
        while not state.ended:
            left = self._length - state.tick
            ticks = min(CHUNK, left) if self._lockstep else left
            self._processes.step(ticks)
            self._follow(state.tick + ticks, on_progress)
            state = self._recorder.state
        self._receive_all()
        seconds = time.monotonic() - started
        if bag is not None:
            self._recorder.save(bag)
        return self._episode(seconds)

    def _make_recorder(self):
        recorder = Recorder(self._processes.node, self._processes.prefix)
        self._processes.wait(
            lambda: recorder.subscribe(self._processes.names),
            START_TIMEOUT,
            'the discovery of all topics',
        )
        return recorder

    def _make_first_tick(self):
        """Begin the episode, again and again until every message of its first tick has come.

        Then publishers and subscribers have found each other in both directions. What comes late
        of an attempt is equal to that of the next: the same episode.
        """
        recorder, deadline = self._recorder, time.monotonic() + START_TIMEOUT
        while True:
            recorder.clear()
            self._processes.reset()
            self._processes.step(1)
            try:
                self._processes.wait(
                    lambda: not recorder.lacking(1, commands=True), FIRST_TICK_TIMEOUT, ''
                )
                return
            except TimeoutError:
                if time.monotonic() > deadline:
                    raise RuntimeError(self._lost(1, commands=True)) from None

    def _follow(self, target, on_progress):
        """Wait until the simulator has made its ticks and, in lockstep, all messages have come."""
        recorder, state = self._recorder, self._recorder.state
        while not state.ended and state.tick < target:
            wanted = target if self._lockstep else state.tick + 1
            self._processes.wait(
                lambda wanted=wanted: recorder.state.ended or recorder.state.tick >= wanted,
                TICK_TIMEOUT / min(self._pace, 1.0),
                f'tick {wanted} of the episode',
            )
            if self._lockstep:
                self._receive_all()
            state = recorder.state
            on_progress(
                state.tick, np.array([_pose(recorder.last(t).pose.pose) for t in GROUND_TRUTH])
            )

    def _receive_all(self):
        """Wait for every message of the ticks that were made."""
        tick = self._recorder.state.tick
        try:
            self._processes.wait(
                lambda: not self._recorder.lacking(tick, self._lockstep), TICK_TIMEOUT, ''
            )
        except TimeoutError:
            raise RuntimeError(self._lost(tick, self._lockstep)) from None

    def _lost(self, ticks, commands):
        lacking = self._recorder.lacking(ticks, commands)
        topic, tick = next(iter(lacking.items()))
        return (
            f'messages were lost: {topic} lacks tick {tick}, {len(lacking)} topics are not whole'
        )

    def _episode(self, seconds):
        state = self._recorder.state
        poses = np.empty((state.tick + 1, 2, 3), np.float32)
        for robot, topic in enumerate(GROUND_TRUTH):
            for tick, message in self._recorder.by_tick(topic).items():
                poses[tick, robot] = _pose(message.pose.pose)
        wheels = np.zeros((state.tick, 2, 2), np.float32)
        for robot, topic in enumerate(COMMANDS):
            sent = self._recorder.by_tick(topic)
            for tick in range(state.tick):
                if tick in sent:
                    twist = sent[tick].twist
                    wheels[tick, robot], _ = wheel_speeds(twist.linear.x, twist.angular.z)
                elif tick:
                    wheels[tick, robot] = wheels[tick - 1, robot]
        return Episode(state.tick, state.captured, poses, wheels, seconds)


def _pose(pose):
    """Return x, y and heading of a geometry_msgs/Pose."""
    return pose.position.x, pose.position.y, 2 * math.atan2(pose.orientation.z, pose.orientation.w)


def _check_namespace(namespace):
    """Raise ValueError where the nodes of an episode cannot be in a namespace."""
    try:
        validate_namespace(namespace)
        validate_namespace(f'{namespace.rstrip("/")}/predator')
    except InvalidNamespaceException as error:
        reason = str(error).partition(':\n')[0].partition(': ')[2]
        raise ValueError(f'namespace is {reprlib.repr(namespace)}: {reason}') from None
