"""Draw the gallery of docs/gallery.md: shipped champions, each pair in the world it knows."""

import red_queen as rq
from coevo_manager.core.provenance import choose_environment

PAIRS = {
    'open': ('shipped/open', 'shipped/open'),
    'open-fifth': ('shipped/open', 'shipped/open:0:4'),
    'obstacle': ('shipped/obstacle', 'shipped/obstacle'),
}
"""Predator and prey of each chase; the best prey of the open arena gets away."""

for pair, sources in PAIRS.items():
    champions = [
        rq.select_champion(source, species)
        for source, species in zip(sources, rq.SPECIES, strict=True)
    ]
    world, _ = choose_environment(champions, {})
    genomes = [champion.genome for champion in champions]
    for name, environment in {
        pair: world,
        f'{pair}-faithful': rq.make_environment(
            {**rq.WORLDS['faithful'], 'environment': pair.partition('-')[0]}
        ),
    }.items():
        trace = rq.trace_pair(*genomes, environment)
        rq.animate_chase(trace, f'{name}.gif', environment, rate=4 if trace.captured else 16)
        print(name, trace.ticks, 'captured' if trace.captured else 'got away')
    print(*champions, sep='\n')
