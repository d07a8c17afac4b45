"""The chase for PettingZoo: both robots learn."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from gymnasium.spaces import Box
from gymnasium.utils.seeding import np_random
from pettingzoo import ParallelEnv

from coevo_manager.core.environment import Environment
from coevo_manager.core.species import SPECIES
from neuro_controller.core.genome import OUTPUTS
from red_queen.environments.chase import (
    METADATA,
    Chase,
    action_space,
    check_actions,
    observation_space,
)


class ChaseParallelEnv(ParallelEnv):
    """A predator and a prey, a tick of 0.1 s at a time.

    An agent observes its 25 sensory neurons and sets its two motor neurons, each 0..1. The return
    of an episode is the fitness of the paper. The episode terminates when the prey is captured and
    is truncated after ``environment.episode_ticks``.

    Parameters
    ----------
    environment : Environment
        The world, see `red_queen.make_environment`.
    render_mode : str, optional
        'rgb_array' or 'human'.

    Raises
    ------
    ValueError
        The physics is not kinematic, or there is no such mode.

    Examples
    --------
    >>> env = ChaseParallelEnv()
    >>> observations, infos = env.reset(seed=1)
    >>> actions = {agent: env.action_space(agent).sample() for agent in env.agents}
    >>> observations, rewards, terminations, truncations, infos = env.step(actions)
    >>> rewards
    {'predator': 0.0, 'prey': 0.001}
    """

    metadata: ClassVar[dict[str, Any]] = {'name': 'red_queen_chase_v0', **METADATA}
    possible_agents: ClassVar[list[str]] = list(SPECIES)

    def __init__(
        self, environment: Environment = Environment(), render_mode: str | None = None
    ) -> None:
        self.render_mode = render_mode
        self.agents: list[str] = []
        self._chase = Chase(environment, (True, True), render_mode)
        self._np_random: np.random.Generator | None = None
        self.observation_spaces = {agent: observation_space() for agent in self.possible_agents}
        self.action_spaces = {agent: action_space() for agent in self.possible_agents}

    def observation_space(self, agent: str) -> Box:
        """Return the space of an agent's sensory neurons."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> Box:
        """Return the space of an agent's motor neurons."""
        return self.action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, np.ndarray], dict[str, dict[str, Any]]]:
        """Begin an episode.

        Parameters
        ----------
        seed : int, optional
            Seeds the starts and the noise of this episode and of those that follow.
        options : dict, optional
            ``'episode_numbers'``: under which predator and prey draw starts and noise.
            With those of the opponents' genomes the episode is that of the kernel.
        """
        if seed is not None or self._np_random is None:
            self._np_random, _ = np_random(seed)
        self.agents = list(self.possible_agents)
        self._chase.begin(self._np_random, options)
        return self._observations(), {agent: {} for agent in self.agents}

    def step(self, actions: dict[str, np.ndarray]) -> tuple[dict[str, Any], ...]:
        """Make a tick; both agents must act."""
        chosen = {
            robot: check_actions(actions[agent], (OUTPUTS,))
            for robot, agent in enumerate(self.agents)
        }
        earned, captured, over = self._chase.step(chosen)
        agents = self.agents
        answer: tuple[dict[str, Any], ...] = (
            self._observations(),
            {agent: float(earned[robot]) for robot, agent in enumerate(agents)},
            dict.fromkeys(agents, captured),
            dict.fromkeys(agents, over),
            {agent: {} for agent in agents},
        )
        if captured or over:
            self.agents = []
        return answer

    def render(self) -> np.ndarray | None:
        """Return a picture, uint8 (height, width, 3), or show it, as the render mode says."""
        return self._chase.render()

    def close(self) -> None:
        """Close the window, if there is one."""
        self._chase.close()

    def _observations(self) -> dict[str, np.ndarray]:
        return {agent: self._chase.observation(i) for i, agent in enumerate(self.agents)}
