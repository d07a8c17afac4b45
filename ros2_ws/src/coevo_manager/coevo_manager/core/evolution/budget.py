"""What a run may cost: phases, episodes, ticks, whichever is spent first."""

from __future__ import annotations

from coevo_manager.core.configuration import MAX_GENERATIONS, Configuration
from coevo_manager.core.evolution import algorithms, optimizers
from coevo_manager.core.evolution.state import State


class RunBudget:
    """Costs of a configuration, known beforehand but for the length of episodes.

    Attributes
    ----------
    first : int
        Episodes of the first evaluation: N x N, times those of each pair, as in all that follows.
    measures_agents, measures_evolved : bool
        Whether a phase measures its agents against its opponents when it begins and when it has
        ended, since what it measures in fresh noise is comparable with nothing else.
    generation : int
        Episodes of a generation: each agent's k candidates against n opponents, and the agent
        where parents are evaluated again.
    """

    def __init__(self, configuration: Configuration) -> None:
        population, selected = configuration.population, configuration.selected
        candidates = optimizers.load(configuration.optimizer).candidates(configuration)
        algorithm = algorithms.load(configuration.algorithm)
        self._agents = algorithm.lineages(configuration)
        self._incumbents = population if algorithm.external_opponents else 0
        fresh = configuration.fresh_noise != 'never'
        compares = optimizers.load(configuration.optimizer).compares_generations(configuration)
        self.measures_agents = fresh and compares and not configuration.reevaluate_parents
        self.measures_evolved = fresh and algorithm.external_opponents
        self._configuration = configuration
        each = configuration.episodes_per_opponent
        self.first = population * population * each
        candidates += configuration.reevaluate_parents
        self.generation = self._agents * candidates * selected * each

    def overhead(self, rivals: int) -> int:
        """Return the episodes of a phase outside its generations.

        The agents meet all rivals, n x N, and the N incumbents opponents from elsewhere; agents
        may be measured.
        """
        configuration = self._configuration
        measured = self._agents * (self.measures_agents + self.measures_evolved)
        episodes = self._agents * rivals + (self._incumbents + measured) * configuration.selected
        return episodes * configuration.episodes_per_opponent

    def generations_left(self, state: State, rivals: int) -> int:
        """Return the length of the next phase, in generations; 0 when the run has ended.

        A phase is shortened where the budget of episodes demands it, and where the budget of
        ticks might: every episode of the phase is taken to last to its end.
        """
        configuration = self._configuration
        if configuration.phases is not None and state.phase >= configuration.phases:
            return 0
        left = configuration.generations
        for limit, spent, longest in (
            (configuration.episodes, state.episodes, 1),
            (configuration.ticks, state.ticks, configuration.episode_ticks),
        ):
            if limit is not None:
                episodes = (limit - spent) // longest
                left = min(left, (episodes - self.overhead(rivals)) // self.generation)
        return max(left, 0)

    def progress(self, generation: int, episodes: int, ticks: int) -> float:
        """Return the share spent of the budget, 0 to 1."""
        configuration = self._configuration
        shares = [0.0]
        if configuration.phases is not None:
            shares.append(generation / (configuration.phases * configuration.generations))
        if configuration.episodes is not None:
            shares.append(episodes / configuration.episodes)
        if configuration.ticks is not None:
            shares.append(ticks / configuration.ticks)
        return min(max(shares), 1.0)


def check(configuration: Configuration) -> None:
    """Raise ValueError where no budget is given, or one too small or too large."""
    if configuration.phases is configuration.episodes is configuration.ticks is None:
        raise ValueError(
            'phases is None, expected a number where neither episodes nor ticks is given'
        )
    most = MAX_GENERATIONS // configuration.generations
    if configuration.phases is not None and configuration.phases > most:
        raise ValueError(
            f'phases is {configuration.phases}, expected at most {most} of '
            f'{configuration.generations} generations each'
        )
    costs = RunBudget(configuration)
    least = costs.first + costs.overhead(configuration.population) + costs.generation
    for name, longest in (('episodes', 1), ('ticks', configuration.episode_ticks)):
        limit = getattr(configuration, name)
        if limit is not None and limit < least * longest:
            raise ValueError(
                f'{name} is {limit}, expected at least {least * longest}, the cost of the first '
                'evaluation and one generation'
            )
