"""Whole runs of the core against the real episodes."""

import csv
import dataclasses
import hashlib
import json
import random
import re
import threading
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from evolve_runs import read_files
from lineages import follow
from ros_processes import PATIENCE

from coevo_manager.core.episodes import evaluate_matrix, evaluate_pairs
from coevo_manager.core.evaluation import Lineages, evaluate_all
from coevo_manager.core.evolution import (
    Evolution,
    GenerationStats,
    PhaseStats,
    RunFolderError,
    algorithms,
    load_configuration,
    optimizers,
    read_configuration,
    read_record,
    remarks,
)
from coevo_manager.core.evolution.budget import RunBudget
from coevo_manager.core.evolution.sessions import read_sessions
from coevo_manager.core.local_evaluator import LocalEvaluator
from neuro_controller.core.genome import random_genomes

SMALL = {
    'population': 8,
    'selected': 4,
    'phases': 4,
    'generations': 6,
    'swap_generations': 12,
    'snapshot_generations': 12,
    'episode_ticks': 120,
    'cma_candidates': 6,
    'openai_pairs': 2,
    'motor_map': 'signed',
}

DRAWING = ('archive', 'archive_star', 'maxsolve_star')
"""Algorithms whose opponents are new in each generation."""


class DisorderlyEvaluator:
    """Plays real episodes in any number of slots and answers in any order, counting the cost."""

    def __init__(self, environment, slots=1, seed=0, longest_lineage=4):
        self.environment, self.slots = environment, slots
        self.longest_lineage = longest_lineage
        self.episodes = self.ticks = self.tickets = 0
        self._random = random.Random(seed)
        self._waiting = {}

    def submit(self, work):
        self.tickets += 1
        self._waiting[self.tickets] = work
        return self.tickets

    def collect(self, timeout=None):
        if self._random.random() < 0.1:
            return None
        ticket = self._random.choice(list(self._waiting))
        return ticket, self._play(self._waiting.pop(ticket))

    def _play(self, work):
        if isinstance(work, Lineages):
            ticks = follow(work, self.environment)[0]
        else:
            index = work.predator_index, work.prey_index
            ticks = evaluate_pairs(work.predators, work.prey, *index, self.environment)
        self.episodes += len(ticks)
        self.ticks += int(ticks.sum())
        return ticks

    def cancel(self):
        self._waiting.clear()

    def close(self):
        self.cancel()


def configure(**values):
    values = {**SMALL, **values}
    if values.get('algorithm') == 'vanilla':
        values['selected'] = values['population']
    if values.get('optimizer', 'openai_es') != 'openai_es':
        values['reevaluate_parents'] = values.get('algorithm') in DRAWING
    return load_configuration(values)


def run(folder, configuration, evaluator=None, observer=None):
    evaluator = evaluator or LocalEvaluator(configuration.make_environment())
    return Evolution(configuration, evaluator, folder, observer).run()


def table(path):
    with path.open() as file:
        return list(csv.DictReader(file))


def episodes(configuration):
    """Episodes of all phases, where every species has the rivals that it had at first."""
    budget = RunBudget(configuration)
    phase = configuration.generations * budget.generation
    return budget.first + configuration.phases * (
        phase + budget.overhead(configuration.population)
    )


def test_the_costs_of_the_paper():
    configuration = load_configuration({}, 'paper')
    budget = RunBudget(configuration)
    assert (configuration.population, configuration.selected) == (80, 10)
    assert (budget.first, budget.generation, budget.overhead(80)) == (6400, 100, 800)
    assert episodes(configuration) == 16_206_400
    simplified = load_configuration({'algorithm': 'simplified'}, 'paper')
    assert episodes(simplified) == 16_206_400
    cheap = load_configuration({'algorithm': 'vanilla'}, 'paper')
    assert (cheap.population, cheap.selected) == (10, 10)
    assert RunBudget(cheap).generation == budget.generation
    vanilla = load_configuration({'algorithm': 'vanilla', 'population': 80}, 'paper')
    assert vanilla.selected == 80
    assert episodes(vanilla) == 6400 + 1500 * (100 * 6400 + 6400)


@pytest.mark.parametrize('optimizer', optimizers.names())
@pytest.mark.parametrize('algorithm', algorithms.names())
def test_every_algorithm_with_every_optimizer(tmp_path, algorithm, optimizer):
    configuration = configure(algorithm=algorithm, optimizer=optimizer)
    evaluator = DisorderlyEvaluator(configuration.make_environment(), slots=3)
    seen = []
    outcome = run(tmp_path / 'run', configuration, evaluator, seen.append)
    assert outcome.finished
    assert (tmp_path / 'run' / 'report.md').read_text() == outcome.report

    phases = table(tmp_path / 'run' / 'phases.csv')
    generations = table(tmp_path / 'run' / 'generations.csv')
    assert [row['evolving'] for row in phases] == ['', *['predator'] * 2, *['prey'] * 2]
    assert [int(row['generation']) for row in generations] == [*range(1, 25)]

    # The costs: known beforehand, counted in the logs, really played (the report's are its own).
    report = 3 * configuration.population**2
    # One member of each species joins in each phase of psro; it meets all of the other.
    known = episodes(configuration) + (2 * 2 * 4 if algorithm == 'psro' else 0)
    assert int(phases[-1]['episodes']) == known == evaluator.episodes - report
    assert int(phases[0]['episodes']) == RunBudget(configuration).first
    assert f'{known:,} episodes' in outcome.report

    # Within a phase no agent gets worse, where opponents stay and the fittest is kept.
    elitist = configuration.as_dict().get('openai_agent', 'best') == 'best'
    for first, second in pairwise(generations):
        if first['phase'] == second['phase'] and elitist and not configuration.reevaluate_parents:
            for column in ('fitness_mean', 'fitness_min', 'fitness_max'):
                assert float(second[column]) >= float(first[column])

    # The matrix that grew row by row is the matrix of the populations.
    with np.load(tmp_path / 'run' / 'snapshots' / 'gen_000024.npz', allow_pickle=False) as file:
        ticks = evaluate_matrix(file['predators'], file['prey'], evaluator.environment)
        fitness = (1 - ticks / configuration.episode_ticks).astype(np.float32)
        np.testing.assert_allclose(file['fitness'], fitness, atol=1e-7)
        assert file['fitness'].mean() == pytest.approx(
            float(phases[-1]['predator_fitness']), abs=1e-6
        )

    # The observer saw each row of both logs.
    for kind, rows in ((GenerationStats, generations), (PhaseStats, phases)):
        stats = [event for event in seen if type(event) is kind]
        assert [event.ticks for event in stats] == [int(row['ticks']) for row in rows]
        assert [event.progress for event in stats] == sorted(event.progress for event in stats)
    assert seen[-1].progress == 1.0


def test_ticks_are_counted_exactly(tmp_path):
    configuration = configure()
    evaluator = DisorderlyEvaluator(configuration.make_environment(), slots=2)
    before_report = []

    def observer(stats):
        before_report[:] = [stats.ticks, evaluator.ticks]

    run(tmp_path / 'run', configuration, evaluator, observer)
    assert before_report[0] == before_report[1]


@pytest.mark.parametrize('optimizer', optimizers.names())
def test_equal_seeds_give_equal_files(tmp_path, optimizer):
    configuration = configure(optimizer=optimizer, algorithm='hall_of_fame')
    expected = None
    for slots, longest_lineage in ((1, 1), (2, 3), (5, 100)):
        folder = tmp_path / f'slots{slots}'
        environment = configuration.make_environment()
        evaluator = DisorderlyEvaluator(environment, slots, slots, longest_lineage)
        run(folder, configuration, evaluator)
        files = read_files(folder)
        expected = expected or files
        assert files == expected
    other = tmp_path / 'other'
    run(other, configure(optimizer=optimizer, algorithm='hall_of_fame', seed=2))
    assert read_files(other)['generations.csv'] != expected['generations.csv']


def test_agents_do_not_wait_for_each_other(tmp_path):
    """One agent's first work is answered last of all; the others run meanwhile."""

    class Partial(DisorderlyEvaluator):
        held = None

        def collect(self, timeout=None):
            started = self.tickets > self.slots  # the first evaluation is over
            if started and self.held is None:
                self.held = min(self._waiting)
            free = [ticket for ticket in self._waiting if ticket != self.held]
            if not free:
                released.append(self.tickets)
                free, self.held = [self.held], 0
            return min(free), self._play(self._waiting.pop(min(free)))

    released = []
    configuration = configure(phases=1)
    evaluator = Partial(configuration.make_environment(), slots=2, longest_lineage=1)
    run(tmp_path / 'held', configuration, evaluator)
    first_evaluation, held, others = 2, 1, 3
    works_each = configuration.generations + 1  # and one against the whole opposing population
    assert released == [first_evaluation + held + others * works_each]
    run(tmp_path / 'whole', configuration)
    assert read_files(tmp_path / 'held') == read_files(tmp_path / 'whole')


def test_agents_that_send_batches_ask_together_where_slots_are_few(tmp_path):
    class Counting(DisorderlyEvaluator):
        def submit(self, work):
            lengths.append(len(work))
            return super().submit(work)

    configuration = configure(phases=1, optimizer='cma_es')
    generation = configuration.cma_candidates * configuration.selected
    for slots, longest, together in ((2, 100, 4), (2, 3, 3), (4, 100, 2), (8, 100, 1)):
        lengths = []
        evaluator = Counting(configuration.make_environment(), slots, 0, longest)
        run(tmp_path / f'{slots}_{longest}', configuration, evaluator)
        assert max(lengths[slots : -3 * slots]) == together * generation
    assert len({str(read_files(folder)) for folder in tmp_path.iterdir()}) == 1


def test_species_swap_after_the_phase_that_completes_each_such_generation(tmp_path):
    run(tmp_path / 'run', configure(phases=6, generations=7, swap_generations=10))
    # Ends of phases: 7, 14 (10 completed), 21 (20), 28, 35 (30), 42.
    evolving = [row['evolving'] for row in table(tmp_path / 'run' / 'phases.csv')]
    assert evolving[1:] == ['predator', 'predator', 'prey', 'predator', 'predator', 'prey']


def test_snapshots_of_the_start_each_interval_and_the_end(tmp_path):
    run(tmp_path / 'run', configure(phases=5, generations=7, snapshot_generations=20))
    names = sorted(path.name for path in (tmp_path / 'run' / 'snapshots').iterdir())
    assert names == ['gen_000000.npz', 'gen_000021.npz', 'gen_000035.npz']


@pytest.mark.parametrize('limit', ['episodes', 'ticks'])
def test_budgets_are_spent_and_never_exceeded(tmp_path, limit):
    whole = run_costs(tmp_path / 'whole', configure())
    budget = round(whole[limit] * 0.7)
    seen = []
    cost = run_costs(tmp_path / 'budget', configure(phases=None, **{limit: budget}), seen.append)
    assert budget * 0.85 < cost[limit] <= budget
    assert seen[-1].progress == 1.0
    # Up to where the budget cuts it, the run is the same run.
    rows = (tmp_path / 'budget' / 'generations.csv').read_text().splitlines()
    expected = (tmp_path / 'whole' / 'generations.csv').read_text().splitlines()
    assert rows[:13] == expected[:13]


def run_costs(folder, configuration, observer=None):
    run(folder, configuration, observer=observer)
    row = table(folder / 'phases.csv')[-1]
    return {name: int(row[name]) for name in ('episodes', 'ticks')}


def test_evolved_agents_may_replace_their_parents_unranked(tmp_path):
    configuration = configure(replacement='evolved', phases=1)
    run(tmp_path / 'run', configuration)
    first, last = (np.load(tmp_path / 'run' / 'snapshots' / f'gen_{g:06d}.npz') for g in (0, 6))
    changed = (first['predators'] != last['predators']).any(axis=1)
    assert changed.sum() == configuration.selected
    np.testing.assert_array_equal(first['prey'], last['prey'])


def test_learning_is_real(tmp_path):
    """Evolved predators catch random prey far sooner than random predators do."""
    configuration = load_configuration(
        {'population': 32, 'phases': 10, 'generations': 50, 'swap_generations': 10_000}
    )
    run(tmp_path / 'run', configuration)
    phases = table(tmp_path / 'run' / 'phases.csv')
    fitness = [float(row['predator_fitness']) for row in phases]
    assert fitness[0] < 0.3
    assert fitness[-1] > fitness[0] + 0.3
    assert fitness == sorted(fitness)  # against unchanging prey the ranking never loses


def test_a_stop_is_honoured_within_a_generation(tmp_path):
    configuration = configure(generations=1000)
    stopper = {}

    def observer(stats):
        stopper['last'] = stats
        if stats.generation == 40:
            stopper['evolution'].stop()

    evaluator = DisorderlyEvaluator(configuration.make_environment(), slots=2)
    evolution = Evolution(configuration, evaluator, tmp_path / 'run', observer)
    stopper['evolution'] = evolution
    outcome = evolution.run()
    assert (outcome.finished, outcome.report) == (False, '')
    assert stopper['last'].generation == 40
    assert not evaluator._waiting
    assert 'stopped on request' in (tmp_path / 'run' / 'run.log').read_text()


def test_a_stop_ends_the_wait_for_evaluators_that_do_not_answer(tmp_path):
    class Silent(DisorderlyEvaluator):
        def collect(self, timeout=None):
            asked.set()
            threading.Event().wait(min(timeout, 0.01))

    asked = threading.Event()
    configuration = configure()
    evolution = Evolution(
        configuration, Silent(configuration.make_environment()), tmp_path / 'run'
    )
    outcomes = []
    thread = threading.Thread(target=lambda: outcomes.append(evolution.run()))
    thread.start()
    assert asked.wait(PATIENCE)
    evolution.stop()
    thread.join(10)
    assert [outcome.finished for outcome in outcomes] == [False]


def test_run_json_holds_every_number_and_the_versions(tmp_path):
    configuration = configure()
    run(tmp_path / 'run', configuration)
    content = json.loads((tmp_path / 'run' / 'run.json').read_text())
    assert content['configuration'] == configuration.as_dict()
    assert content['versions']['numpy'] == np.__version__
    package = (Path(__file__).parents[2] / 'package.xml').read_text()
    assert f'<version>{content["versions"]["coevo_manager"]}</version>' in package
    assert read_configuration(tmp_path / 'run') == configuration


def test_another_evaluators_environment_is_refused(tmp_path):
    evaluator = LocalEvaluator(configure(environment='obstacle').make_environment())
    with pytest.raises(
        ValueError, match=r"evaluator's environment is .*, expected that of the run"
    ):
        Evolution(configure(), evaluator, tmp_path / 'run')
    assert not (tmp_path / 'run').exists()


def test_a_folder_that_holds_something_is_refused(tmp_path):
    configuration = configure(phases=1)
    evaluator = LocalEvaluator(configuration.make_environment())
    run(tmp_path / 'run', configuration)
    before = read_files(tmp_path)
    with pytest.raises(RunFolderError, match='holds another run'):
        Evolution(configuration, evaluator, tmp_path / 'run')
    with pytest.raises(RunFolderError, match='is not empty'):
        Evolution(configuration, evaluator, tmp_path)
    with pytest.raises(RunFolderError, match=r'run\.json is not a folder'):
        Evolution(configuration, evaluator, tmp_path / 'run' / 'run.json' / 'x')
    assert read_files(tmp_path) == before


def documented(title):
    """Names in the first column of a table of docs/formats.md."""
    text = (Path(__file__).parents[5] / 'docs' / 'formats.md').read_text()
    section = text.split(f'## {title}')[1].split('\n## ')[0]
    first = [line.split('|')[1] for line in section.splitlines() if line.startswith('| `')]
    return [name for cell in first for name in re.findall('`(\\w+)`', cell)]


def test_the_formats_are_as_documented(tmp_path):
    """Everything reads with NumPy and the standard library, as docs/formats.md says."""
    folder = tmp_path / 'run'
    run(folder, configure(algorithm='hall_of_fame'))
    for log in ('generations.csv', 'phases.csv'):
        assert list(table(folder / log)[0]) == documented(log)
    with np.load(folder / 'snapshots' / 'gen_000012.npz', allow_pickle=False) as file:
        assert sorted(file.files) == sorted(documented('snapshots'))
        assert (file['version'], file['generation']) == (1, 12)
        kinds = {file[name].dtype.name for name in ('predators', 'prey', 'fitness')}
        assert kinds == {'float32'}
    with np.load(folder / 'checkpoint' / 'phase_000004.npz', allow_pickle=False) as file:
        arrays = dict(file)
    assert sorted(arrays) == sorted(documented('checkpoint'))
    digest = hashlib.sha256()
    for name in sorted(set(arrays) - {'sha256'}):
        array = arrays[name]
        digest.update(f'{name} {array.dtype.str} {array.shape}\n'.encode() + array.tobytes('C'))
    assert arrays['sha256'] == digest.hexdigest()
    assert arrays['generations_size'] == (folder / 'generations.csv').stat().st_size
    halls = {f'hall_{species}.bin' for species in ('predator', 'prey')}
    assert {(folder / name).stat().st_size for name in halls} == {(1 + 2) * 442 * 4}
    names = {'run.json', 'generations.csv', 'phases.csv', 'report.md', 'run.log', 'sessions.json'}
    names |= halls
    assert names | {'snapshots', 'checkpoint'} == {path.name for path in folder.iterdir()}


def test_sessions_tell_where_and_how_long(tmp_path):
    configuration = configure()
    evaluator = LocalEvaluator(configuration.make_environment())

    def stop_soon(stats):
        if isinstance(stats, PhaseStats) and stats.phase == 2:
            evolution.stop()

    evolution = Evolution(configuration, evaluator, tmp_path / 'run', stop_soon, 'mine')
    assert not evolution.run().finished
    assert Evolution.resume(tmp_path / 'run', evaluator).run().finished
    first, second = read_sessions(tmp_path / 'run')
    assert (first['first_phase'], first['last_phase'], first['ended']) == (0, 2, 'stopped')
    assert (second['first_phase'], second['ended']) == (2, 'finished')
    assert second['last_phase'] == configuration.phases
    assert first['host'] and first['cores'] >= 1 and first['seconds'] > 0
    assert first['begun'] <= second['begun']
    assert read_record(tmp_path / 'run' / 'run.json') == (configuration, 'mine')


def test_another_commit_that_goes_on_with_a_run_is_told(tmp_path):
    configuration = configure()
    run(tmp_path / 'run', configuration)
    path = tmp_path / 'run' / 'sessions.json'
    text = path.read_text()
    commit = read_sessions(tmp_path / 'run')[-1]['commit']
    for before, told in ((commit, False), ('0123456789ab', True)):
        path.write_text(text.replace(json.dumps(commit), json.dumps(before)))
        evaluator = LocalEvaluator(configuration.make_environment())
        Evolution.resume(tmp_path / 'run', evaluator).run()
        log = (tmp_path / 'run' / 'run.log').read_text()
        assert ("its last session was of commit '0123456789ab', this one is of" in log) == told


def test_a_run_without_a_swap_says_that_the_prey_never_evolved(tmp_path):
    configuration = configure(swap_generations=10**6)
    (remark,) = remarks(configuration, configuration.phases)
    assert remark.startswith('the prey never evolves')
    outcome = run(tmp_path / 'run', configuration)
    assert remark in outcome.report
    assert remark in (tmp_path / 'run' / 'run.log').read_text()
    log = table(tmp_path / 'run' / 'phases.csv')
    assert {row['evolving'] for row in log} == {'', 'predator'}


@pytest.mark.parametrize(('phases', 'evolves'), [(5, False), (6, True)])
def test_the_prey_evolves_from_the_phase_after_the_swap(phases, evolves):
    values = {'phases': phases, 'generations': 100, 'swap_generations': 500}
    assert (remarks(load_configuration(values), phases) == []) == evolves


def test_vanilla_says_how_many_evolve():
    (remark,) = remarks(load_configuration({'algorithm': 'vanilla'}), 100)
    assert remark.endswith('N = n = 10')


@pytest.mark.parametrize('optimizer', ['one_plus_one', 'openai_es'])
def test_episodes_per_opponent_count_and_change_results_but_not_their_repeatability(
    tmp_path, optimizer
):
    values = {'world': 'varied', 'optimizer': optimizer, 'episodes_per_opponent': 3}
    configuration = configure(**values)
    run(tmp_path / 'one', configuration)
    shuffled = DisorderlyEvaluator(configuration.make_environment(), 3)
    run(tmp_path / 'other', configuration, shuffled)
    assert read_files(tmp_path / 'one') == read_files(tmp_path / 'other')
    last = table(tmp_path / 'one' / 'phases.csv')[-1]
    assert int(last['episodes']) == episodes(configuration)
    once = configure(**values | {'episodes_per_opponent': 1})
    assert episodes(configuration) == 3 * episodes(once)
    with np.load(tmp_path / 'one' / 'snapshots' / 'gen_000012.npz') as file:
        ticks = evaluate_matrix(file['predators'], file['prey'], configuration.make_environment())
        expected = 1 - ticks / configuration.pair_ticks
        np.testing.assert_allclose(file['fitness'], expected, atol=1e-6)


def test_equal_episodes_are_remarked():
    values = {'episodes_per_opponent': 5, 'phases': 100}
    (remark,) = remarks(load_configuration(values | {'world': 'faithful'}), 100)
    assert 'are equal' in remark
    assert not remarks(load_configuration(values | {'world': 'varied'}), 100)


@pytest.mark.parametrize('fresh', ['phase', 'generation'])
@pytest.mark.parametrize('algorithm', ['standard', 'random_opponents', 'archive'])
def test_fresh_noise_is_counted_repeatable_and_other_noise(tmp_path, algorithm, fresh):
    values = {'world': 'robust', 'algorithm': algorithm, 'phases': 2, 'swap_generations': 6}
    configuration = configure(**values, fresh_noise=fresh)
    environment = configuration.make_environment()
    run(tmp_path / 'one', configuration, LocalEvaluator(environment))
    run(tmp_path / 'two', configuration, LocalEvaluator(environment, threads=2))
    run(tmp_path / 'never', configure(**values))
    one = read_files(tmp_path / 'one')
    assert one == read_files(tmp_path / 'two')
    assert one['generations.csv'] != read_files(tmp_path / 'never')['generations.csv']
    assert int(table(tmp_path / 'one' / 'phases.csv')[-1]['episodes']) == episodes(configuration)
    # Rankings are over the noise that a pair always meets.
    with np.load(tmp_path / 'one' / 'snapshots' / 'gen_000012.npz') as file:
        ticks = evaluate_matrix(file['predators'], file['prey'], environment)
        np.testing.assert_allclose(
            file['fitness'], 1 - ticks / configuration.pair_ticks, atol=1e-6
        )


def test_noise_is_the_pairs_own_unless_another_is_asked_for():
    environment = configure(world='robust', episode_ticks=1000).make_environment()
    predators, prey = (random_genomes(8, np.random.default_rng(seed)) for seed in (1, 2))
    stop = threading.Event()
    evaluator = LocalEvaluator(environment)
    usual, one, two = (
        evaluate_all(evaluator, predators, prey, stop, noise) for noise in (0, 1, 2)
    )
    np.testing.assert_array_equal(usual, evaluate_matrix(predators, prey, environment))
    assert (one != usual).any() and (one != two).any()
    np.testing.assert_array_equal(one, evaluate_all(evaluator, predators, prey, stop, 1))
    # The second of two episodes of a pair has the noise that a pair's one episode has in noise 1.
    twice = LocalEvaluator(dataclasses.replace(environment, repetitions=2))
    np.testing.assert_array_equal(evaluate_all(twice, predators, prey, stop), usual + one)


def test_parents_evaluated_again_change_nothing_but_the_cost_where_nothing_is_random(tmp_path):
    values = {'world': 'faithful', 'phases': 2}
    run(tmp_path / 'once', configure(**values))
    configuration = load_configuration({**SMALL, **values, 'reevaluate_parents': True})
    run(tmp_path / 'again', configuration)
    once, again = (table(tmp_path / name / 'generations.csv') for name in ('once', 'again'))
    for first, second in zip(once, again, strict=True):
        assert {**first, 'episodes': '', 'ticks': ''} == {**second, 'episodes': '', 'ticks': ''}
    assert int(table(tmp_path / 'again' / 'phases.csv')[-1]['episodes']) == episodes(configuration)
