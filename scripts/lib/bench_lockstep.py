"""How many ticks a second lockstep makes over topics."""

import time

import numpy as np
import rclpy
from marxbot_msgs.msg import ArenaState

from coevo_manager.recording.episode_processes import TICK_TIMEOUT, EpisodeProcesses
from coevo_manager.recording.recorder import STATE
from neuro_controller.core.genome import GENE_RANGE, GENES, LAYOUT
from node_runner import start_ros

STANDING = np.where(np.arange(GENES) == LAYOUT.output_biases + 1, -GENE_RANGE, 0.0)
"""Genome of a robot that all but stands still: only the bias of the drive is not zero."""


def lockstep_rate(environment):
    """Return how many ticks a second lockstep makes here, with nobody recording.

    For an own process: it initialises rclpy, and ends it.

    Parameters
    ----------
    environment : Environment
        The episode is played to its end by two robots that stand still.
    """
    start_ros(['bench'])
    try:
        with EpisodeProcesses(environment, real_time_factor=0.0) as processes:
            return _measure(processes, environment.episode_ticks)
    finally:
        rclpy.try_shutdown()


def _measure(processes, ticks):
    states = []
    processes.node.create_subscription(
        ArenaState, f'{processes.prefix}{STATE}', states.append, 1000
    )
    processes.set_genomes(STANDING, STANDING)
    processes.activate()
    processes.reset()
    processes.step(1)
    processes.wait(lambda: states and states[-1].tick, TICK_TIMEOUT, 'the first tick')
    first, started = states[-1].tick, time.monotonic()
    processes.step(ticks - first)
    processes.wait(lambda: states[-1].ended, TICK_TIMEOUT + ticks, 'the end of the episode')
    return (states[-1].tick - first) / (time.monotonic() - started)
