"""Fetching a genome, and what it evolved with, from another node's parameters."""

from rcl_interfaces.srv import GetParameters
from rclpy.clock import Clock, ClockType
from rclpy.parameter import parameter_value_to_python

RETRY_PERIOD = 0.2
"""Time between two questions, s (real time)."""


class GenomeClient:
    """Asks a node for a genome and its settings, again and again until it has answered once.

    The answer of a server that has not discovered its client yet is lost.

    Parameters
    ----------
    node : rclpy.node.Node
    server : str
        Name of the node that holds the genome.
    champion : str
        Name of its parameter; the settings are parameters below that.
    settings : sequence of str
        Their names.
    on_genome : callable
        Called with the genes, a list of float, and the settings, a dict.

    Raises
    ------
    ValueError
        A name is missing.
    """

    def __init__(self, node, server, champion, settings, on_genome):
        if not champion:
            raise ValueError(f'champion is empty, expected the name of a parameter of {server}')
        self._node = node
        self._server = server
        self._champion = champion
        self._settings = settings
        self._on_genome = on_genome
        self._client = node.create_client(GetParameters, f'{server}/get_parameters')
        self._timer = node.create_timer(
            RETRY_PERIOD, self._look, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )

    def _look(self):
        if not self._client.service_is_ready():
            self._node.get_logger().info(f'waits for {self._server}', once=True)
            return
        names = [self._champion, *(f'{self._champion}.{name}' for name in self._settings)]
        future = self._client.call_async(GetParameters.Request(names=names))
        future.add_done_callback(self._take)

    def _take(self, future):
        if self._timer.is_canceled():
            return
        self._timer.cancel()
        values = future.result().values
        if len(values) <= len(self._settings):
            self._node.get_logger().error(
                f'{self._server} has no genome {self._champion!r} with its settings'
            )
        else:
            genome, *settings = map(parameter_value_to_python, values)
            self._on_genome(genome, dict(zip(self._settings, settings, strict=True)))
