"""A campaign of runs: conditions x environments x seeds, from a YAML file, over Dask."""

import re
import reprlib
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from coevo_manager.core.configuration import Configuration, differences
from coevo_manager.core.documents import read_document
from coevo_manager.core.evolution import (
    Evolution,
    GenerationStats,
    PhaseStats,
    RunFolderError,
    load_configuration,
    read_configuration,
)
from coevo_manager.core.evolution.fields import all_fields
from coevo_manager.core.evolution.files import write_whole
from coevo_manager.core.local_evaluator import LocalEvaluator
from coevo_manager.runs.status import Pace, StatusFile

KEYS = ('out', 'preset', 'configuration', 'conditions', 'environments', 'seeds', 'retries')

MOST_RUNS = 10_000
"""Runs that a campaign may have."""


class CampaignError(ValueError):
    """The campaign cannot start; one sentence that says why."""


@dataclass(frozen=True)
class Job:
    """One run of a campaign.

    Attributes
    ----------
    condition, environment : str
        The names the file gives them.
    configuration : Configuration
    folder : Path
        OUT/CONDITION-ENVIRONMENT-seedSEED.
    """

    condition: str
    environment: str
    configuration: Configuration
    folder: Path

    @property
    def finished(self) -> bool:
        """Whether the run spent its budget and wrote its report."""
        return (self.folder / 'report.md').exists()


@dataclass(frozen=True)
class Campaign:
    """What a campaign file asks for.

    Attributes
    ----------
    out : Path
    jobs : list of Job
    retries : int
        Times a failed run is tried again, from its last checkpoint.
    """

    out: Path
    jobs: list[Job]
    retries: int


def read_campaign(path: Path) -> Campaign:
    """Read and check a campaign file and the folders of runs that it began before.

    Raises
    ------
    CampaignError
        One of the file's values, or a folder that another run occupies.
    ReadingError
        The file.
    """
    content = _mapping(path, 'the file', read_document(path))
    for key in content:
        if key not in KEYS:
            raise CampaignError(
                f'{path}: key {reprlib.repr(key)} is unknown, expected some of {", ".join(KEYS)}'
            )
    for key in ('out', 'seeds'):
        if key not in content:
            raise CampaignError(f'{path}: {key} is missing')
    out = content['out']
    if not isinstance(out, str) or not out or not out.isprintable():
        raise CampaignError(f'{path}: out is {reprlib.repr(out)}, expected a folder')
    retries = content.get('retries', 1)
    if not isinstance(retries, int) or isinstance(retries, bool) or retries < 0:
        raise CampaignError(
            f'{path}: retries is {reprlib.repr(retries)}, expected a whole number of at least 0'
        )
    folder = path.parent / out
    jobs = list(_jobs(path, content, folder))
    for job in jobs:
        _check_folder(job)
    return Campaign(folder, jobs, retries)


def _jobs(path: Path, content: Mapping, out: Path) -> Iterator[Job]:
    shared = _mapping(path, 'configuration', content.get('configuration', {}))
    conditions = _named(path, 'conditions', content.get('conditions', ['standard']))
    # Without environments, each run has that of its configuration.
    environments = (
        _named(path, 'environments', content['environments'])
        if 'environments' in content
        else {'': {}}
    )
    seeds = {
        condition: _seeds(path, f'conditions.{condition}.seeds', own['seeds'])
        if 'seeds' in own
        else _seeds(path, 'seeds', content['seeds'])
        for condition, own in conditions.items()
    }
    if len(environments) * sum(map(len, seeds.values())) > MOST_RUNS:
        raise CampaignError(f'{path} asks for more than {MOST_RUNS} runs')
    if 'seed' in shared:
        raise CampaignError(f'{path}: configuration.seed: seeds belong into seeds')
    for condition, named in conditions.items():
        own = {key: value for key, value in named.items() if key != 'seeds'}
        for environment, around in environments.items():
            for field in own.keys() & around.keys():
                if own[field] != around[field]:
                    raise CampaignError(
                        f'{path}: conditions.{condition} sets {field} to '
                        f'{reprlib.repr(own[field])} and environments.{environment} to '
                        f'{reprlib.repr(around[field])}, expected one of them'
                    )
            for seed in seeds[condition]:
                values = {**shared, **own, **around, 'seed': seed}
                try:
                    configuration = load_configuration(values, content.get('preset', 'quick'))
                except ValueError as error:
                    where = ', '.join(filter(None, (condition, environment)))
                    raise CampaignError(f'{path}: {where}: {error}') from None
                place = environment or configuration.environment
                name = f'{condition}-{place}-seed{seed}'
                yield Job(condition, place, configuration, out / name)


def _seeds(path: Path, name: str, seeds: Any) -> list[int]:
    if not isinstance(seeds, list) or not seeds or len(set(map(str, seeds))) != len(seeds):
        raise CampaignError(
            f'{path}: {name} is {reprlib.repr(seeds)}, expected a list of different whole numbers'
        )
    return seeds


def _named(path: Path, key: str, given: Any) -> dict[str, Mapping[str, Any]]:
    """Conditions or environments: mappings by name, or a list of values of their own field.

    A condition may have seeds of its own.
    """
    field = {'conditions': 'algorithm', 'environments': 'environment'}[key]
    known = {*all_fields(), *(['seeds'] if key == 'conditions' else [])}
    if isinstance(given, list):
        given = {str(value): {field: value} for value in given}
    given = _mapping(path, key, given)
    for name, values in given.items():
        for inner in _mapping(path, f'{key}.{name}', values):
            if inner == 'seed':
                raise CampaignError(f'{path}: {key}.{name}.seed: seeds belong into seeds')
            if inner not in known:
                raise CampaignError(
                    f'{path}: {key}.{name}: {reprlib.repr(inner)} is unknown, expected keys '
                    'of the configuration'
                )
        if not re.fullmatch(r'[\w.+]{1,100}', name):
            raise CampaignError(
                f'{path}: {key} has the name {reprlib.repr(name)}, expected up to 100 '
                'letters, digits, _ . +'
            )
    if not given:
        raise CampaignError(f'{path}: {key} is empty')
    return given


def _mapping(path: Path, name: str, value: Any) -> dict:
    if not isinstance(value, dict) or not all(isinstance(key, str) for key in value):
        raise CampaignError(f'{path}: {name} is {reprlib.repr(value)}, expected names with values')
    return value


def _check_folder(job: Job) -> None:
    if not (job.folder / 'run.json').exists():
        return
    try:
        held = read_configuration(job.folder)
    except RunFolderError as error:
        raise CampaignError(str(error)) from None
    if held != job.configuration:
        raise CampaignError(
            f'{job.folder} holds a run of another configuration (there, here): '
            f'{"; ".join(differences(held, job.configuration))}'
        )


def run_job(configuration: Configuration, folder: Path, condition: str) -> float:
    """Start a run, or continue it from its last checkpoint, in this process; seconds it took."""
    start = time.monotonic()
    evaluator = LocalEvaluator(configuration.make_environment(), threads=1)
    pace, status_file = Pace(), StatusFile(folder)

    def observe(stats: GenerationStats | PhaseStats) -> None:
        status_file.write(pace.status(stats, time.monotonic()))

    if (folder / 'run.json').exists():
        evolution = Evolution.resume(folder, evaluator, observe, configuration)
    else:
        evolution = Evolution(configuration, evaluator, folder, observe, condition)
    evolution.run()
    return time.monotonic() - start


def execute(
    campaign: Campaign, client: Any, done: Callable[[Job, str], None] = lambda job, error: None
) -> pd.DataFrame:
    """Run what is not finished, each run a task of the cluster, and write OUT/campaign.csv.

    Parameters
    ----------
    client : distributed.Client
        Its workers must see the run folders under the same paths.
    done : callable (job, error)
        Told of each finished or failed run; `error` is empty for a finished one.

    Returns
    -------
    pandas.DataFrame
        One row a run: `run`, `condition`, `environment`, `seed`, `state` (finished or failed),
        `seconds` in this call, `error`.
    """
    from distributed import as_completed

    campaign.out.mkdir(parents=True, exist_ok=True)
    outcomes = {job.folder: (0.0, '') for job in campaign.jobs if job.finished}
    futures = {
        client.submit(
            run_job,
            job.configuration,
            job.folder.resolve(),
            job.condition,
            key=f'run-{job.folder.name}-{time.time_ns()}',
            retries=campaign.retries,
            pure=False,
        ): job
        for job in campaign.jobs
        if not job.finished
    }
    for job in campaign.jobs:
        if job.folder in outcomes:
            done(job, '')
    for future in as_completed(futures):
        job = futures[future]
        error = future.exception()
        text = '' if error is None else f'{type(error).__name__}: {error}'
        outcomes[job.folder] = (0.0 if error else future.result(), text)
        done(job, text)
        _write(campaign, outcomes)
    return _write(campaign, outcomes)


def _write(campaign: Campaign, outcomes: dict[Path, tuple[float, str]]) -> pd.DataFrame:
    rows = []
    for job in campaign.jobs:
        seconds, error = outcomes.get(job.folder, (0.0, 'not run yet'))
        rows.append(
            {
                'run': job.folder.name,
                'condition': job.condition,
                'environment': job.environment,
                'seed': job.configuration.seed,
                'state': 'failed'
                if error and job.folder in outcomes
                else 'waiting'
                if error
                else 'finished',
                'seconds': round(seconds, 1),
                'error': error,
            }
        )
    table = pd.DataFrame(rows)
    write_whole(campaign.out / 'campaign.csv', table.to_csv(index=False).encode())
    return table
