"""The whole analysis of tiny real runs, and the report clicked through in a browser."""

import base64
import dataclasses
import shutil
import zlib
from types import SimpleNamespace

import claims
import numpy as np
import pandas as pd
import pytest
from analysis_runs import make_run
from browser import SHOW, ask, click, open_browser, until

from coevo_manager.analysis import command as analyze
from coevo_manager.analysis.measures import games
from coevo_manager.analysis.play.behaviours import without_sensor_noise
from coevo_manager.analysis.play.kernel import Kernel
from coevo_manager.analysis.play.probe import SearchBudget
from coevo_manager.analysis.play.tournament import Evaluations, Store
from coevo_manager.analysis.report import player
from coevo_manager.analysis.report.packing import layer_places, pack
from coevo_manager.analysis.report.page import answer
from coevo_manager.analysis.runs import read_run, read_runs
from coevo_manager.analysis.study import collect
from coevo_manager.core.behaviour import MEASURES, behaviour
from coevo_manager.core.behaviour import complexity as complexity_of
from coevo_manager.core.episodes import evaluate_matrix, measure_pairs, trace_pair
from coevo_manager.core.evolution import load_configuration
from coevo_manager.core.species import SPECIES
from neuro_controller.core.genome import LAYOUT

CHANNELS = layer_places(LAYOUT)['channels']


@pytest.fixture(scope='module')
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp('runs')
    made = [make_run(folder / f'standard{seed}', seed=seed) for seed in (1, 2, 3)]
    made.append(make_run(folder / 'simplified1', algorithm='simplified', seed=1))
    for seed in (1, 2):
        made.append(make_run(folder / f'obstacle{seed}', environment='obstacle', seed=seed))
    return made


@pytest.fixture(scope='module')
def out(runs, tmp_path_factory):
    """The folder of a finished analysis."""
    folder = tmp_path_factory.mktemp('analysis') / 'out'
    arguments = [*map(str, runs), '--out', str(folder), '--probe', '4', '--held-out', '3']
    assert analyze.main([*arguments, '--threads', '1']) == 0
    return folder


def table(out, name):
    return pd.read_csv(out / 'tables' / f'{name}.csv')


def test_every_cell_of_the_tournament(runs, out):
    found = table(out, 'master_tournament')
    found = found[(found.arena == 'open arena') & (found.condition == 'Standard')]
    assert len(found) == 3 * 5 * 5
    run = read_run(runs[1])
    for row in found[found.seed == 2].itertuples():
        predators = run.snapshot(row.predator_generation).predators
        prey = run.snapshot(row.prey_generation).prey
        fitness = 1 - evaluate_matrix(predators, prey, run.environment).mean() / 150
        assert row.predator_fitness == pytest.approx(fitness, rel=1e-5)


def test_held_out_opponents_are_the_best_of_other_runs(runs, out):
    found = table(out, 'held_out')
    row = found[
        (found.arena == 'arena with obstacle') & (found.seed == 1) & (found.species == 'prey')
    ].set_index('generation')
    run, other = read_run(runs[4]), read_run(runs[5])
    last = other.snapshot(40)
    elite = last.predators[np.argsort(-last.fitness.mean(axis=1), kind='stable')[:3]]
    for generation in (0, 40):
        prey = run.snapshot(generation).prey
        ticks = evaluate_matrix(elite, prey, run.environment)
        assert row.fitness[generation] == pytest.approx(ticks.mean() / 150, rel=1e-5)


def test_the_tournament_is_told_as_a_game(runs, out):
    tournament = table(out, 'master_tournament')
    tournament = tournament[tournament.arena == 'open arena']
    one = tournament[(tournament.condition == 'Standard') & (tournament.seed == 2)]
    fitness = one.pivot(
        index='predator_generation', columns='prey_generation', values='predator_fitness'
    ).to_numpy()

    def own(name):
        found = table(out, name)
        return found[
            (found.arena == 'open arena') & (found.condition == 'Standard') & (found.seed == 2)
        ]

    equilibrium, share = games.nash_average(fitness), games.alpha_rank(fitness)
    nash, alpha = own('nash_averaging'), own('alpha_rank')
    for species, rating, time in (
        ('predator', equilibrium.predator_ratings, share.sum(axis=1)),
        ('prey', equilibrium.prey_ratings, share.sum(axis=0)),
    ):
        found = nash[nash.species == species]
        assert found.rating.to_numpy() == pytest.approx(rating, abs=1e-3)
        assert found.probability.sum() == pytest.approx(1, abs=1e-4)
        found = alpha[alpha.species == species].share_of_time.to_numpy()
        assert found == pytest.approx(time, abs=1e-3)
    exploited = own('meta_exploitability').exploitability.to_numpy()
    assert exploited == pytest.approx(games.exploitability(fitness), abs=1e-4)
    diversity = own('effective_diversity').effective_diversity.item()
    assert diversity == pytest.approx(games.effective_diversity(fitness), abs=1e-3)
    page = (out / 'report.html').read_text()
    assert page.count('Nash averaging puts weight on the last quarter of the run: predators') == 3
    assert (out / 'figures' / 'games_open_arena.svg').exists()


def test_claims_are_those_of_the_tables(out, tmp_path, monkeypatch):
    page = tmp_path / 'page.md'
    page.write_text('<!-- claims -->\n<!-- claims -->\n')
    arguments = ['claims', str(out), str(page), '--early', '10']
    monkeypatch.setattr('sys.argv', arguments)
    claims.main()
    found = pd.read_csv(tmp_path / 'page.csv').set_index(['arena', 'condition'])
    standard = found.loc['open arena', 'Standard']
    cells = table(out, 'master_tournament')
    cells = cells[(cells.arena == 'open arena') & (cells.condition == 'Standard')]
    mean = cells.groupby(['predator_generation', 'prey_generation']).predator_fitness.mean()
    assert standard.contemporaries == pytest.approx(mean[40, 40], abs=1e-4)
    assert standard.late_predators_early_prey == pytest.approx(mean[40, 10], abs=1e-4)
    assert standard.early_predators_late_prey == pytest.approx(mean[10, 40], abs=1e-4)
    assert (standard.seeds, standard.generations) == (3, 40)
    assert f'| {mean[40, 40]:.2f} |' in page.read_text()


def test_the_league_is_of_the_matches_between_conditions(out):
    found = table(out, 'league').set_index('condition')
    assert set(found.index) == {'Standard', 'Simplified'}  # only one condition has the obstacle
    cross = table(out, 'cross_experiment').set_index(
        ['predators_condition', 'predators_seed', 'prey_condition', 'prey_seed']
    )['predator_fitness']
    margins = [
        cross['Standard', seed, 'Simplified', 1] - cross['Simplified', 1, 'Standard', seed]
        for seed in (1, 2, 3)
    ]
    won, lost = (sum(sign * m > 0 for m in margins) for sign in (1, -1))
    assert (found.won['Standard'], found.lost['Standard']) == (won, lost)
    assert (found.won['Simplified'], found.lost['Simplified']) == (lost, won)
    assert list(found.rating) == sorted(found.rating, reverse=True)
    assert (found.rating['Standard'] > found.rating['Simplified']) == (won > lost)


def test_complexity_is_that_of_the_recorded_wheels(runs, out):
    run = read_run(runs[0])
    snapshot = run.snapshot(40)
    trace = trace_pair(snapshot.predators[2], snapshot.prey[5], run.environment)
    _, complexity = measure_pairs(snapshot.predators, snapshot.prey, [2], [5], run.environment)
    for robot in (0, 1):
        expected = complexity_of(trace.wheels)[robot]
        assert complexity[0, robot] == pytest.approx(expected, rel=1e-4)
    index = np.indices((8, 8)).reshape(2, -1)
    _, every = measure_pairs(snapshot.predators, snapshot.prey, *index, run.environment)
    found = table(out, 'complexity')
    found = found[(found.arena == 'open arena') & (found.condition == 'Standard')]
    found = found[found.seed == 1]
    for robot, species in enumerate(SPECIES):
        row = found[(found.species == species) & (found.generation == 40)]
        assert row.complexity.item() == pytest.approx(every[:, robot].mean(), rel=1e-4)


def test_behaviour_is_that_of_the_recorded_wheels(runs, out):
    """Prey of generation 20 against the best predators of the last, without a capture."""
    found = table(out, 'behaviour')
    assert set(found.opponents) == {'contemporaries', 'fixed'}
    found = found[(found.arena == 'open arena') & (found.condition == 'Standard')]
    found = found[(found.seed == 2) & (found.species == 'prey') & (found.opponents == 'fixed')]
    row = found[found.generation == 20].iloc[0]
    run = read_run(runs[1])
    predators, prey = run.snapshot(40).best('predator', 10), run.snapshot(20).best('prey', 20)
    measured = [
        behaviour(trace.wheels[:, 1])
        for predator in predators
        for genome in prey
        for trace in [trace_pair(predator, genome, run.environment)]
        if not trace.captured
    ]
    assert row.episodes == len(measured) > 0
    for name in MEASURES:
        assert row[name] == pytest.approx(np.mean([each[name] for each in measured]), rel=1e-5)


def test_sensor_noise_is_left_out_and_nothing_else():
    noisy = load_configuration({'world': 'robust'}).make_environment()
    quiet = without_sensor_noise(noisy).perturbations
    changed = {
        field.name
        for field in dataclasses.fields(quiet)
        if getattr(quiet, field.name) != getattr(noisy.perturbations, field.name)
    }
    assert changed == {'infrared_noise', 'camera_noise', 'ground_noise'}
    assert quiet.infrared_noise == quiet.camera_noise == quiet.ground_noise == 0


def test_cross_experiment_sets_last_generations_against_each_other(runs, out):
    found = table(out, 'cross_experiment')
    assert len(found) == 4 * 4 + 2 * 2  # within an environment only
    row = found[(found.predators_condition == 'Simplified') & (found.prey_seed == 3)]
    predators = read_run(runs[3]).snapshot(40).predators
    prey = read_run(runs[2]).snapshot(40).prey
    ticks = evaluate_matrix(predators, prey, read_run(runs[2]).environment)
    assert row.predator_fitness.item() == pytest.approx(1 - ticks.mean() / 150, rel=1e-5)


def test_runs_reproduce_and_single_replications_claim_nothing(out):
    runs = table(out, 'runs')
    assert runs['reproduced'].all()
    assert runs['evolved_with'].str.contains('numba').all()
    verdicts = table(out, 'verdicts').set_index('condition')
    alone = set(verdicts.loc['Simplified', 'verdict'])
    assert 'cannot be claimed' in alone <= {'cannot be claimed', 'no change'}
    assert 'cannot be claimed' not in set(verdicts.loc['Standard', 'verdict'])
    assert table(out, 'table1_open_arena_paper')['Simplified prey'].isna().all()


@pytest.mark.parametrize(
    ('verdicts', 'expected'),
    [
        (('progress', 'progress'), 'Global progress of predators and prey; '),
        (('not significant', 'progress'), 'Global progress of prey; '),
        (('not significant', 'not significant'), 'No significant global progress; '),
        (('no change', 'progress'), 'Global progress of prey, no change of predators; '),
        (('cyclic', 'retrogression'), 'global progress, a gain of predators within a cycle, retr'),
        (('cannot be claimed', 'cannot be claimed'), 'One replication claims nothing; '),
    ],
)
def test_the_answer_says_what_the_verdicts_are(verdicts, expected):
    rows = [
        {'species': species, 'measure': measure, 'verdict': verdict, 'difference': 0.1}
        for measure in ('global', 'historical')
        for species, verdict in zip(SPECIES, verdicts, strict=True)
    ]
    assert expected in answer(pd.DataFrame(rows))


def test_every_figure_is_there_twice(out):
    names = {path.stem for path in (out / 'figures').glob('*.png')}
    assert {path.stem for path in (out / 'figures').glob('*.svg')} == names
    for start in (
        *('fitness_evolving', 'fitness_populations', 'master_tournament', 'ciao', 'progress'),
        *('complexity', 'complexity_correlation', 'held_out', 'gains', 'exploitability'),
        *('ratings', 'diversity', 'behaviour', 'complexity_quiet'),
    ):
        assert {f'{start}_open_arena', f'{start}_arena_with_obstacle'} <= names
    assert 'cross_experiment_open_arena' in names
    assert 'obstacle_comparison_global' in names
    assert 'behaviours_arena_with_obstacle_standard' in names


def test_a_second_analysis_plays_only_what_is_new(runs, out, tmp_path):
    kernel = Kernel()
    generations = [0, 10, 20, 30, 40]

    def measure(folders):
        stored = Evaluations(kernel, Store(tmp_path / 'cache', kernel.version))
        silent = lambda title, total: lambda amount: None  # noqa: E731
        return collect(read_runs(folders), generations, stored, SearchBudget(4), 3, silent)

    shutil.copytree(out / 'cache', tmp_path / 'cache')
    study = measure(reversed(runs[4:]))
    assert study.played == 0
    found = table(out, 'master_tournament')
    found = found[found.arena == 'arena with obstacle'].predator_fitness.to_numpy()
    assert study.conditions[0].tournament.ravel() == pytest.approx(found, rel=1e-5)
    newcomer = make_run(tmp_path / 'new', environment='obstacle', seed=7)
    # Its own tournament, and with each of the two others both cross cells and held-out games;
    # fewer where a species did not evolve between two snapshots, whose content is then the same.
    most = 64 * (25 + 2 * 2) + 24 * 5 * 2 * 2 * 2
    assert most / 4 < measure([*runs[4:], newcomer]).played <= most
    assert measure([newcomer, *runs[4:]]).played == 0


def test_many_conditions_show_the_best_alone():
    condition = SimpleNamespace(snapshots=[[None] * 16])
    assert player.ranks([condition] * 3) == ('best', 'median')
    assert player.ranks([condition] * 6) == ('best',)


def unpack(text, ticks):
    """Undo `pack`, independently of the page's script: poses (m, rad) and neurons, in channels."""
    data = zlib.decompress(base64.b64decode(text), -15)
    cut = 2 * 2 * 3 * (ticks + 1)
    poses = np.frombuffer(data[:cut], '<i2').reshape(2, 3, ticks + 1)
    poses = poses.cumsum(-1, dtype=np.int16).cumsum(-1, dtype=np.int16)
    rest = data[cut + 2 * 2 * 2 * ticks :]
    neurons = np.frombuffer(rest, np.uint8).reshape(2, CHANNELS, ticks)
    scale = np.array([0.001, 0.001, 2 * np.pi / 4096])[:, None]
    return poses * scale, neurons.cumsum(-1, dtype=np.uint8) / 31


def test_packed_episodes_keep_what_happened(runs):
    run = read_run(runs[4])
    snapshot = run.snapshot(40)
    trace = trace_pair(snapshot.predators[0], snapshot.prey[0], run.environment)
    poses, neurons = unpack(pack(trace)['data'], trace.ticks)
    for robot in (0, 1):
        assert poses[robot, :2] == pytest.approx(trace.poses[:, robot, :2].T, abs=6e-4)
        turns = poses[robot, 2] - trace.poses[:, robot, 2]
        assert np.abs(np.sin(turns / 2)).max() < 5e-4
        assert neurons[robot, 49:59] == pytest.approx(trace.hidden[:, robot].T, abs=0.017)
        assert neurons[robot, 24:49] == pytest.approx(trace.inputs[:, robot].T, abs=0.017)


@pytest.fixture(scope='module')
def page(out):
    """The report in headless Chromium."""
    with open_browser() as browser:
        browser.get(f'file://{out / "report.html"}')
        yield browser


def part(page, name):
    """A part of the episode player."""
    return page.find_element('css selector', f'#player [data-part="{name}"]')


def test_the_answer_comes_first(page):
    text = ask(page, "document.getElementById('glance').innerText")
    assert 'One replication claims nothing' in text
    assert 'Simplified' in text
    assert ask(page, "document.querySelectorAll('.verdicts .chip').length") == 3 * 6


def test_charts_draw_hover_and_zoom(page):
    whole = page.find_element('css selector', '[data-chart=ratings_open_arena]')
    page.execute_script(SHOW, whole)
    chart = until(lambda: whole.find_elements('css selector', '.chart-plot'))[0]
    assert until(lambda: chart.find_elements('css selector', '.scatterlayer .trace'))
    assert ask(page, 'arguments[0].data.some((t) => t.y.length === 5)', chart)
    from selenium.webdriver import ActionChains

    drag = chart.find_element('css selector', '.nsewdrag')
    point = chart.find_elements('css selector', '.scatterlayer .point')[2]
    ActionChains(page).move_to_element(point).perform()
    assert until(lambda: chart.find_elements('css selector', '.hoverlayer .hovertext'))
    before = ask(page, 'arguments[0].layout.xaxis.range.slice()', chart)
    pull = ActionChains(page).move_to_element(drag).click_and_hold().move_by_offset(120, 40)
    pull.release().perform()
    assert until(lambda: ask(page, 'arguments[0].layout.xaxis.range.slice()', chart) != before)
    after = ask(page, 'arguments[0].layout.xaxis.range.slice()', chart)
    assert after[1] - after[0] < before[1] - before[0]


def test_every_chart_can_be_drawn(page):
    charts = page.find_elements('css selector', '[data-chart]')
    # Of each arena, but no cross-experiment test of a single condition, and the league of all.
    assert len(charts) == 16 * 2 - 1 + 2 + 1
    for chart in charts:
        page.execute_script(SHOW, chart)
        drawn = until(lambda c=chart: c.find_elements('css selector', '.main-svg'))
        assert drawn, chart.get_attribute('data-chart')
    buttons = ask(
        page, "[...document.querySelectorAll('.modebar-btn')].map((b) => b.dataset.title)"
    )
    assert buttons and not [title for title in buttons if 'hare' in title]  # it would upload


def test_the_contents_lead_to_every_figure_and_table(page):
    links = ask(page, "[...document.querySelectorAll('#contents a')].map((a) => a.hash.slice(1))")
    figures = ask(page, "[...document.querySelectorAll('figure, .scroll[id]')].map((f) => f.id)")
    assert set(figures) - set(links) == {'table-runs', 'table-configuration'}
    assert ask(page, 'arguments[0].every((id) => document.getElementById(id))', links)


@pytest.mark.parametrize('width', [390, 1280])
def test_the_page_fits_its_window(page, width):
    metrics = {'width': width, 'height': 844, 'deviceScaleFactor': 1, 'mobile': width < 800}
    page.execute_cdp_cmd('Emulation.setDeviceMetricsOverride', metrics)
    try:
        page.refresh()
        for chart in page.find_elements('css selector', '[data-chart]')[:6]:
            page.execute_script(SHOW, chart)
            assert until(lambda c=chart: c.find_elements('css selector', '.main-svg'))
        root = 'document.documentElement'
        assert ask(page, f'{root}.scrollWidth <= {root}.clientWidth')
        columns = "getComputedStyle(document.querySelector('.chart-panels')).gridTemplateColumns"
        assert (len(ask(page, columns).split()) == 1) == (width == 390)
    finally:
        page.execute_cdp_cmd('Emulation.clearDeviceMetricsOverride', {})
        page.refresh()


def test_the_player_shows_the_episode(page, runs):
    page.execute_script("document.getElementById('chase').scrollIntoView({behavior: 'instant'})")
    from selenium.webdriver.support.ui import Select

    Select(part(page, 'run')).select_by_index(2)
    for name, value in (('predator-generation', '40'), ('predator-rank', 'best'),
                        ('prey-generation', '0'), ('prey-rank', 'median')):  # fmt: skip
        Select(part(page, name)).select_by_visible_text(value)
    assert until(lambda: ask(page, 'player.name') == '3/0/0/1')
    run = read_run(runs[4])
    last, first = run.snapshot(40), run.snapshot(0)
    predator = last.predators[np.argmax(last.fitness.mean(axis=1))]
    prey = first.prey[np.argsort(first.fitness.mean(axis=0), kind='stable')[4]]
    trace = trace_pair(predator, prey, run.environment)
    assert ask(page, 'player.trace.ticks') == trace.ticks
    for tick in (0, trace.ticks // 2, trace.ticks):
        page.execute_script('player.seek(arguments[0])', tick)
        for robot in (0, 1):
            pose = ask(page, 'player.pose(arguments[0], player.time)', robot)
            assert [pose['x'], pose['y']] == pytest.approx(trace.poses[tick, robot, :2], abs=6e-4)
    page.execute_script('player.seek(3)')
    for k in range(10):
        shown = ask(page, 'player.neuron(1, 49 + arguments[0])', k)
        assert shown == pytest.approx(float(trace.hidden[3, 1, k]), abs=0.017)
    pixels = 'player.element("arena").toDataURL()'
    before = ask(page, pixels)
    click(page, part(page, 'forward'))
    assert ask(page, 'player.time') == 4
    assert ask(page, pixels) != before


def test_the_player_plays_pauses_scrubs_and_steps(page):
    from selenium.webdriver import Keys
    from selenium.webdriver.support.ui import Select

    Select(part(page, 'speed')).select_by_value('0.5')
    page.execute_script('player.seek(0)')
    play = part(page, 'play')
    click(page, play)
    assert until(lambda: ask(page, 'player.time') > 3)
    assert play.text == 'Pause'
    click(page, play)
    stopped = ask(page, 'player.time')
    assert not ask(page, 'player.playing')
    page.find_element('id', 'player').send_keys(Keys.ARROW_RIGHT)
    assert ask(page, 'player.time') == round(stopped) + 1
    scrub = part(page, 'scrub')
    page.execute_script(
        "arguments[0].value = 7; arguments[0].dispatchEvent(new Event('input'))", scrub
    )
    assert ask(page, 'player.time') == 7
    assert '0.7 s of' in part(page, 'status').text


def test_a_cell_of_the_grid_loads_its_pair(page):
    cell = page.find_element(
        'css selector', '#player [data-part=grid] button[data-name="1/1/2/0"]'
    )
    click(page, cell)
    assert until(lambda: ask(page, 'player.name') == '1/1/2/0')
    assert cell.get_attribute('aria-pressed') == 'true'
    assert ask(page, "player.element('prey-generation').value") == '2'


def test_tables_sort(page):
    name = 'table-retrogression'
    column = ask(page, f"[...document.querySelectorAll('#{name} th')].findIndex("
                       "(cell) => cell.textContent.trim() === 'rate of "
                       "retrogression')")  # fmt: skip
    values = (f"[...document.querySelectorAll('#{name} tbody tr')]"
              f'.map((row) => Number(row.cells[{column}].dataset.value))')  # fmt: skip
    button = page.find_elements('css selector', f'#{name} th button')[column]
    for direction in (1, -1):
        click(page, button)
        found = ask(page, values)
        assert found == sorted(found, reverse=direction < 0)
    assert len(set(found)) > 1


def test_in_print_the_drawn_figures_stand_in(page):
    page.execute_cdp_cmd('Emulation.setEmulatedMedia', {'media': 'print'})
    try:
        loaded = "[...document.querySelectorAll('figure img')].every((i) => i.naturalWidth > 100)"
        assert until(lambda: ask(page, loaded))
        screen = "[...document.querySelectorAll('.plot, #chase')]"
        shown = f'{screen}.filter((each) => each.offsetHeight).length'
        assert ask(page, shown) == 0
        pdf = page.execute_cdp_cmd('Page.printToPDF', {'preferCSSPageSize': True})
        assert base64.b64decode(pdf['data']).startswith(b'%PDF')
    finally:
        page.execute_cdp_cmd('Emulation.setEmulatedMedia', {'media': ''})


def test_nothing_is_fetched_and_nothing_fails(page):
    names = ask(page, "performance.getEntriesByType('resource').map((entry) => entry.name)")
    assert [name for name in names if not name.startswith(('blob:', 'data:'))] == []
    assert [entry for entry in page.get_log('browser') if entry['level'] == 'SEVERE'] == []
