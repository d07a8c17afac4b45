"""What scripts/ship-champions does; see there."""

import argparse
import json
from pathlib import Path

import numpy as np

from coevo_manager.core.evolution.files import npz_bytes, write_whole
from neuro_controller.core.champions import SHIPPED
from neuro_controller.core.origin import read_origin
from neuro_controller.core.snapshot import read_snapshot, snapshots


def main():
    """Write the file and print its name."""
    parser = argparse.ArgumentParser(prog='ship-champions', add_help=False)
    parser.add_argument('run', type=Path)
    parser.add_argument('name')
    parser.add_argument('--count', type=int, default=5)
    options = parser.parse_args()
    found = snapshots(options.run)
    snapshot = read_snapshot(found[max(found)])
    predators, prey = (snapshot.ranking(s)[: options.count] for s in ('predator', 'prey'))
    record = json.loads((options.run / 'run.json').read_text(encoding='utf-8'))
    record['run'] = options.run.resolve().name
    path = SHIPPED / f'{options.name}.npz'
    arrays = {
        'version': np.int64(1),
        'generation': np.int64(snapshot.generation),
        'predators': snapshot.predators[predators],
        'prey': snapshot.prey[prey],
        'fitness': snapshot.fitness[np.ix_(predators, prey)].astype(np.float32),
        'run': np.array(json.dumps(record)),
    }
    write_whole(path, npz_bytes(arrays))
    print(f'{path}: {read_origin(path)}')


if __name__ == '__main__':
    main()
