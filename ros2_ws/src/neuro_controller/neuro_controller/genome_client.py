"""Fetching a genome from another node's parameters."""

from rcl_interfaces.srv import GetParameters
from rclpy.clock import Clock, ClockType
from rclpy.parameter import parameter_value_to_python

RETRY_PERIOD = 0.2
"""Time between two questions, s (real time)."""


class GenomeClient:
    """Asks a node for one of its parameters, again and again until it has answered once.

    The answer of a server that has not discovered its client yet is lost.

    Parameters
    ----------
    node : rclpy.node.Node
    server : str
        Name of the node that holds the genome.
    champion : str
        Name of its parameter.
    on_genome : callable
        Called with the genes, a list of float.

    Raises
    ------
    ValueError
        A name is missing.
    """

    def __init__(self, node, server, champion, on_genome):
        if not champion:
            raise ValueError(f'champion is empty, expected the name of a parameter of {server}')
        self._node = node
        self._server = server
        self._champion = champion
        self._on_genome = on_genome
        self._client = node.create_client(GetParameters, f'{server}/get_parameters')
        self._timer = node.create_timer(
            RETRY_PERIOD, self._look, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )

    def _look(self):
        if not self._client.service_is_ready():
            self._node.get_logger().info(f'waits for {self._server}', once=True)
            return
        future = self._client.call_async(GetParameters.Request(names=[self._champion]))
        future.add_done_callback(self._take)

    def _take(self, future):
        if self._timer.is_canceled():
            return
        self._timer.cancel()
        values = future.result().values
        genome = parameter_value_to_python(values[0]) if values else None
        if genome is None:
            self._node.get_logger().error(f'{self._server} has no genome {self._champion!r}')
        else:
            self._on_genome(genome)
