"""Search a linear prey against the shipped predator, 64 candidates at a time, in one vector."""

import numpy as np

from red_queen.environments import ChaseVectorEnv

ROUNDS = 3

envs = ChaseVectorEnv(64, species='prey', opponent='shipped/open')
rng = np.random.default_rng(1)
best, best_return = np.zeros((2, 25)), -np.inf
for _ in range(ROUNDS):
    candidates = best + rng.normal(0, 1, (64, 2, 25))
    observations, _ = envs.reset(seed=1)
    returns, alive = np.zeros(64), np.ones(64, bool)
    while alive.any():
        actions = 1 / (1 + np.exp(-np.einsum('nij,nj->ni', candidates, observations)))
        observations, rewards, captured, over, _ = envs.step(actions)
        returns += rewards * alive
        alive &= ~(captured | over)
    if returns.max() > best_return:
        best, best_return = candidates[returns.argmax()], returns.max()
    print(f'mean return {returns.mean():.2f}, best so far {best_return:.2f}')
