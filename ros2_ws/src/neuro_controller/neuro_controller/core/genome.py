"""The genome: numbers in [-5, 5] that make a controller (paper A2, A3); 442 of the paper's.

The paper gives the total; the order is that of the authors' library.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from marxbot_sensors import MARXBOT, Robot

HIDDEN = 10
"""Hidden neurons of the paper's controller."""

MAX_HIDDEN = 100

OUTPUTS = 2
GENE_RANGE = 5.0
"""Genes lie in [-GENE_RANGE, GENE_RANGE]."""

OWN_INPUTS = ('clock', 'fatigue')
"""Sensory neurons that the controller fills itself, after those of the robot's sensors."""


@dataclass(frozen=True)
class Layout:
    """What a controller is made of, and where its parts lie in the genome.

    Parameters
    ----------
    hidden : int
        Hidden neurons, from 1 to `MAX_HIDDEN`.
    robot : marxbot_sensors.Robot
        Whose sensors drive the sensory neurons.

    Raises
    ------
    ValueError
        There are too few or too many hidden neurons, in one sentence.
    """

    hidden: int = HIDDEN
    robot: Robot = MARXBOT

    def __post_init__(self) -> None:
        if not 1 <= self.hidden <= MAX_HIDDEN:
            raise ValueError(f'hidden is {self.hidden}, expected 1 to {MAX_HIDDEN} hidden neurons')

    @classmethod
    def of(cls, genes: int, robot: Robot = MARXBOT, name: str = 'genome') -> Layout:
        """Return the layout that has so many genes: their number tells that of hidden neurons.

        Raises
        ------
        ValueError
            None has, in a sentence that starts with `name`.
        """
        for hidden in range(1, MAX_HIDDEN + 1):
            layout = cls(hidden, robot)
            if layout.genes == genes:
                return layout
        usual = cls(robot=robot)
        raise ValueError(
            f'{name} has {genes} genes, expected {usual.genes} as {usual} needs, or what 1 to '
            f'{MAX_HIDDEN} hidden neurons need'
        )

    @property
    def inputs(self) -> int:
        """Sensory neurons."""
        return self.robot.neurons + len(OWN_INPUTS)

    @property
    def scales(self) -> tuple[float, ...]:
        """See `marxbot_sensors.Robot`."""
        return self.robot.scales

    @property
    def offsets(self) -> tuple[float, ...]:
        """See `marxbot_sensors.Robot`."""
        return self.robot.offsets

    @property
    def clock(self) -> int:
        """Place of the clock neuron among the sensory ones."""
        return self.robot.neurons

    @property
    def fatigue(self) -> int:
        """Place of the fatigue neuron among the sensory ones."""
        return self.robot.neurons + 1

    @property
    def output_biases(self) -> int:
        """First of the biases of the outputs; those of the hidden neurons come before."""
        return self.hidden

    @property
    def input_to_hidden(self) -> int:
        """First weight, by target: those of hidden neuron 0, then those of neuron 1 ..."""
        return self.hidden + OUTPUTS

    @property
    def hidden_to_hidden(self) -> int:
        """First weight, by target."""
        return self.input_to_hidden + self.inputs * self.hidden

    @property
    def leaks(self) -> int:
        """First of the genes g that are each a hidden neuron's leak d = |g| / GENE_RANGE."""
        return self.hidden_to_hidden + self.hidden * self.hidden

    @property
    def input_to_output(self) -> int:
        """First weight, by target."""
        return self.leaks + self.hidden

    @property
    def hidden_to_output(self) -> int:
        """First weight, by target."""
        return self.input_to_output + self.inputs * OUTPUTS

    @property
    def genes(self) -> int:
        """Genes of a genome."""
        return self.hidden_to_output + self.hidden * OUTPUTS

    @property
    def inputs_are(self) -> str:
        """What the sensory neurons are, for people."""
        return ', '.join([self.robot.neurons_are, *OWN_INPUTS])

    def __str__(self) -> str:
        return f'a network of {self.inputs} sensory and {self.hidden} hidden neurons'


LAYOUT = Layout()
"""That of the paper."""

GENES = LAYOUT.genes


def random_genomes(count, generator, layout=LAYOUT):
    """Return genomes drawn uniformly from the gene range (paper A3).

    Parameters
    ----------
    count : int
    generator : numpy.random.Generator
    layout : Layout

    Returns
    -------
    float32 array, shape (count, layout.genes)

    Examples
    --------
    >>> import numpy as np
    >>> random_genomes(3, np.random.default_rng(1)).shape
    (3, 442)
    """
    return generator.uniform(-GENE_RANGE, GENE_RANGE, (count, layout.genes)).astype(np.float32)


def check_genomes(genomes, name='genomes', layout=None):
    """Return the genomes as a C-contiguous float32 array of shape (n, genes).

    Parameters
    ----------
    genomes : array_like
    name : str
    layout : Layout, optional
        What they must be genomes of; without it, of any number of hidden neurons of a MarxBot.

    Raises
    ------
    ValueError
        In one sentence that starts with `name`, if the shape is another, or a gene is NaN or out
        of range.
    """
    expected = (layout or LAYOUT).genes
    try:
        genomes = np.asarray(genomes, dtype=np.float32)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(
            f'{name} is not an array of numbers, expected shape (n, {expected})'
        ) from None
    if genomes.ndim != 2:
        raise ValueError(f'{name} has shape {genomes.shape}, expected (n, {expected})')
    genes = genomes.shape[1]
    if layout is None:
        Layout.of(genes, name=name)
    elif genes != expected:
        raise ValueError(f'{name} has {genes} genes, expected {expected} as {layout} needs')
    wrong = ~(np.abs(genomes) <= GENE_RANGE)
    if wrong.any():
        row, gene = np.argwhere(wrong)[0]
        raise ValueError(
            f'{name} has the value {genomes[row, gene]} as gene {gene} of genome {row}, '
            f'expected a number in [-{GENE_RANGE:g}, {GENE_RANGE:g}]'
        )
    return np.ascontiguousarray(genomes)


def weights_of(genomes, layout):
    """Return what `network.control` multiplies with: the genes, each leak gene g as |g| / 5.

    Parameters
    ----------
    genomes : float32 array, shape (..., layout.genes)
    layout : Layout

    Returns
    -------
    float32 array of the same shape
    """
    weights = np.array(genomes, dtype=np.float32)
    leaks = weights[..., layout.leaks : layout.leaks + layout.hidden]
    np.divide(np.abs(leaks), np.float32(GENE_RANGE), out=leaks)
    return weights
