"""The chase as environments for reinforcement learning: PettingZoo, Gymnasium, and many at once.

Importing this registers ``RedQueen/Chase-v0`` with Gymnasium.
"""

import gymnasium

from red_queen.environments.parallel import ChaseParallelEnv
from red_queen.environments.policy import GenomePolicy
from red_queen.environments.single import ChaseEnv
from red_queen.environments.vector import ChaseVectorEnv

__all__ = ['ChaseEnv', 'ChaseParallelEnv', 'ChaseVectorEnv', 'GenomePolicy']

gymnasium.register(
    id='RedQueen/Chase-v0',
    entry_point='red_queen.environments:ChaseEnv',
    vector_entry_point='red_queen.environments:ChaseVectorEnv',
)
