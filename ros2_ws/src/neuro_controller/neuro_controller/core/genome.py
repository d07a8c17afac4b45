"""The genome: 442 numbers in [-5, 5] that make a controller (paper A2, A3).

The paper gives the total; the order is that of the authors' library.
"""

import numpy as np

SENSORS = 25
HIDDEN = 10
OUTPUTS = 2
GENE_RANGE = 5.0
"""Genes lie in [-GENE_RANGE, GENE_RANGE]."""

HIDDEN_BIASES = 0
OUTPUT_BIASES = HIDDEN_BIASES + HIDDEN
SENSOR_TO_HIDDEN = OUTPUT_BIASES + OUTPUTS
"""First of 250 weights, by target: the 25 of hidden neuron 0, then those of neuron 1 ..."""
HIDDEN_TO_HIDDEN = SENSOR_TO_HIDDEN + SENSORS * HIDDEN
LEAKS = HIDDEN_TO_HIDDEN + HIDDEN * HIDDEN
"""First of 10 genes g, each a neuron's leak d = |g| / GENE_RANGE."""
SENSOR_TO_OUTPUT = LEAKS + HIDDEN
HIDDEN_TO_OUTPUT = SENSOR_TO_OUTPUT + SENSORS * OUTPUTS
GENES = HIDDEN_TO_OUTPUT + HIDDEN * OUTPUTS


def random_genomes(count, generator):
    """Return genomes drawn uniformly from the gene range (paper A3).

    Parameters
    ----------
    count : int
    generator : numpy.random.Generator

    Returns
    -------
    float32 array, shape (count, 442)

    Examples
    --------
    >>> import numpy as np
    >>> random_genomes(3, np.random.default_rng(1)).shape
    (3, 442)
    """
    return generator.uniform(-GENE_RANGE, GENE_RANGE, (count, GENES)).astype(np.float32)


def check_genomes(genomes, name='genomes'):
    """Return the genomes as a C-contiguous float32 array of shape (n, 442).

    Raises
    ------
    ValueError
        In one sentence that starts with `name`, if the shape is another, or a gene is NaN or out
        of range.
    """
    try:
        genomes = np.asarray(genomes, dtype=np.float32)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(
            f'{name} is not an array of numbers, expected shape (n, {GENES})'
        ) from None
    if genomes.ndim != 2 or genomes.shape[1] != GENES:
        raise ValueError(f'{name} has shape {genomes.shape}, expected (n, {GENES})')
    wrong = ~(np.abs(genomes) <= GENE_RANGE)
    if wrong.any():
        row, gene = np.argwhere(wrong)[0]
        raise ValueError(
            f'{name} has the value {genomes[row, gene]} as gene {gene} of genome {row}, '
            f'expected a number in [-{GENE_RANGE:g}, {GENE_RANGE:g}]'
        )
    return np.ascontiguousarray(genomes)


def weights_of(genomes):
    """Return what `network.control` multiplies with: the genes, each leak gene g as |g| / 5.

    Parameters
    ----------
    genomes : float32 array, shape (..., 442)

    Returns
    -------
    float32 array of the same shape
    """
    weights = np.array(genomes, dtype=np.float32)
    leaks = weights[..., LEAKS : LEAKS + HIDDEN]
    np.divide(np.abs(leaks), np.float32(GENE_RANGE), out=leaks)
    return weights
