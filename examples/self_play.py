"""Play an episode through PettingZoo: an evolved predator against a prey that acts at random."""

import red_queen as rq
from red_queen.environments import ChaseParallelEnv, GenomePolicy

env = ChaseParallelEnv(rq.make_environment(rq.WORLDS['varied']))
hunter = GenomePolicy(rq.select_champion('shipped/open', 'predator').genome)
observations, infos = env.reset(seed=1)
returns = dict.fromkeys(env.agents, 0.0)
env.action_space('prey').seed(1)
while env.agents:
    actions = {
        'predator': hunter(observations['predator']),
        'prey': env.action_space('prey').sample(),
    }
    observations, rewards, terminations, truncations, infos = env.step(actions)
    for agent, reward in rewards.items():
        returns[agent] += reward
print('returns', {agent: round(value, 3) for agent, value in returns.items()})
