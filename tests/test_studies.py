"""Scripts that write results into pages, and what scripts/crush shows to TestU01."""

import sys

import captures
import comparison
import crush
import numpy as np
import pandas as pd
import pytest
from analysis_runs import make_run

from coevo_manager.analysis.runs import read_run
from coevo_manager.core.episodes import evaluate_matrix
from coevo_manager.core.episodes.trace import Trace

NOTHING = np.zeros((0, 2, 0), np.float32)


@pytest.fixture(scope='module')
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp('runs')
    return [
        make_run(folder / f'{algorithm}{seed}', algorithm, algorithm=algorithm, seed=seed)
        for algorithm in ('standard', 'simplified')
        for seed in (1, 2)
    ]


def page(folder, name):
    path = folder / 'page.md'
    path.write_text(f'before\n<!-- {name} -->\nold\n<!-- {name} -->\nafter\n')
    return path


def call(script, monkeypatch, *arguments):
    monkeypatch.setattr(sys, 'argv', ['script', *map(str, arguments)])
    return script.main()


def chase(captured):
    """Return 20 ticks in which a predator closes in from behind on prey at the right wall."""
    poses = np.zeros((21, 2, 3), np.float32)
    poses[:, 1, :2] = np.linspace((0.5, 0.2), (1.4, 0.2), 21)
    poses[:, 0, :2] = np.linspace((-0.5, 0.2), (1.23, 0.2), 21)
    poses[:, 1, 2] = np.pi  # the prey backs up, and sees its hunter ahead
    wheels = np.ones((20, 2, 2), np.float32)
    wheels[:, 1] = -2
    return Trace(poses, wheels, NOTHING, NOTHING, NOTHING, NOTHING, 20, captured)


def test_a_capture_is_described():
    found = captures.describe(chase(True), 3.0)
    assert found['caught'] and found['seconds'] == pytest.approx(2)
    assert found['at_wall'] and found['away'] and not found['from_behind']
    assert found['prey_backward'] and not found['predator_backward']
    assert found['prey_speed'] == pytest.approx(2 * found['predator_speed'])
    assert found['walls'] == pytest.approx(1 / 21)  # the rim is within 5 cm from x = 1.365 on
    assert set(captures.describe(chase(False), 3.0)) == {'caught', 'walls'}


def test_captures_are_those_of_the_kernel(runs, tmp_path, monkeypatch):
    target = page(tmp_path, 'captures')
    assert call(captures, monkeypatch, target, *runs, '--early', 10) == 0
    text = target.read_text()
    assert text.startswith('before\n') and text.endswith('after\n') and 'old' not in text
    run = read_run(runs[0])
    episodes = captures.meet(run, 10).groupby('meeting').caught.mean()
    best = {g: run.snapshot(g) for g in (10, 40)}
    for meeting, (hunter, hunted) in captures.MEETINGS.items():
        generations = 10, 40
        ticks = evaluate_matrix(
            best[generations[hunter]].best('predator', 10),
            best[generations[hunted]].best('prey', 10),
            run.environment,
        )
        assert episodes[meeting] == pytest.approx((ticks < 150).mean(), abs=0.02)
    assert text.count('late predators, late prey') == 2


def test_methods_are_compared_by_what_they_reach_against_all_others(runs, tmp_path, monkeypatch):
    target = page(tmp_path, 'comparison')
    call(comparison, monkeypatch, target, *runs)
    first = target.read_text()
    table = pd.read_csv(tmp_path / 'page.csv').set_index(['condition', 'seed'])
    last = {folder.name: read_run(folder).snapshot(40) for folder in runs}
    environment = read_run(runs[0]).environment
    hunters = last['standard1'].best('predator', 10)
    scores = [
        1 - evaluate_matrix(hunters, last[other].best('prey', 10), environment).mean() / 150
        for other in ('simplified1', 'simplified2')
    ]
    assert table.cross_predator['standard', 1] == pytest.approx(np.mean(scores), abs=1e-4)
    for name in ('comparison_cross.png', 'comparison_progress.png'):
        assert (tmp_path / name).stat().st_size > 10_000
    assert '| simplified |' in first and 'against standard' in first
    call(comparison, monkeypatch, target, *runs)
    assert target.read_text() == first


@pytest.mark.parametrize('script', [captures, comparison])
def test_a_page_without_marks_is_refused(script, runs, tmp_path, monkeypatch, capsys):
    path = tmp_path / 'page.md'
    path.write_text('nothing\n')
    try:
        code = call(script, monkeypatch, path, *runs)
    except SystemExit as end:
        code = end.code
    assert code == 2
    assert 'has 0 lines <!--' in capsys.readouterr().err
    assert path.read_text() == 'nothing\n'


def test_a_battery_sees_the_words_of_episode_after_episode():
    rows = np.zeros((crush.AGE + 1, 16), np.uint32)
    expected = []
    for episode in (0, 8):
        crush.draw(rows, episode)
        expected += rows[:-3].ravel().tolist()
    assert len(set(expected)) > 0.9999 * len(expected)
    for backwards in (0, 1):
        state = np.array([crush.WORDS, 0, backwards])
        seen = [crush.next_word(rows, state) for _ in range(len(expected))]
        assert seen == (
            [int(f'{word:032b}'[::-1], 2) for word in expected] if backwards else expected
        )
