"""Eight episodes side by side, and how the kernel plays them under kinematic physics."""

import numpy as np

from coevo_manager.core.episodes.kernel import COMPLEXITY_ROWS, Rows, run_episodes
from coevo_manager.core.episodes.schedule import IDLE
from marxbot_sim.core.disturbance import make_disturbance
from marxbot_sim.core.layout import WHEEL_ROWS
from marxbot_sim.core.starts import make_starts
from marxbot_sim.core.world import arena_rows, start_bodies
from neuro_controller.core.network import FATIGUE_TICKS, memory_rows
from neuro_controller.core.settings import SETTING_ROWS, settings_column
from simd_lanes import HALF, aligned_rows


class EpisodeLanes:
    """Eight episodes: their numbers, the state of their robots and of the robots' perturbations.

    Parameters
    ----------
    environment : Environment
    bodies, wheels : float32 arrays, shapes (BODY_ROWS, 16) and (WHEEL_ROWS, 16), optional
        Where poses are found and the speeds of the wheels put; own arrays without them.
    """

    def __init__(self, environment, bodies=None, wheels=None):
        settings = aligned_rows(SETTING_ROWS)
        for robot, speed in enumerate(environment.max_wheel_speeds):
            column = settings_column(speed, **environment.network_settings)
            settings[:, robot * HALF : robot * HALF + HALF] = column[:, None]
        self.layout = layout = environment.layout
        self.episode = np.full(HALF, IDLE, dtype=np.int64)
        self.rows = Rows(
            start=start_bodies(),
            bodies=start_bodies() if bodies is None else bodies,
            arena=arena_rows(environment.arena),
            readings=aligned_rows(layout.robot.readings),
            weights=aligned_rows(layout.genes),
            settings=settings,
            memory=aligned_rows(memory_rows(layout)),
            history=aligned_rows(FATIGUE_TICKS),
            inputs=aligned_rows(layout.inputs),
            wheels=aligned_rows(WHEEL_ROWS) if wheels is None else wheels,
            complexity=aligned_rows(COMPLEXITY_ROWS),
        )
        self.disturbance = make_disturbance(
            environment.perturbations, environment.max_wheel_speeds
        )
        self.starts = make_starts(environment.perturbations)


class KinematicPlayer:
    """Plays queued episodes, eight at a time, in the compiled kernel.

    Parameters
    ----------
    environment : Environment
    measure : bool
        Whether to measure the complexity of the behaviours.
    """

    def __init__(self, environment, measure):
        self._environment = environment
        self._measure = measure
        self._lanes = EpisodeLanes(environment)
        self._clock = np.zeros(1, dtype=np.int64)

    def play(self, rings):
        """Play on; return whether a request is finished by that.

        It returns as soon as one is, or an episode ends while there is no other to take its lanes.

        Parameters
        ----------
        rings : schedule.Rings
        """
        environment, lanes = self._environment, self._lanes
        return run_episodes(
            lanes.layout,
            lanes.episode,
            self._clock,
            lanes.rows,
            environment.obstacle,
            self._measure,
            environment.episode_ticks,
            lanes.disturbance,
            lanes.starts,
            environment.perturbations.seed,
            rings,
        )
