"""What the environments share: spaces, rewards, opponents, and one chase played from outside."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium.spaces import Box

from coevo_manager.core.environment import Environment
from coevo_manager.core.episodes.stepped import SteppedEpisodes
from coevo_manager.core.provenance import choose_environment
from coevo_manager.core.species import OTHER, SPECIES
from marxbot_sim.core.fields import check_choice
from marxbot_sim.core.parameters import TICK
from neuro_controller.core.champions import select_champion
from neuro_controller.core.genome import LAYOUT, OUTPUTS, check_genomes
from red_queen.environments.picture import Picture

RENDER_MODES = ['human', 'rgb_array']
METADATA = {'render_modes': RENDER_MODES, 'render_fps': round(1 / TICK)}


def observation_space() -> Box:
    """Return the space of the sensory neurons: float32 of shape (25,), 0..1."""
    return Box(0.0, 1.0, (LAYOUT.inputs,), np.float32)


def action_space() -> Box:
    """Return the space of the motor neurons tm and rm: float32 of shape (2,), 0..1."""
    return Box(0.0, 1.0, (OUTPUTS,), np.float32)


def rewards(captured: np.ndarray, ticks: np.ndarray, episode_ticks: int) -> np.ndarray:
    """Return what predators and prey get for a tick, so that the return is the fitness.

    A prey gets 1/T for each tick that it lives, so t/T in all. A predator gets the share of the
    episode that is left, 1 - t/T, when it captures the prey, and nothing else.

    Parameters
    ----------
    captured : bool array, shape (n,)
    ticks : int array, shape (n,)
        Ticks made.
    episode_ticks : int
        Length of an episode, T.

    Returns
    -------
    float64 array, shape (2, n)
    """
    hunted = np.where(captured, 1.0 - ticks / episode_ticks, 0.0)
    return np.stack([hunted, np.full(len(ticks), 1.0 / episode_ticks)])


def check_actions(actions: Any, shape: tuple[int, ...]) -> np.ndarray:
    """Return motor neurons as float32, or raise ValueError in one sentence."""
    actions = np.asarray(actions, np.float32)
    if actions.shape != shape:
        raise ValueError(f'actions have shape {actions.shape}, expected {shape}')
    if np.isnan(actions).any():
        raise ValueError('actions hold NaN, expected numbers from 0 to 1')
    return actions


def read_opponents(
    species: str, opponent: Any, environment: Environment | None
) -> tuple[np.ndarray, Environment]:
    """Return the genomes of frozen opponents, and the environment in which to meet them.

    Parameters
    ----------
    species : str
        The learner's, 'predator' or 'prey'.
    opponent : str or array_like, shape (genes,) or (k, genes)
        A champion, named as `select_champion` reads it, or genomes.
    environment : Environment, optional
        Without it that in which the champion evolved; for genomes, the world `faithful`.

    Returns
    -------
    genomes : float32 array, shape (k, genes)
    environment : Environment

    Raises
    ------
    ValueError
        There is no such species or opponent, in one sentence.
    """
    check_choice('species', species, SPECIES)
    if isinstance(opponent, str):
        champion = select_champion(opponent, OTHER[species])
        if environment is None:
            environment, _ = choose_environment([champion], {})
        opponent = champion.genome
    environment = environment or Environment()
    genomes = check_genomes(np.atleast_2d(opponent), 'opponent', environment.layout)
    if not len(genomes):
        raise ValueError('opponent holds no genome, expected at least one')
    return genomes, environment


def draw_numbers(rng: np.random.Generator, count: int) -> np.ndarray:
    """Draw the numbers of episodes, under which robots draw their starts and noise."""
    return rng.integers(2**64, size=(count, 2), dtype=np.uint64)


class Chase:
    """One episode at a time, one robot or both of which are driven from outside.

    Parameters
    ----------
    environment : Environment
    driven : tuple of two bool
        Whether predator and prey are.
    render_mode : str, optional
        'human', 'rgb_array' or None.

    Raises
    ------
    ValueError
        There is no such mode, or the environment's physics is not kinematic.
    """

    def __init__(
        self,
        environment: Environment,
        driven: tuple[bool, bool],
        render_mode: str | None,
    ) -> None:
        if render_mode is not None:
            check_choice('render_mode', render_mode, RENDER_MODES)
        self.environment = environment
        self._episode = SteppedEpisodes(environment, 1, driven)
        self._picture = Picture(environment.arena, render_mode)

    def begin(
        self,
        rng: np.random.Generator,
        options: Mapping[str, Any] | None,
        opponent: np.ndarray | None = None,
    ) -> None:
        """Begin an episode.

        Parameters
        ----------
        rng : Generator
            Draws the episode's number for each robot.
        options : mapping, optional
            'episode_numbers': those numbers instead, of predator and prey.
        opponent : float32 array, shape (genes,), optional
            Genome of the robot that is not driven.
        """
        numbers = (options or {}).get('episode_numbers')
        if numbers is None:
            numbers = draw_numbers(rng, 1)[0]
        numbers = np.array(numbers, np.uint64).reshape(1, 2)
        self._episode.begin([0], numbers, None if opponent is None else opponent[None])
        self._picture.begin(self._episode.poses(0))

    def step(self, actions: Mapping[int, np.ndarray]) -> tuple[np.ndarray, bool, bool]:
        """Make a tick.

        Parameters
        ----------
        actions : mapping of int to float32 array, shape (2,)
            Motor neurons by robot, 0 the predator.

        Returns
        -------
        rewards : float64 array, shape (2,)
        captured, over : bool
            Whether the prey was captured; if not, whether the episode's time is over.
        """
        for robot, action in actions.items():
            self._episode.actions[robot, 0] = action
        self._episode.step()
        captured, ticks = self._episode.captured, self._episode.ticks
        self._picture.add(self._episode.poses(0))
        episode_ticks = self.environment.episode_ticks
        ended = bool(captured[0])
        over = not ended and bool(ticks[0] >= episode_ticks)
        return rewards(captured, ticks, episode_ticks)[:, 0], ended, over

    def observation(self, robot: int) -> np.ndarray:
        """Return the sensory neurons of a driven robot, float32 (25,)."""
        return self._episode.observations[robot, 0].copy()

    def render(self) -> np.ndarray | None:
        """Return the present picture, or show it, as the render mode says."""
        return self._picture.render()

    def close(self) -> None:
        """Close the window, if there is one."""
        self._picture.close()
