"""The dashboard as a user meets it: a run that goes on, a real browser, robots on their topics."""

import http.client
import json
import re
import signal
from urllib.parse import urlsplit

import psutil
import pytest
from analysis_runs import make_run
from browser import SHOW, ask, click, open_browser, until
from evolve_runs import TOY, evaluators_of, phases_completed
from ros_processes import ROOT, wait_until
from selenium.webdriver import ActionChains, Keys
from selenium.webdriver.support.ui import Select

ENDLESS = [*TOY, '--phases', '100000', '--snapshot-generations', '500']
RUNNING, KILLED = 'running', 'ended without a word: killed, or its machine went down'


def address_of(process, timeout=120):
    """The address that a process prints, once it answers."""
    process.wait_for_output('http://', timeout)
    return re.search(r'http://\S+', process.stdout_text).group()


def fact(page, run, name):
    """What the page says of a run under a name."""
    path = f'[data-run="{run}"] [data-fact="{name}"]'
    return ask(page, 'document.querySelector(arguments[0])?.textContent', path)


def state(page, run):
    path = f'[data-run="{run}"] .state'
    return ask(page, 'document.querySelector(arguments[0])?.textContent', path)


LAST_DRAWN = """((plot) => {
  const curve = plot?.data?.at(-1);
  return curve && (curve.x ? curve.x.at(-1) : curve.x0 + curve.dx * (curve.y.length - 1));
})(document.querySelector('#run-charts .chart-plot'))"""


def last_drawn(page):
    """Up to which generation the first chart's curve goes; None before it is drawn."""
    return ask(page, LAST_DRAWN)


@pytest.fixture
def page():
    with open_browser() as browser:
        yield browser


def fits(page, width, scheme):
    """Whether the page is no wider than a window, in a colour scheme that it follows."""
    metrics = {'width': width, 'height': 844, 'deviceScaleFactor': 1, 'mobile': width < 800}
    page.execute_cdp_cmd('Emulation.setDeviceMetricsOverride', metrics)
    page.execute_cdp_cmd(
        'Emulation.setEmulatedMedia',
        {'features': [{'name': 'prefers-color-scheme', 'value': scheme}]},
    )
    ground = ask(page, 'getComputedStyle(document.body).backgroundColor')
    assert (sum(map(int, re.findall(r'\d+', ground))) < 200) == (scheme == 'dark')
    root = 'document.documentElement'
    return until(lambda: ask(page, f'{root}.scrollWidth <= {root}.clientWidth'))


@pytest.mark.timeout(600)
def test_a_run_is_watched_until_it_is_killed(start, page, tmp_path):
    out = tmp_path / 'runs' / 'mine'
    run = start(['coevo_manager', 'evolve', *ENDLESS, '--evaluators', '2', '--out', out])
    wait_until(lambda: phases_completed(out) >= 2, 'two phases')
    watcher = start(['coevo_manager', 'dashboard', tmp_path / 'runs'])
    page.get(address_of(watcher))
    assert until(lambda: state(page, 'mine')) == RUNNING
    before = fact(page, 'mine', 'generation')
    assert until(lambda: fact(page, 'mine', 'generation') != before)
    assert until(lambda: re.match(r'\d', fact(page, 'mine', 'time left')))
    assert until(lambda: re.match(r'\d', fact(page, 'mine', 'ticks a second')))
    assert until(lambda: 'Evaluators: 2 of 2 at work' in page.find_element('id', 'run-list').text)

    assert until(lambda: last_drawn(page))
    zoomed = "document.querySelector('#run-charts .chart-plot').layout.xaxis.range.slice()"
    page.execute_script(
        "return Plotly.relayout(document.querySelector('#run-charts .chart-plot'), "
        "{'xaxis.range': [3, 7]})"
    )
    drawn = last_drawn(page)
    assert until(lambda: last_drawn(page) > drawn)
    assert ask(page, zoomed) == [3, 7]

    page.find_element('css selector', 'nav a[href="#watch"]').send_keys('\n')
    assert until(lambda: ask(page, 'window.player?.trace?.ticks'), 120)
    play = page.find_element('css selector', '#player [data-part=play]')
    click(page, play)
    assert until(lambda: ask(page, 'player.time') > 3)
    ask(page, "player.chooseCell('0/0/1/1')")  # the best predator of now, the median prey of 0
    assert until(lambda: ask(page, 'player.name') == '0/0/1/1')
    assert until(lambda: page.find_elements('css selector', '#tournament .main-svg'), 120)
    snapshots = 'player.run.generations.length'
    known = ask(page, snapshots)
    assert until(lambda: ask(page, snapshots) > known, 150)
    assert ask(page, 'player.name') == '0/0/1/1'
    for width, scheme in ((390, 'dark'), (1280, 'light')):
        assert fits(page, width, scheme)

    first, _ = evaluators_of(run.pid)
    first.send_signal(signal.SIGKILL)
    page.find_element('css selector', 'nav a[href="#runs"]').send_keys('\n')
    assert until(lambda: '1 failed' in page.find_element('id', 'run-list').text)
    assert 'ended by SIGKILL' in ask(page, "document.getElementById('run-list').textContent")
    assert fits(page, 390, 'dark')

    run.kill()
    run.wait()
    assert until(lambda: state(page, 'mine') == KILLED)
    watcher.send_signal(signal.SIGINT)
    assert watcher.wait() == 0
    assert until(lambda: page.find_element('id', 'connection').is_displayed())
    names = ask(page, "performance.getEntriesByType('resource').map((entry) => entry.name)")
    assert names and all(name.startswith((address_of(watcher), 'data:')) for name in names)
    assert not [e for e in page.get_log('browser') if 'plotly' in e['message']]


@pytest.mark.parametrize('quiet', [(), ('--quiet',)], ids=' '.join)
def test_evolve_starts_a_dashboard_and_needs_none(start, tmp_path, quiet):
    out = tmp_path / 'run'
    run = start(['coevo_manager', 'evolve', *ENDLESS, '--dashboard', *quiet, '--out', out])
    address = address_of(run)
    place = urlsplit(address)
    connection = http.client.HTTPConnection(place.hostname, place.port, timeout=60)
    connection.request('GET', '/events')
    news = json.loads(connection.getresponse().readline().removeprefix(b'data: '))
    assert [each['name'] for each in news['runs']] == ['run']
    children = psutil.Process(run.pid).children()
    (child,) = [c for c in children if 'coevo_manager.dashboard.command' in c.cmdline()]
    child.kill()
    done = phases_completed(out)
    wait_until(lambda: phases_completed(out) > done, 'a phase without the dashboard')
    run.send_signal(signal.SIGINT)
    assert run.wait() == 130
    if quiet:
        assert run.stdout_text == f'dashboard: {address}\n'


@pytest.mark.timeout(600)
def test_robots_are_watched_and_ordered(start, page, tmp_path):
    make_run(tmp_path / 'runs' / 'mine')
    demo = start([ROOT / 'scripts' / 'ros2', 'launch', 'coevo_manager', 'demo.launch.xml'])
    watcher = start(['coevo_manager', 'dashboard', '--topics', tmp_path / 'runs'])
    page.get(f'{address_of(watcher)}#robots')
    assert until(lambda: ask(page, "frame?.arena?.tick > 5 && 'x' in frame.robots[1]"), 120)
    assert until(lambda: ask(page, 'frame.robots.every((r) => r.neurons.some((n) => n > 0))'))
    assert until(lambda: ask(page, 'frame.robots.some((r) => r.wheels[0] !== 0)'))
    assert until(lambda: 'simulator' in page.find_element('id', 'diagnostics').text)
    assert fits(page, 390, 'dark')
    assert fits(page, 1280, 'light')

    click(page, page.find_element('id', 'pause'))
    assert until(lambda: page.find_element('id', 'pause').text == 'Go on')
    tick = ask(page, 'frame.arena.tick')
    click(page, page.find_element('id', 'step'))
    assert until(lambda: ask(page, 'frame.arena.tick') == tick + 1)
    click(page, page.find_element('id', 'reset'))
    assert until(lambda: ask(page, 'frame.arena.tick') == 0)

    before = robot(page, 0)
    arena = page.find_element('id', 'robots-arena')
    page.execute_script(SHOW, arena)
    scale = ask(page, 'arguments[0].clientWidth / (view.world.arena * 1.02)', arena)
    pull = ActionChains(page).move_to_element_with_offset(
        arena, round(before['x'] * scale), round(-before['y'] * scale)
    )
    pull.click_and_hold().move_by_offset(30, -60).release().perform()
    assert until(lambda: robot(page, 0)['y'] > before['y'])
    after = robot(page, 0)
    assert after['x'] - before['x'] == pytest.approx(30 / scale, abs=2 / scale)
    assert after['y'] - before['y'] == pytest.approx(60 / scale, abs=2 / scale)
    arena.send_keys('p', Keys.ARROW_DOWN, Keys.ENTER)
    assert until(lambda: robot(page, 0)['y'] == pytest.approx(after['y'] - 0.05, abs=1e-5))
    page.execute_script("order('poses', {robots: [[9, 9, 0], [0, 0, 0]]})")
    problem = page.find_element('id', 'robots-problem')
    assert until(problem.is_displayed) and 'predator' in problem.text
    Select(page.find_element('id', 'swap-species')).select_by_visible_text('prey')
    click(page, page.find_element('id', 'swap-go'))
    demo.wait_for_output('[prey.controller]: new network')
    assert until(lambda: not problem.is_displayed())


def robot(page, k):
    """Where a robot is: x, y and heading."""
    return ask(page, 'frame.robots[arguments[0]]', k)
