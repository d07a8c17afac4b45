"""Trace the chase of the shipped champions, and draw it."""

import red_queen as rq

champions = [rq.select_champion('shipped/open', species) for species in rq.SPECIES]
trace = rq.trace_pair(*(champion.genome for champion in champions))
print(*champions, sep='\n')
print('captured' if trace.captured else 'got away', f'after {trace.ticks / 10:.1f} s')
rq.plot_chase(trace).savefig('chase.png')
rq.animate_chase(trace, 'chase.gif', rate=8)
