"""Between the messages of the evaluators' services and the arrays of core."""

from __future__ import annotations

import array
from typing import Any

import numpy as np
from coevo_msgs.msg import Environment as EnvironmentMsg
from coevo_msgs.msg import Perturbations as PerturbationsMsg
from coevo_msgs.srv import EvaluateBatch, EvaluateLineages

from coevo_manager.core.environment import Environment
from coevo_manager.core.evaluation import Batch, Lineages
from marxbot_sim.core.perturbations import Perturbations
from neuro_controller.core.genome import GENE_RANGE, Layout, check_genomes


def to_sequence(values: np.ndarray, typecode: str) -> array.array:
    """Return the values as the sequence that a message field takes without looking at each.

    Parameters
    ----------
    values : array of one dimension
        Of the type that `typecode` names.
    typecode : str
        Type of the field: 'f' for float32[], 'I' for uint32[], 'Q' for uint64[], 'i' for int32[].
    """
    return array.array(typecode, values.tobytes())


class Requests:
    """Requests in one environment; each is valid until the next, since making one costs most.

    Parameters
    ----------
    environment : coevo_msgs/Environment
    """

    def __init__(self, environment: EnvironmentMsg) -> None:
        self._batch = EvaluateBatch.Request(environment=environment)
        self._lineages = EvaluateLineages.Request(environment=environment)

    def fill(
        self, work: Batch | Lineages, number: int = 0
    ) -> EvaluateBatch.Request | EvaluateLineages.Request:
        """Return the request that asks for a batch or lineages."""
        request: EvaluateBatch.Request | EvaluateLineages.Request
        if isinstance(work, Lineages):
            request = self._lineages
            request.parents = to_sequence(work.parents, 'f')
            request.predator = work.species == 'predator'
            request.parent_ticks = to_sequence(work.parent_ticks, 'Q')
            request.opponents = to_sequence(work.opponents, 'f')
            request.redrawn = to_sequence(work.redrawn, 'I')
            request.genes = to_sequence(work.genes, 'I')
            request.values = to_sequence(work.values, 'f')
        else:
            request = self._batch
            request.predators = to_sequence(work.predators, 'f')
            request.prey = to_sequence(work.prey, 'f')
            request.predator_index = to_sequence(work.predator_index, 'I')
            request.prey_index = to_sequence(work.prey_index, 'I')
        request.number = number
        request.noise = work.noise
        return request


def to_batch(request: EvaluateBatch.Request) -> Batch:
    """Return the episodes of a request, checked, without copying its genomes.

    Raises
    ------
    ValueError
        A genome's length or a gene, or an index, is wrong: one sentence.
    """
    layout = Layout(request.environment.hidden)
    predators = _to_genomes(request.predators, 'predators', layout)
    prey = _to_genomes(request.prey, 'prey', layout)
    predator_index = _to_index(request.predator_index, len(predators), 'predator_index')
    prey_index = _to_index(request.prey_index, len(prey), 'prey_index')
    if len(predator_index) != len(prey_index):
        raise ValueError(
            f'prey_index has {len(prey_index)} entries, expected {len(predator_index)} '
            'as predator_index'
        )
    return Batch(predators, prey, predator_index, prey_index, request.noise)


def to_lineages(request: EvaluateLineages.Request) -> Lineages:
    """Return the lineages of a request, checked, without copying their genomes.

    Raises
    ------
    ValueError
        A genome's length or a gene is wrong, or there is too little of something: one sentence.
    """
    layout = Layout(request.environment.hidden)
    parents = _to_genomes(request.parents, 'parents', layout)
    opponents = _to_genomes(request.opponents, 'opponents', layout)
    redrawn = np.frombuffer(request.redrawn, np.uint32)
    for name, given in (('parents', parents), ('opponents', opponents), ('redrawn', redrawn)):
        if not len(given):
            raise ValueError(f'{name} is empty, expected at least one')
    parent_ticks = np.frombuffer(request.parent_ticks, np.uint64)
    if len(parent_ticks) != len(parents):
        raise ValueError(
            f'parent_ticks has {len(parent_ticks)} entries, expected {len(parents)} as parents'
        )
    if len(redrawn) % len(parents):
        raise ValueError(
            f'redrawn has {len(redrawn)} entries, expected as many for each of {len(parents)} '
            'parents'
        )
    genes = _to_index(request.genes, layout.genes, 'genes')
    values = np.frombuffer(request.values, np.float32)
    changes = int(redrawn.sum(dtype=np.uint64))
    for name, entries in (('genes', genes), ('values', values)):
        if len(entries) != changes:
            raise ValueError(f'{name} has {len(entries)} entries, expected {changes} by redrawn')
    if not (np.abs(values) <= GENE_RANGE).all():
        wrong = values[~(np.abs(values) <= GENE_RANGE)][0]
        raise ValueError(
            f'values has the value {wrong:g}, expected a number in [-{GENE_RANGE:g}, '
            f'{GENE_RANGE:g}]'
        )
    species = 'predator' if request.predator else 'prey'
    return Lineages(
        species,
        parents,
        parent_ticks,
        opponents,
        redrawn.reshape(len(parents), -1),
        genes,
        values,
        request.noise,
    )


def _to_genomes(sequence: array.array, name: str, layout: Layout) -> np.ndarray:
    genes = np.frombuffer(sequence, np.float32)
    if genes.size % layout.genes:
        raise ValueError(
            f'{name} has {genes.size} numbers, expected {layout.genes} for each genome'
        )
    genomes = genes.reshape(-1, layout.genes)
    if not genes.size or (genes.min() >= -GENE_RANGE and genes.max() <= GENE_RANGE):
        return genomes
    return check_genomes(genomes, name, layout)  # says what is wrong


def _to_index(sequence: array.array, count: int, name: str) -> np.ndarray:
    index = np.frombuffer(sequence, np.uint32)
    if index.size and index.max() >= count:
        expected = f'0 to {count - 1}' if count else 'none, for want of genomes'
        raise ValueError(f'{name} has the value {index.max()}, expected {expected}')
    return index


def to_environment_message(environment: Environment) -> EnvironmentMsg:
    """Return the message of an environment."""
    return _to_message(environment, EnvironmentMsg)


def to_environment(message: EnvironmentMsg) -> Environment:
    """Return the environment of a message; a predator_speed of 0 is the default.

    Raises
    ------
    ValueError
        A field is out of its range.
    """
    values = _to_values(message)
    values['predator_speed'] = values['predator_speed'] or None
    values['perturbations'] = Perturbations(**_to_values(message.perturbations))
    return Environment(**values)


def _to_message(parameters, kind: Any):
    """Return the message of a dataclass whose fields have the same names."""
    message = kind()
    for name, type_name in kind.get_fields_and_field_types().items():
        value = getattr(parameters, name)
        if type_name == 'double':
            value = float(value)
        elif type_name == 'coevo_msgs/Perturbations':
            value = _to_message(value, PerturbationsMsg)
        setattr(message, name, value)
    return message


def _to_values(message) -> dict:
    return {name: getattr(message, name) for name in message.get_fields_and_field_types()}
