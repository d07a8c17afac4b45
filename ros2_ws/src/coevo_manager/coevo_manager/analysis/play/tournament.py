"""Post-evaluation of populations against each other, stored by content.

A `Block` is every predator of one set against every prey of another. Its result is kept in a file
named by a hash of the genomes, the environment and the kernel's version: a second analysis, or one
with a replication more, evaluates only what is new, and an interrupted one continues where it was.
"""

import concurrent.futures as futures_module
import hashlib
import io
import json
import multiprocessing
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from coevo_manager.analysis.play.kernel import Kernel
from coevo_manager.analysis.runs import AnalysisError
from coevo_manager.core.episodes import Environment
from coevo_manager.core.evolution.files import write_whole
from neuro_controller.core.reading import ReadingError, read_arrays

EPISODES_A_CALL = 5000  # at least a good part of a second of work


@dataclass(frozen=True, eq=False)
class Block:
    """Every predator against every prey.

    Attributes
    ----------
    predators, prey : float32 (P, genes), (Q, genes)
    environment : Environment
    complexity : bool
        Whether behavioural complexity is wanted as well.
    """

    predators: np.ndarray
    prey: np.ndarray
    environment: Environment
    complexity: bool = False

    @property
    def episodes(self) -> int:
        """Number of its episodes."""
        return len(self.predators) * len(self.prey)

    @cached_property
    def digest(self) -> str:
        """Hash of the content, without the kernel's version."""
        kind = 'complexity' if self.complexity else 'ticks'
        return content_hash(kind, asdict(self.environment), self.predators, self.prey)


class Result(NamedTuple):
    """What a block's episodes gave; rows are predators, columns prey.

    Attributes
    ----------
    fitness : float64 (P, Q)
        Predator fitness, 1 - t / T.
    complexity : float32 (P, Q, 2) or None
        Of the predator and the prey, rad/s per tick.
    """

    fitness: np.ndarray
    complexity: np.ndarray | None


class Store:
    """Results of blocks in a folder, one file each, written beside and renamed.

    Parameters
    ----------
    folder : Path
    version : str
        The kernel's.
    """

    def __init__(self, folder: Path, version: str) -> None:
        self.folder = Path(folder)
        self.version = version
        self.folder.mkdir(parents=True, exist_ok=True)

    def path(self, digest: str) -> Path:
        """Where the result of a content is, or would be."""
        name = hashlib.sha256(f'{self.version} {digest}'.encode()).hexdigest()
        return self.folder / name[:2] / f'{name}.npz'

    def save(self, digest: str, **arrays: np.ndarray) -> None:
        """Keep arrays under the hash of what they result from."""
        path = self.path(digest)
        path.parent.mkdir(exist_ok=True)
        content = io.BytesIO()
        np.savez_compressed(content, allow_pickle=False, **arrays)
        write_whole(path, content.getvalue(), durable=False)

    def load(self, digest: str) -> dict[str, np.ndarray] | None:
        """The stored arrays; None when there are none or the file is damaged."""
        try:
            return read_arrays(self.path(digest))
        except ReadingError:
            return None

    def __contains__(self, digest: str) -> bool:
        return self.path(digest).exists()


class Evaluations:
    """Evaluates blocks and other work on all cores or a cluster, or finds them in the store.

    Parameters
    ----------
    kernel : Kernel
    store : Store
    workers : int
        Threads, or processes for what is mostly Python, on this machine.
    client : distributed.Client, optional
        A Dask cluster that works instead of this machine.
    """

    def __init__(self, kernel: Kernel, store: Store, workers: int = 1, client: Any = None) -> None:
        self.kernel = kernel
        self.store = store
        self.workers = workers
        self.client = client

    def prepare(
        self, blocks: Iterable[Block], advance: Callable[[int], object] = lambda episodes: None
    ) -> int:
        """Evaluate and store what the store lacks; returns the number of episodes played.

        `advance` is told the episodes of each finished portion, stored ones included.
        """
        missing: dict[str, Block] = {}
        for block in blocks:
            if block.digest in missing or block.digest in self.store:
                advance(block.episodes)
            else:
                missing[block.digest] = block
        played = 0
        portions = list(_portions(missing.values()))
        for place, results in self._work(evaluate_portion, [(portion,) for portion in portions]):
            for block, arrays in zip(portions[place], results, strict=True):
                self.store.save(block.digest, **arrays)
                played += block.episodes
                advance(block.episodes)
        return played

    def __getitem__(self, block: Block) -> Result:
        """The result of a block, evaluated now where the store lacks it."""
        arrays = self.store.load(block.digest)
        if arrays is None or not _fits(arrays, block):
            self.store.path(block.digest).unlink(missing_ok=True)
            self.prepare([block])
            arrays = self.store.load(block.digest)
            assert arrays is not None, 'it was stored just now'
        fitness = 1.0 - arrays['ticks'] / block.environment.episode_ticks
        return Result(fitness, arrays.get('complexity'))

    def compute(
        self,
        function: Callable,
        jobs: Sequence[tuple[str, tuple]],
        processes: bool = False,
        advance: Callable[[int], object] = lambda jobs: None,
    ) -> list[np.ndarray]:
        """Results of `function(kernel, *arguments)`, arrays, through the store.

        Parameters
        ----------
        jobs : sequence of (digest, arguments)
            The digest is of all that the result depends on but the kernel's version.
        processes : bool
            The function spends its time in Python: use processes rather than threads.
        """
        found = {}
        for digest, _ in jobs:
            stored = self.store.load(digest)
            if stored is not None and 'result' in stored:
                found[digest] = stored['result']
        missing = {digest: arguments for digest, arguments in jobs if digest not in found}
        advance(len(jobs) - len(missing))
        digests = list(missing)
        for place, result in self._work(function, list(missing.values()), processes):
            self.store.save(digests[place], result=result)
            found[digests[place]] = result
            advance(1)
        return [found[digest] for digest, _ in jobs]

    def _work(
        self, function: Callable, tasks: Sequence[tuple], processes: bool = False
    ) -> Iterator[tuple[int, Any]]:
        """Yield (place of the task, result) of each task as it is done."""
        if self.client is not None:
            yield from self._work_on_cluster(function, tasks)
            return
        pool: futures_module.Executor
        if processes and self.workers > 1:
            pool = futures_module.ProcessPoolExecutor(
                min(self.workers, max(len(tasks), 1)), multiprocessing.get_context('spawn')
            )
        else:
            pool = futures_module.ThreadPoolExecutor(self.workers)
        try:
            futures = {
                pool.submit(function, self.kernel, *task): place
                for place, task in enumerate(tasks)
            }
            for future in futures_module.as_completed(futures):
                yield futures[future], future.result()
        finally:
            pool.shutdown(cancel_futures=True)

    def _work_on_cluster(
        self, function: Callable, tasks: Sequence[tuple]
    ) -> Iterator[tuple[int, Any]]:
        from distributed import KilledWorker, as_completed

        futures = {
            self.client.submit(function, self.kernel, *task, pure=False): place
            for place, task in enumerate(tasks)
        }
        try:
            for future in as_completed(futures):
                yield futures[future], future.result()
        except KilledWorker as error:
            raise AnalysisError(
                f'the Dask cluster lost its workers again and again: {error}'
            ) from None


def _fits(arrays: dict[str, np.ndarray], block: Block) -> bool:
    """Whether stored arrays have the names and shapes of a block's result."""
    shape = len(block.predators), len(block.prey)
    expected = {'ticks': shape} | ({'complexity': (*shape, 2)} if block.complexity else {})
    return {name: array.shape for name, array in arrays.items()} == expected


def content_hash(*parts: Any) -> str:
    """Hash of arrays and of values that JSON can write."""
    digest = hashlib.sha256()
    for part in parts:
        if isinstance(part, np.ndarray):
            part = hashlib.sha256(np.ascontiguousarray(part, np.float32).tobytes()).hexdigest()
        digest.update(json.dumps(part, sort_keys=True).encode() + b'\0')
    return digest.hexdigest()


def evaluate_portion(kernel: Kernel, blocks: Sequence[Block]) -> list[dict[str, np.ndarray]]:
    """Play the episodes of blocks of one environment and kind in one call of the kernel."""
    predator_index, prey_index = [], []
    predators = prey = 0
    for block in blocks:
        rows, columns = np.indices((len(block.predators), len(block.prey))).reshape(2, -1)
        predator_index.append(rows + predators)
        prey_index.append(columns + prey)
        predators += len(block.predators)
        prey += len(block.prey)
    arguments = (
        np.concatenate([block.predators for block in blocks]),
        np.concatenate([block.prey for block in blocks]),
        np.concatenate(predator_index),
        np.concatenate(prey_index),
        blocks[0].environment,
    )
    if blocks[0].complexity:
        ticks, complexity = kernel.measure(*arguments)
    else:
        ticks, complexity = kernel.ticks(*arguments), None
    results = []
    start = 0
    for block in blocks:
        shape = len(block.predators), len(block.prey)
        span = slice(start, start + block.episodes)
        arrays: dict[str, np.ndarray] = {'ticks': np.asarray(ticks[span], np.int32).reshape(shape)}
        if complexity is not None:
            arrays['complexity'] = np.asarray(complexity[span], np.float32).reshape(*shape, 2)
        results.append(arrays)
        start += block.episodes
    return results


def _portions(blocks: Iterable[Block]) -> Iterator[list[Block]]:
    """Gather blocks of one environment and kind, so that each call fills the machine."""
    groups: dict[tuple, list[Block]] = {}
    for block in blocks:
        kind = (block.environment, block.complexity)
        group = groups.setdefault(kind, [])
        group.append(block)
        if sum(b.episodes for b in group) >= EPISODES_A_CALL:
            yield groups.pop(kind)
    yield from groups.values()
