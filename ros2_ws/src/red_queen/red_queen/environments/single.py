"""The chase for Gymnasium: one robot learns against frozen opponents."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np

from coevo_manager.core.environment import Environment
from coevo_manager.core.species import SPECIES
from neuro_controller.core.genome import OUTPUTS
from red_queen.environments.chase import (
    METADATA,
    Chase,
    action_space,
    check_actions,
    observation_space,
    read_opponents,
)


class ChaseEnv(gymnasium.Env):
    """A predator or a prey against opponents that do not learn.

    Observation, action, reward and end of an episode are those of `ChaseParallelEnv`.

    Parameters
    ----------
    species : str
        The learner's: 'predator' or 'prey'.
    opponent : str or array_like, shape (genes,) or (k, genes)
        A champion as `red_queen.select_champion` reads it, or genomes, of which each episode draws
        one.
    environment : Environment, optional
        Without it that in which the champion evolved; for genomes, the world `faithful`.
    render_mode : str, optional
        'rgb_array' or 'human'.

    Raises
    ------
    ValueError
        A value is none of those, in one sentence.

    Examples
    --------
    >>> import gymnasium
    >>> env = gymnasium.make('red_queen.environments:RedQueen/Chase-v0', species='prey')
    >>> observation, info = env.reset(seed=1)
    >>> observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
    >>> reward
    0.001
    """

    metadata: dict[str, Any] = METADATA

    def __init__(
        self,
        species: str = 'prey',
        opponent: Any = 'shipped/open',
        environment: Environment | None = None,
        render_mode: str | None = None,
    ) -> None:
        self._opponents, environment = read_opponents(species, opponent, environment)
        self._robot = SPECIES.index(species)
        driven = species == 'predator', species == 'prey'
        self._chase = Chase(environment, driven, render_mode)
        self.render_mode = render_mode
        self.observation_space = observation_space()
        self.action_space = action_space()

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin an episode, see `ChaseParallelEnv.reset`."""
        super().reset(seed=seed)
        opponent = self._opponents[self.np_random.integers(len(self._opponents))]
        self._chase.begin(self.np_random, options, opponent)
        return self._chase.observation(self._robot), {}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Make a tick."""
        chosen = check_actions(action, (OUTPUTS,))
        earned, captured, over = self._chase.step({self._robot: chosen})
        observation = self._chase.observation(self._robot)
        return observation, float(earned[self._robot]), captured, over, {}

    def render(self) -> np.ndarray | None:
        """Return a picture, uint8 (height, width, 3), or show it, as the render mode says."""
        return self._chase.render()

    def close(self) -> None:
        """Close the window, if there is one."""
        self._chase.close()
