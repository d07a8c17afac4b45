"""The episodes node: playing an episode over topics as an action."""

import sys
import threading
from pathlib import Path

import numpy as np
from coevo_msgs.action import RunEpisode
from geometry_msgs.msg import Pose2D
from rclpy.node import Node

from coevo_manager.core.behaviour import complexity
from coevo_manager.evaluators.messages import to_environment
from coevo_manager.recording.bag_writer import BagWriter
from coevo_manager.recording.episode_player import EpisodePlayer
from node_runner import Concerns, Interface, Service, run_node
from node_runner.actions import GoalServer

EPISODES = Interface(
    'coevo_manager episodes',
    'plays episodes over topics, one at a time, with processes of its own.',
    actions=(Service('run_episode', RunEpisode, 'plays an episode of two genomes'),),
)


class EpisodesNode(Node):
    """Serves the action ``run_episode`` (coevo_msgs/action/RunEpisode), one episode at a time.

    Each episode gets a simulator and two controllers in processes of their own, in a namespace of
    their own. Bad goals and failures are aborted with one sentence in the result.
    """

    def __init__(self):
        super().__init__('episodes')
        self._stopped = threading.Event()
        self._server = GoalServer(
            self,
            RunEpisode,
            'run_episode',
            self._play,
            'an episode is being played; cancel it or wait for its end',
        )
        self._concerns = Concerns(self)
        self.get_logger().info('ready on run_episode')

    @property
    def busy(self):
        """Whether an episode is being played."""
        return self._server.busy

    def stop(self):
        """Let the episode that is being played, if any, end soon."""
        self._stopped.set()

    def _play(self, goal, result):
        """Fill the result; called in the episode's thread."""

        def tell(tick, poses):
            if goal.is_cancel_requested or self._stopped.is_set():
                raise InterruptedError('stopped on request')
            predator, prey = (Pose2D(x=x, y=y, theta=theta) for x, y, theta in poses.tolist())
            goal.publish_feedback(RunEpisode.Feedback(tick=tick, predator=predator, prey=prey))

        request = goal.request
        try:
            environment = to_environment(request.environment)
            with EpisodePlayer(environment, request.real_time_factor) as player:
                genomes = np.asarray(request.predator), np.asarray(request.prey)
                if request.bag:
                    with BagWriter(Path(request.bag)) as bag:
                        episode = player.play(*genomes, bag, tell)
                        bag.attach_record(environment, genomes)
                else:
                    episode = player.play(*genomes, None, tell)
        except (ValueError, RuntimeError, OSError) as error:  # TimeoutError is an OSError
            result.message = str(error)
        else:
            result.success = True
            result.captured = episode.captured
            result.capture_tick = episode.ticks
            result.prey_fitness = episode.ticks / environment.episode_ticks
            result.predator_fitness = 1 - result.prey_fitness
            result.predator_complexity, result.prey_complexity = map(
                float, complexity(episode.wheels)
            )


def main():
    """Run the executable ``episodes`` until it is stopped; return its exit code."""
    return run_node(EpisodesNode, EPISODES)


if __name__ == '__main__':
    sys.exit(main())
