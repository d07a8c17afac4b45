"""Run folders: how they are grouped, and one clear sentence for each that cannot be used."""

import re
import shutil

import numpy as np
import pytest
from analysis_runs import make_run

from coevo_manager.analysis import command as analyze
from coevo_manager.analysis.runs import AnalysisError, choose_generations, read_runs


@pytest.fixture(scope='module')
def tiny(tmp_path_factory):
    """Two replications of one condition."""
    folder = tmp_path_factory.mktemp('runs')
    return [make_run(folder / f'seed{seed}', seed=seed) for seed in (1, 2)]


@pytest.fixture
def copies(tiny, tmp_path):
    return [shutil.copytree(run, tmp_path / run.name) for run in tiny]


def refusal(capsys, runs, *options):
    """The one sentence with which the command refuses; nothing is written."""
    out = runs[0].parent / 'out'
    assert analyze.main([*map(str, runs), '--out', str(out), *options]) == 2
    assert not (out / 'report.html').exists()
    lines = [line for line in capsys.readouterr().err.splitlines() if line.strip()]
    assert len(lines) == 1
    return lines[0]


def test_runs_are_grouped_and_ordered(tiny, tmp_path):
    other = make_run(tmp_path / 'a', seed=9, environment='obstacle')
    plain = make_run(tmp_path / 'b', seed=3, algorithm='simplified')
    runs = read_runs([other, plain, *tiny])
    assert [(r.condition.name, r.condition.arena, r.seed) for r in runs] == [
        ('Standard', 'open arena', 1),
        ('Standard', 'open arena', 2),
        ('Simplified', 'open arena', 3),
        ('Standard', 'arena with obstacle', 9),
    ]
    snapshot = runs[0].snapshot(40)
    best = snapshot.ranking('predator')[0]
    assert snapshot.fitness.mean(axis=1)[best] == snapshot.fitness.mean(axis=1).max()
    worst_for_predators = snapshot.ranking('prey')[0]
    columns = snapshot.fitness.mean(axis=0)
    assert columns[worst_for_predators] == columns.min()


def test_generations_in_common(tiny, tmp_path):
    longer = make_run(tmp_path / 'longer', seed=3, phases=6)
    runs = read_runs([*tiny, longer])
    assert choose_generations(runs) == [0, 10, 20, 30, 40]
    assert choose_generations(runs, every=20) == [0, 20, 40]
    assert choose_generations(runs, until=20) == [0, 10, 20]
    with pytest.raises(AnalysisError, match='until is 60'):
        choose_generations(runs, until=60)
    with pytest.raises(AnalysisError, match='every is 70'):
        choose_generations(runs, every=70)


def test_no_run(copies, capsys, tmp_path):
    (tmp_path / 'empty').mkdir()
    assert 'holds no run' in refusal(capsys, [copies[0], tmp_path / 'empty'])


def test_missing_snapshot(copies, capsys):
    (copies[1] / 'snapshots' / 'gen_000020.npz').unlink()
    message = refusal(capsys, copies)
    assert str(copies[1]) in message
    assert 'the snapshot of generation 20 is missing' in message


def unsealed(run):
    """The run without its checkpoints, which vouch for what it wrote."""
    shutil.rmtree(run / 'checkpoint')
    return run


def test_truncated_snapshot(copies, capsys):
    path = copies[0] / 'snapshots' / 'gen_000030.npz'
    path.write_bytes(path.read_bytes()[:-2000])
    assert f'{path} is damaged' in refusal(capsys, copies)


def test_pickled_snapshot_is_never_opened(copies, capsys):
    path = copies[0] / 'snapshots' / 'gen_000030.npz'
    np.savez(path, generation=30, predators=np.array([object()]), prey=1, fitness=1)
    assert f'{path} is damaged' in refusal(capsys, copies)


def test_snapshot_of_another_shape(copies, capsys):
    path = unsealed(copies[0]) / 'snapshots' / 'gen_000030.npz'
    with np.load(path) as data:
        arrays = dict(data)
    np.savez(path, **arrays | {'prey': arrays['prey'][:3]})
    assert 'fitness has shape (8, 8), expected (8, 3)' in refusal(capsys, copies)
    narrow = {'prey': arrays['prey'][:3], 'fitness': arrays['fitness'][:, :3]}
    np.savez(path, **arrays | narrow)
    assert 'of 8 predators and 8 prey, but holds generation 30 of 8 and 3' in refusal(
        capsys, copies
    )
    np.savez(path, **arrays | {'generation': np.int64(20)})
    assert 'holds generation 20' in refusal(capsys, copies)
    arrays['prey'][0, 0] = np.nan
    np.savez(path, **arrays)
    assert 'prey has the value nan as gene 0' in refusal(capsys, copies)


@pytest.mark.parametrize('name', ['generations.csv', 'phases.csv', 'snapshots/gen_000010.npz'])
def test_a_wrong_byte_anywhere_is_found(copies, capsys, name):
    path = copies[0] / name
    content = bytearray(path.read_bytes())
    content[len(content) // 3] ^= 1
    path.write_bytes(content)
    assert f'{path} is damaged: ' in refusal(capsys, copies)


@pytest.mark.parametrize(
    ('old', 'new', 'sentence'),
    [
        ('phase,', 'phases,', 'line 1 does not name the columns'),
        (',prey,', ',pray,', 'line 4, evolving is pray'),
        ('0,0,,', '0,0,,0,', 'line 2 does not have 8 values'),
        ('1,10,', '1,x,', 'line 3, generation is x'),
        ('2,20,', '2,2,', 'line 4, generation is 2'),
        ('\n3,', '\n2,', 'line 5, phase is 2'),
        ('4,40,prey,0.', '4,40,prey,7.', 'line 6, predator_fitness is 7'),
        ('3,30,predator,0.', '3,30,predator,nan', 'nan|line 5'),
        ('\n4,', '4,', 'line 5 does not have 8 values'),
        ('\n4,40', '\n\n4,40', 'line 6 does not have 8 values'),
    ],
)
def test_damaged_log(copies, capsys, old, new, sentence):
    path = unsealed(copies[0]) / 'phases.csv'
    text = path.read_text()
    assert text.count(old) >= 1
    path.write_text(text.replace(old, new, 1))
    message = refusal(capsys, copies)
    assert f'{path} is damaged: ' in message
    assert re.search(sentence, message)


def test_a_log_that_is_cut_off(copies, capsys):
    path = unsealed(copies[0]) / 'phases.csv'
    path.write_bytes(path.read_bytes()[:-3])
    assert 'phases.csv is damaged: line 6 is cut off' in refusal(capsys, copies)
    path.write_bytes(b'\xff' + path.read_bytes())
    assert 'line 1, byte 0xff is not UTF-8' in refusal(capsys, copies)
    path.unlink()
    path.mkdir()
    assert 'phases.csv cannot be read: Is a directory' in refusal(capsys, copies)


def test_no_replications(tiny, capsys, tmp_path):
    twin = make_run(tmp_path / 'twin', seed=2)
    assert 'the same replication: seed 2' in refusal(capsys, [*tiny, twin])
    assert 'given twice' in refusal(capsys, [tiny[0], tiny[0]])


def test_what_differs_makes_a_condition_or_an_arena(tiny, tmp_path):
    wider = make_run(tmp_path / 'wider', seed=1, population=16)
    slippery = make_run(tmp_path / 'slippery', seed=1, wall_friction=0.25)
    runs = read_runs([*tiny, wider, slippery])
    assert [(r.condition.name, r.condition.arena, r.seed) for r in runs] == [
        ('Standard, population 16', 'open arena, varied', 1),
        ('Standard, population 8', 'open arena, varied', 1),
        ('Standard, population 8', 'open arena, varied', 2),
        ('Standard', 'open arena, varied, wall friction 0.25', 1),
    ]


def test_what_a_campaign_called_a_condition_reaches_the_analysis(tmp_path):
    runs = [
        make_run(tmp_path / 'a', condition='few_agents', seed=1),
        make_run(tmp_path / 'b', condition='many_agents', seed=1, selected=4),
    ]
    names = [run.condition.name for run in read_runs(runs)]
    assert names == ['Few agents', 'Many agents']


def test_who_never_evolved(tiny, tmp_path):
    """Prey have their turn after 10 generations; this run ends after them."""
    short = make_run(tmp_path / 'short', phases=1)
    assert read_runs([short])[0].never_evolved == ('prey',)
    assert 'the prey never evolves' in (short / 'report.md').read_text()
    assert read_runs(tiny)[0].never_evolved == ()
    assert 'never evolves' not in (tiny[0] / 'report.md').read_text()


def test_no_scheduler(tiny, capsys):
    assert "dask is 'nowhere'" in refusal(capsys, tiny, '--dask', 'nowhere')


@pytest.mark.parametrize(
    ('option', 'value'), [('--every', '0'), ('--probe', '-1'), ('--threads', 'two')]
)
def test_bad_option(tiny, capsys, option, value):
    with pytest.raises(SystemExit) as ended:
        analyze.main([str(tiny[0]), '--out', 'x', option, value])
    assert ended.value.code == 2
    assert 'expected a whole number' in capsys.readouterr().err
