"""The genome server: a run's champions, and the shipped ones, as parameters to be fetched."""

import sys

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.node import Node

from neuro_controller.core.champions import SHIPPED
from neuro_controller.core.genome import check_genomes
from neuro_controller.core.origin import read_origin
from neuro_controller.core.snapshot import SPECIES, read_snapshot, snapshots
from neuro_controller.interface import GENOME_SERVER
from node_runner import Concerns, run_node


class GenomeServer(Node):
    """Holds each champion as a read-only array of doubles, and what it evolved with.

    ``predator`` and ``prey`` are the champions of the run's last snapshot, or without a run those
    shipped for the open arena; ``gen_000500.predator`` is the champion of one snapshot, and
    ``NAME.predator`` a shipped one. Below each stand the parameters that its controller had in
    evolution, such as ``predator.motor_map``.
    """

    def __init__(self):
        super().__init__('genome_server')
        GENOME_SERVER.declare(self)
        run = self.get_parameter('run').value
        for path in sorted(SHIPPED.glob('*.npz')):
            self._serve(f'{path.stem}.', path)
        if run:
            found = snapshots(run)
            for path in found.values():
                self._serve(f'{path.stem}.', path)
            newest = found[max(found)]
        else:
            newest = SHIPPED / 'open.npz'
        self._serve('', newest)
        origin = read_origin(newest)
        world, arena = (origin.configuration[name] for name in ('world', 'environment'))
        self.get_logger().info(
            f'serves the champions of {newest}: {origin}, world {world}, arena {arena}'
        )
        self._concerns = Concerns(self)

    def _serve(self, prefix, path):
        snapshot, origin = read_snapshot(path), read_origin(path)
        check_genomes(snapshot.predators, f'predators of {path}', origin.layout)
        for species in SPECIES:
            self._hold(f'{prefix}{species}', snapshot.best(species, 1)[0].tolist(), path)
            for name, value in origin.settings(species).items():
                self._hold(f'{prefix}{species}.{name}', value, path)

    def _hold(self, name, value, path):
        text = f'of the champion of {path.name}'
        self.declare_parameter(name, value, ParameterDescriptor(description=text, read_only=True))


def main():
    """Run the node until it is stopped."""
    return run_node(GenomeServer, GENOME_SERVER)


if __name__ == '__main__':
    sys.exit(main())
