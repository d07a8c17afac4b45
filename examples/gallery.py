"""Draw the gallery of docs/gallery.md: the shipped champions, each pair in the world it knows."""

import red_queen as rq
from coevo_manager.core.provenance import choose_environment

for place in ('open', 'obstacle'):
    champions = [rq.select_champion(f'shipped/{place}', species) for species in rq.SPECIES]
    world, _ = choose_environment(champions, {})
    genomes = [champion.genome for champion in champions]
    for name, environment in {
        place: world,
        f'{place}-faithful': rq.make_environment({**rq.WORLDS['faithful'], 'environment': place}),
    }.items():
        trace = rq.trace_pair(*genomes, environment)
        rq.animate_chase(trace, f'{name}.gif', environment, rate=16)
        print(name, trace.ticks, 'captured' if trace.captured else 'got away')
print(*champions, sep='\n')
