"""What scripts/bench measures; see there."""

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from bench_lockstep import lockstep_rate
from bench_loop import measure_loop
from bench_worlds import measure_worlds

from coevo_manager.core.environment import make_environment
from coevo_manager.core.episodes import Environment, EpisodeStream, evaluate_pairs
from coevo_manager.core.evolution import Evolution, load_configuration, optimizers
from coevo_manager.core.local_evaluator import LocalEvaluator
from coevo_manager.core.worlds import WORLDS
from neuro_controller.core.genome import random_genomes
from red_queen.environments import ChaseVectorEnv

ARENAS = {'open': Environment(), 'obstacle': Environment(obstacle=True)}
SMALL_BATCH = 100
CORES = len(os.sched_getaffinity(0))


class Populations:
    """80 predators and 80 prey by kind and arena, random or evolved for 4,000 generations.

    Parameters
    ----------
    quick : bool
        Evolve for a few generations only.
    """

    def __init__(self, quick):
        self._phases = 1 if quick else 40
        self._known = {}

    def __getitem__(self, key):
        if key not in self._known:
            kind, arena = key
            self._known[key] = self._random() if kind == 'random' else self._evolved(arena)
        return self._known[key]

    def _random(self):
        generator = np.random.default_rng(1)
        return random_genomes(80, generator), random_genomes(80, generator)

    def _evolved(self, arena):
        configuration = load_configuration(
            {'world': 'faithful', 'environment': arena, 'phases': self._phases}
        )
        with tempfile.TemporaryDirectory() as folder:
            evaluator = LocalEvaluator(configuration.make_environment(), threads=CORES)
            Evolution(configuration, evaluator, Path(folder) / 'run').run()
            last = sorted((Path(folder) / 'run' / 'snapshots').iterdir())[-1]
            with np.load(last, allow_pickle=False) as snapshot:
                return snapshot['predators'], snapshot['prey']


class Bench:
    """The measurements and what they are made of.

    Parameters
    ----------
    runs : int
        Times each measurement is repeated.
    quick : bool
    """

    def __init__(self, runs, quick):
        self.runs = runs
        self.quick = quick
        self.populations = Populations(quick)
        self.results = {}
        self.pairs = np.indices((80, 80)).reshape(2, -1)[:, :: 16 if quick else 1]

    def rate(self, name, play, unit='M pair-ticks/s', scale=1e6):
        """Time `play`, which returns how much it did, and print the median rate in its scale."""
        return self.report(name, sorted(timed(play) / scale for _ in range(self.runs)), unit)

    def report(self, name, values, unit):
        """Print and keep the median of sorted values."""
        median = statistics.median(values)
        self.results[name] = {'unit': unit, 'median': median, 'values': values}
        spread = f'{values[0]:8.2f} ..{values[-1]:8.2f}' if len(values) > 1 else ''
        print(f'{name:52} {median:8.2f} {unit:16} {spread}', flush=True)
        return median

    def ratio(self, name, numerator, denominator):
        """Print and keep a ratio of two medians of this run."""
        self.report(name, [numerator / denominator], 'x')

    def play(self, kind, arena, index=None, threads=1, **changes):
        """Return a function that plays episodes and returns their ticks."""
        predators, prey = self.populations[kind, arena]
        pairs = self.pairs if index is None else index
        environment = replace(ARENAS[arena], **changes)
        return lambda: int(evaluate_pairs(predators, prey, *pairs, environment, threads).sum())

    def kernel(self):
        """One core, a large batch."""
        for kind in ('random', 'evolved'):
            for arena in ARENAS:
                self.rate(f'kernel, {kind} genomes, {arena}', self.play(kind, arena))

    def threads(self):
        """Two threads and two processes against one."""
        play = self.play('evolved', 'open')
        one = self.rate('one thread', play)
        two = self.rate('two threads', self.play('evolved', 'open', threads=2))
        self.ratio('two threads : one', two, one)
        arguments = (*self.populations['evolved', 'open'], self.pairs)
        with get_context('spawn').Pool(2) as pool:
            pool.map(_play_once, [arguments] * 2, chunksize=1)
            both = self.rate(
                'two processes', lambda: sum(pool.map(_play_once, [arguments] * 2, chunksize=1))
            )
        self.ratio('two processes : one thread', both, one)

    def batch(self):
        """A small batch against a large one, the same episodes."""
        generator = np.random.default_rng(2)
        for arena in ARENAS:
            predators, prey = self.populations['evolved', arena]
            chosen = generator.permutation(self.pairs.shape[1])[: 20 * SMALL_BATCH]
            index = self.pairs[:, chosen]
            large = self.rate(
                f'{len(chosen)} episodes at once, {arena}', self.play('evolved', arena, index)
            )
            parts = np.array_split(index, len(chosen) // SMALL_BATCH, axis=1)
            stream = EpisodeStream(ARENAS[arena])

            def play(stream=stream, parts=parts, predators=predators, prey=prey):
                total = 0
                for part in parts:
                    stream.submit(None, predators, prey, *part)
                    while stream.pending:
                        total += sum(int(ticks.sum()) for _, ticks, _ in stream.advance())
                return total

            play()
            small = self.rate(f'the same in batches of {SMALL_BATCH}, {arena}', play)
            self.ratio(f'small batches : large, {arena}', small, large)

    def services(self):
        """The algorithm Standard through services, against the kernel on the same episodes."""
        warm_up, phases = (1, 1) if self.quick else (40, 10)
        self._loop(measure_loop(2, warm_up, phases, self.runs))

    def optimizers(self):
        """The same with each of the other optimizers, whose generations have many candidates."""
        warm_up, phases = (0, 1) if self.quick else (10, 2)
        for name in optimizers.names():
            if name != 'one_plus_one':
                self._loop(measure_loop(2, warm_up, phases, self.runs, name), f', {name}')

    def _loop(self, measured, note=''):
        """Report what `measure_loop` measured."""
        for name, text in (('loop', 'evolve, 2 evaluators'), ('kernel', 'kernel, 2 threads')):
            values = sorted(value / 1e6 for value in measured[name])
            self.report(f'{text}, the same episodes{note}', values, 'M pair-ticks/s')
        self.report(f'evolve : kernel{note}', sorted(measured['ratio']), 'x')
        self.report(f'the same, processor time{note}', sorted(measured['processor']), 'x')
        generation = sorted(1e3 * value for value in measured['generation'])
        self.report(f'a generation of evolve{note}', generation, 'ms')

    def start(self):
        """Start of a process that plays an episode: everything compiled, and nothing."""
        command = [sys.executable, '-c', _FIRST_EPISODE]
        subprocess.run(command, check=True)
        warm = sorted(_seconds(command, {}) for _ in range(self.runs))
        self.report('start with a warm cache', warm, 's')
        with tempfile.TemporaryDirectory() as cache:
            cold = _seconds(command, {'NUMBA_CACHE_DIR': cache})
        self.report('start that compiles the kernel', [cold], 's')

    def lockstep(self):
        """A simulator and two controllers, three processes, over topics; real time makes 10."""
        environment = Environment(episode_ticks=300 if self.quick else 3000)
        values = sorted(lockstep_rate(environment) for _ in range(self.runs))
        self.report('lockstep over topics', values, 'ticks/s')

    def worlds(self):
        """Imperfect robots against perfect ones, on each target of LLVM; one core."""
        measured = measure_worlds(*self.populations['evolved', 'open'], self.pairs, self.runs)
        for target, rates in measured.items():
            perfect = rates['faithful']
            for world, values in rates.items():
                self.report(
                    f'{world}, {target}', sorted(v / 1e6 for v in values), 'M pair-ticks/s'
                )
                if world != 'faithful':
                    ratios = sorted(v / p for v, p in zip(values, perfect, strict=True))
                    self.report(f'{world} : faithful, {target}', ratios, 'x')

    def pymunk(self):
        """Rigid bodies; one core."""
        few = self.pairs[:, :: max(1, self.pairs.shape[1] // (64 if self.quick else 256))]
        rigid = self.play('evolved', 'open', few, physics='pymunk')
        rigid()
        self.rate('pymunk, 32 arenas in a space', rigid, 'k pair-ticks/s', 1e3)

    def environments(self):
        """`gymnasium.vector` with actions from NumPy, one core; the goal is 2 million a second."""
        for world in ('faithful', 'robust'):
            for count in (64, 256, 1024):
                envs = ChaseVectorEnv(count, environment=make_environment(WORLDS[world]))
                envs.reset(seed=1)
                actions = np.random.default_rng(1).random((count, 2), np.float32)
                steps = (2**12 if self.quick else 2**17) // count

                def play(envs=envs, actions=actions, steps=steps):
                    for _ in range(steps):
                        envs.step(actions)
                    return steps * len(actions)

                self.rate(f'ChaseVectorEnv, {count} pairs, {world}', play)


_FIRST_EPISODE = """
import numpy as np
import rclpy
from coevo_manager.core.episodes import evaluate_pairs
genome = np.zeros((1, 442), np.float32)
evaluate_pairs(genome, genome, [0], [0])
"""


def _play_once(arguments):
    predators, prey, pairs = arguments
    return int(evaluate_pairs(predators, prey, *pairs).sum())


def _seconds(command, environment):
    start = time.perf_counter()
    subprocess.run(command, check=True, env=os.environ | environment)
    return time.perf_counter() - start


def timed(play):
    """Return what `play` did, a second."""
    start = time.perf_counter()
    done = play()
    return done / (time.perf_counter() - start)


def machine():
    """Say on what the numbers were taken."""
    model = platform.processor() or platform.machine()
    for line in Path('/proc/cpuinfo').read_text().splitlines():
        if line.startswith('model name'):
            model = line.split(':', 1)[1].strip()
            break
    return f'{model}, {CORES} cores, Python {platform.python_version()}'


SECTIONS = {
    'kernel': Bench.kernel,
    'threads': Bench.threads,
    'batch': Bench.batch,
    'services': Bench.services,
    'optimizers': Bench.optimizers,
    'start': Bench.start,
    'lockstep': Bench.lockstep,
    'worlds': Bench.worlds,
    'pymunk': Bench.pymunk,
    'environments': Bench.environments,
}


def main():
    """Run the sections asked for."""
    parser = argparse.ArgumentParser(prog='bench', add_help=False)
    parser.add_argument('--only', nargs='+', choices=SECTIONS, default=list(SECTIONS))
    parser.add_argument('--runs', type=int, default=7)
    parser.add_argument('--quick', action='store_true')
    parser.add_argument('--json', type=Path)
    options = parser.parse_args()
    if options.runs < 1:
        parser.error(f'--runs is {options.runs}, expected at least 1')
    bench = Bench(1 if options.quick else options.runs, options.quick)
    print(machine())
    bench.play('random', 'open', ([0], [0]))()
    for name in options.only:
        SECTIONS[name](bench)
    if options.json:
        beside = options.json.with_suffix('.part')
        beside.write_text(json.dumps({'machine': machine(), 'results': bench.results}, indent=1))
        beside.replace(options.json)


if __name__ == '__main__':
    main()
