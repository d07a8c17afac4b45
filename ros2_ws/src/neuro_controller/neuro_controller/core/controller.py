"""One robot's controller, stepped from Python by the kernel that the headless batch runs."""

import numpy as np

from marxbot_sensors import MARXBOT
from neuro_controller.core.genome import OUTPUTS, Layout, check_genomes, weights_of
from neuro_controller.core.network import (
    FATIGUE_TICKS,
    MOTORS,
    STATE,
    control,
    memory_rows,
    recall,
)
from neuro_controller.core.settings import SETTING_ROWS, settings_column
from simd_lanes import aligned_rows, compile_kernel


@compile_kernel
def _recall(layout, weights, memory):
    recall(layout, weights, memory)


@compile_kernel
def _control(layout, readings, weights, settings, memory, history, slot, inputs, wheels):
    control(layout, readings, weights, settings, memory, history, slot, inputs, wheels)


class Controller:
    """The neural controller of one robot (paper A2).

    Parameters
    ----------
    genome : array_like, shape (genes,)
        Genes in [-5, 5]; their number tells that of the hidden neurons.
    max_wheel_speed : float
        The paper's ms, rad/s.
    motor_map : str
        One of `MOTOR_MAPS`.
    episode_ticks : int
        Ticks after which the clock neuron reads 1.
    infrared_response : str
        One of `INFRARED_RESPONSES`.
    ground_coding : str
        One of `GROUND_CODINGS`.
    robot : marxbot_sensors.Robot
        Whose sensors it reads.

    Attributes
    ----------
    layout : neuro_controller.core.genome.Layout
        What it is made of.

    Raises
    ------
    ValueError
        If one of them is out of its range, in one sentence.
    """

    def __init__(
        self,
        genome,
        max_wheel_speed,
        motor_map='signed',
        episode_ticks=1000,
        infrared_response='squared',
        ground_coding='relative',
        robot=MARXBOT,
    ):
        settings = settings_column(
            max_wheel_speed, motor_map, episode_ticks, infrared_response, ground_coding
        )
        self._settings = aligned_rows(SETTING_ROWS)
        self._settings[:] = settings[:, None]
        self.layout = Layout.of(np.size(genome), robot)
        genomes = check_genomes(np.reshape(genome, (1, -1)), 'genome', self.layout)
        self._weights = aligned_rows(self.layout.genes)
        self._weights[:] = weights_of(genomes, self.layout).T
        self._readings = aligned_rows(robot.readings)
        self._inputs = aligned_rows(self.layout.inputs)
        self._wheels = aligned_rows(2)
        self.reset()

    def reset(self):
        """Forget the past: hidden neurons, fatigue and clock start at 0."""
        self._memory = aligned_rows(memory_rows(self.layout))
        _recall(self.layout, self._weights, self._memory)
        self._history = aligned_rows(FATIGUE_TICKS)
        self._slot = 0

    def step(self, readings):
        """Run one tick.

        Parameters
        ----------
        readings : array_like, shape (robot.readings,)
            What the robot's sensors read, in their order.

        Returns
        -------
        float32 array, shape (2,)
            Speeds of the left and right wheel, rad/s.
        """
        self._readings[:] = np.asarray(readings, dtype=np.float32)[:, None]
        _control(
            self.layout,
            self._readings,
            self._weights,
            self._settings,
            self._memory,
            self._history,
            self._slot,
            self._inputs,
            self._wheels,
        )
        self._slot = (self._slot + 1) % FATIGUE_TICKS
        return self._wheels[:, 0].copy()

    @property
    def inputs(self):
        """The sensory neurons of the last tick, 0..1."""
        return self._inputs[:, 0].copy()

    @property
    def hidden(self):
        """The hidden neurons after the last tick, 0..1."""
        return self._memory[STATE : STATE + self.layout.hidden, 0].copy()

    @property
    def outputs(self):
        """The 2 motor neurons after the last tick, tm and rm, 0..1."""
        return self._memory[MOTORS : MOTORS + OUTPUTS, 0].copy()
