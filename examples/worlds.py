"""Play the shipped champions in each world, a hundred episodes each with starts and noise."""

import dataclasses

import red_queen as rq

EPISODES = 100

predator, prey = (rq.select_champion('shipped/open', species).genome for species in rq.SPECIES)
for name, settings in rq.WORLDS.items():
    world = dataclasses.replace(rq.make_environment(settings), repetitions=EPISODES)
    ticks = rq.evaluate_pairs([predator], [prey], [0], [0], world)[0] / EPISODES
    print(f'{name:9} fitness of the predator {rq.fitness(ticks, "predator"):.2f}')
