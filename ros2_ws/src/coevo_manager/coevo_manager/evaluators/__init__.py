"""Who plays the episodes of a run: evaluator nodes, and the pool in which a run holds them."""
