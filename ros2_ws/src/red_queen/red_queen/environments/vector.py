"""The chase for `gymnasium.vector`: many episodes side by side in the kernel's lanes."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from coevo_manager.core.environment import Environment
from coevo_manager.core.episodes.stepped import SteppedEpisodes
from coevo_manager.core.species import SPECIES
from neuro_controller.core.genome import OUTPUTS
from red_queen.environments.chase import (
    action_space,
    check_actions,
    draw_numbers,
    observation_space,
    read_opponents,
    rewards,
)


class ChaseVectorEnv(VectorEnv):
    """Many `ChaseEnv` at once, eight a vector of the kernel.

    An episode that ends is followed by the next in the same step; `infos` then has its last
    observation as ``final_obs``, and ``_final_obs`` says where.

    Parameters
    ----------
    num_envs : int
        Episodes side by side; a multiple of 8 leaves no lane idle.
    species, opponent, environment
        As for `ChaseEnv`.

    Attributes
    ----------
    environment : Environment
        The world of every episode.

    Examples
    --------
    >>> envs = ChaseVectorEnv(64, species='predator')
    >>> observations, infos = envs.reset(seed=1)
    >>> observations, rewards, captured, over, infos = envs.step(envs.action_space.sample())
    >>> observations.shape, rewards.shape
    ((64, 25), (64,))
    """

    metadata: dict[str, Any] = {'autoreset_mode': AutoresetMode.SAME_STEP}  # noqa: RUF012

    def __init__(
        self,
        num_envs: int = 128,
        species: str = 'prey',
        opponent: Any = 'shipped/open',
        environment: Environment | None = None,
    ) -> None:
        if num_envs < 1:
            raise ValueError(f'num_envs is {num_envs}, expected at least 1')
        self._opponents, self.environment = read_opponents(species, opponent, environment)
        self._robot = SPECIES.index(species)
        driven = species == 'predator', species == 'prey'
        self._episodes = SteppedEpisodes(self.environment, num_envs, driven)
        self._episode_ticks = self.environment.episode_ticks
        self.num_envs = num_envs
        self.single_observation_space = observation_space()
        self.single_action_space = action_space()
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin all episodes.

        Parameters
        ----------
        seed : int, optional
            Seeds the starts, the noise and the choice of opponents.
        options : dict, optional
            Ignored.
        """
        super().reset(seed=seed)
        self._begin(np.arange(self.num_envs))
        return self._observations(), {}

    def step(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Make a tick of all episodes."""
        self._episodes.actions[self._robot] = check_actions(actions, (self.num_envs, OUTPUTS))
        self._episodes.step()
        ticks, captured = self._episodes.ticks, self._episodes.captured.copy()
        over = ~captured & (ticks >= self._episode_ticks)
        earned = rewards(captured, ticks, self._episode_ticks)[self._robot]
        infos: dict[str, Any] = {}
        ended = captured | over
        if ended.any():
            places = np.flatnonzero(ended)
            last = np.zeros_like(self._episodes.observations[self._robot])
            last[places] = self._episodes.observations[self._robot, places]
            infos = {'final_obs': last, '_final_obs': ended}
            self._begin(places)
        return self._observations(), earned, captured, over, infos

    def _begin(self, places: np.ndarray) -> None:
        numbers = draw_numbers(self.np_random, len(places))
        chosen = self.np_random.integers(len(self._opponents), size=len(places))
        self._episodes.begin(places, numbers, self._opponents[chosen])

    def _observations(self) -> np.ndarray:
        return self._episodes.observations[self._robot].copy()
