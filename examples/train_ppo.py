"""Train a prey by PPO against the shipped predator, and set it beside the evolutionary probe.

Needs stable-baselines3: make an environment of its own for it, with `pip install '.[environments]'
stable-baselines3`. Writes the learning curve (ppo.csv, ppo.png) into the current folder.
"""

import argparse
import csv
import dataclasses
from pathlib import Path

import numpy as np
from gymnasium.spaces import Box
from matplotlib.figure import Figure
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnv

import red_queen as rq
from coevo_manager.analysis.play.kernel import Kernel
from coevo_manager.analysis.play.probe import SearchBudget, best_response
from red_queen.environments import ChaseVectorEnv

EPISODES = 128
"""Episodes of a test, each with a start of its own."""


class StableChase(VecEnv):
    """A `ChaseVectorEnv` as stable-baselines3 wants it, with actions from -1 to 1."""

    def __init__(self, envs):
        self._envs = envs
        space = Box(-1.0, 1.0, envs.single_action_space.shape, np.float32)
        super().__init__(envs.num_envs, envs.single_observation_space, space)

    def reset(self):
        """Begin all episodes."""
        observations, _ = self._envs.reset(seed=self._seeds[0])
        self._reset_seeds()
        return observations

    def step_async(self, actions):
        """Remember the actions."""
        self._actions = (actions + 1) / 2

    def step_wait(self):
        """Make a tick."""
        observations, rewards, captured, over, infos = self._envs.step(self._actions)
        ended = captured | over
        each = [{} for _ in ended]
        for place in np.flatnonzero(ended):
            each[place] = {
                'terminal_observation': infos['final_obs'][place],
                'TimeLimit.truncated': bool(over[place]),
            }
        return observations, rewards.astype(np.float32), ended, each

    def close(self):
        """Nothing is open."""

    def get_attr(self, name, indices=None):
        """Return an attribute, the same for all."""
        return [getattr(self._envs, name, None)] * self.num_envs

    def set_attr(self, name, value, indices=None):
        """Refuse: the episodes share their environment."""
        raise NotImplementedError

    def env_method(self, name, *arguments, indices=None, **settings):
        """Refuse: the episodes share their environment."""
        raise NotImplementedError

    def env_is_wrapped(self, wrapper, indices=None):
        """Say that no episode has a wrapper of its own."""
        return [False] * self.num_envs


def mean_fitness(model):
    """Return the mean fitness over `EPISODES` episodes, without exploration."""
    envs = ChaseVectorEnv(EPISODES)
    observations, _ = envs.reset(seed=12345)
    fitness, alive = np.zeros(EPISODES), np.ones(EPISODES, bool)
    while alive.any():
        actions, _ = model.predict(observations, deterministic=True)
        observations, rewards, captured, over, _ = envs.step((actions + 1) / 2)
        fitness += rewards * alive
        alive &= ~(captured | over)
    return fitness.mean()


class Curve(BaseCallback):
    """Tests the policy every so many ticks."""

    def __init__(self, every):
        super().__init__()
        self._every = every
        self.points = []

    def _on_step(self):
        return True

    def _on_rollout_start(self):
        if self.num_timesteps >= len(self.points) * self._every:
            self.points.append((self.num_timesteps, mean_fitness(self.model)))
            print('{} ticks: fitness {:.3f}'.format(*self.points[-1]), flush=True)


def draw(points, references):
    """Write ppo.csv and ppo.png."""
    with Path('ppo.csv').open('w', newline='') as file:
        csv.writer(file).writerows([('ticks', 'fitness'), *points])
    figure = Figure(figsize=(6, 4), dpi=110, layout='constrained')
    axes = figure.add_subplot()
    axes.plot(*np.array(points).T, color='#3b93cf', marker='o', ms=3, label='prey by PPO')
    for (name, value), style in zip(references.items(), ('--', ':', '-.'), strict=False):
        axes.axhline(value, color='black', ls=style, lw=1, label=f'{name}: {value:.2f}')
    axes.set(xlabel='ticks of training', ylabel='fitness of the prey', ylim=(0, 1))
    figure.legend(frameon=False, loc='outside upper center', ncols=2, fontsize='small')
    figure.savefig('ppo.png')


def main():
    """Train, test, and draw."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--ticks', type=int, default=1_000_000, help='ticks of training')
    parser.add_argument('--candidates', type=int, default=500, help='budget of the probe')
    options = parser.parse_args()
    champions = [rq.select_champion('shipped/open', species) for species in rq.SPECIES]
    envs = ChaseVectorEnv(64)
    world = envs.environment
    predator, prey = (champion.genome for champion in champions)

    many = dataclasses.replace(world, repetitions=100)
    ticks = rq.evaluate_pairs([predator], [prey], [0], [0], many)[0] / many.repetitions
    history = best_response(
        Kernel(), predator, 'predator', world, SearchBudget(options.candidates)
    )
    references = {
        'co-evolved prey': float(rq.fitness(ticks, 'prey')),
        'evolutionary probe, mean of searches': float(history[:, -1].mean()),
        'evolutionary probe, best search': float(history[:, -1].max()),
    }
    print(references, flush=True)

    model = PPO(
        'MlpPolicy',
        StableChase(envs),
        n_steps=256,
        batch_size=2048,
        gamma=0.995,
        ent_coef=0.002,
        seed=1,
        device='cpu',
    )
    curve = Curve(every=max(1, options.ticks // 20))
    model.learn(options.ticks, callback=curve)
    curve.points.append((model.num_timesteps, mean_fitness(model)))
    print('{} ticks: fitness {:.3f}'.format(*curve.points[-1]))
    draw(curve.points, references)


if __name__ == '__main__':
    main()
