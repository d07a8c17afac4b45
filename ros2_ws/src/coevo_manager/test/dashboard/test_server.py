"""Who is answered by the dashboard, and what is asked of robots."""

import http.client
import json
import threading
from contextlib import contextmanager

import pytest
import uvicorn
from analysis_runs import make_run
from ros_processes import wait_until

from coevo_manager.dashboard import command
from coevo_manager.dashboard.library import Library
from coevo_manager.dashboard.server import make_app

JSON = {'Content-Type': 'application/json'}


class Robots:
    """Notes what it is asked."""

    def __init__(self):
        self.orders = []

    def frame(self):
        return {'robots': []}

    def order(self, name, values):
        self.orders.append((name, values))
        return 'no' if name == 'refused' else ''


@contextmanager
def serving(folders, robots=None, hosts=('127.0.0.1',), token=''):
    """Yield what asks a server: (method, path, headers, body) -> (status, headers, body)."""
    config = uvicorn.Config(None, port=0, log_level='error', ws='none', lifespan='off')
    server = uvicorn.Server(config)
    place = config.bind_socket()
    port = place.getsockname()[1]
    names = None if hosts is None else frozenset(f'{host}:{port}' for host in hosts)
    config.app = make_app(Library(folders), robots, names, token, lambda: server.should_exit)
    thread = threading.Thread(target=server.run, args=([place],))
    thread.start()

    def ask(path, headers=None, method='GET', body=None):
        connection = http.client.HTTPConnection('127.0.0.1', port, timeout=60)
        named = {name: value.format(port=port) for name, value in (headers or {}).items()}
        connection.request(method, path, body, named)
        response = connection.getresponse()
        if response.getheader('Content-Type', '').startswith('text/event-stream'):
            line = response.readline()
            connection.close()
            return response.status, response.headers, line
        return response.status, response.headers, response.read()

    try:
        wait_until(lambda: server.started, 'the server')
        yield ask
    finally:
        server.should_exit = True
        thread.join()
        place.close()


@pytest.fixture(scope='module')
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp('runs')
    make_run(folder / 'mine')
    return folder


@pytest.fixture(scope='module')
def ask(runs):
    with serving([runs]) as the_ask:
        yield the_ask


def test_a_page_of_this_server_is_answered(ask):
    status, headers, body = ask('/', {'Origin': 'http://127.0.0.1:{port}'})
    assert status == 200
    assert b'Red Queen' in body
    assert "default-src 'self'" in headers['Content-Security-Policy']
    assert b'//' not in body.replace(b'http://www.w3.org', b'')  # nothing from elsewhere


@pytest.mark.parametrize(
    ('headers', 'expected'),
    [
        ({'Host': 'rebound.example:{port}'}, 421),
        ({'Host': '127.0.0.1'}, 421),
        ({'Host': '127.0.0.1:{port}', 'Origin': 'http://evil.example'}, 403),
        ({'Host': '127.0.0.1:{port}', 'Origin': 'null'}, 403),
        ({'Host': '127.0.0.1:{port}', 'Origin': 'http://127.0.0.1:1'}, 403),
    ],
)
@pytest.mark.parametrize('path', ['/', '/events', '/charts', '/assets/charts.js'])
def test_others_are_not(ask, path, headers, expected):
    assert ask(path, headers)[0] == expected


@pytest.mark.parametrize(
    'path',
    [
        *('/assets/../command.py', '/assets/..%2fcommand.py', '/assets/%2e%2e/%2e%2e/setup.py'),
        *('/runs/..%2f..%2fetc/episode', '/runs/%2e%2e/tournament', '/etc/passwd', '//etc/passwd'),
        *('/assets/', '/runs/mine/episode', '/robots/frames'),
    ],
)
def test_no_path_leads_out(ask, path):
    assert ask(path)[0] == 404


def test_news_episodes_and_charts(ask):
    news = json.loads(ask('/events')[2].removeprefix(b'data: '))
    (run,) = news['runs']
    assert (run['name'], news['keys']) == ('mine', [run['key']])
    pair = 'predator=40&predator_rank=best&prey=now&prey_rank=median'
    status, _, body = ask(f'/runs/{run["key"]}/episode?{pair}')
    assert status == 200 and 1 <= json.loads(body)['ticks'] <= 150
    status, _, body = ask(f'/runs/{run["key"]}/episode?{pair.replace("40", "..")}')
    assert status == 409 and 'no snapshot of generation' in json.loads(body)['problem']
    chart = json.loads(ask(f'/charts?runs={run["key"]},nobody&by=nothing')[2])
    assert len(chart['panels']) == 4
    (watch,) = json.loads(ask('/watch')[2])
    assert watch['generations'] == ['now', 0, 10, 20, 30, 40]


def test_a_token_is_given_once_and_kept(runs):
    with serving([runs], hosts=None, token='secret') as ask:
        assert ask('/')[0] == ask('/events')[0] == 401
        assert ask('/?token=wrong')[0] == 401
        status, headers, _ = ask('/?token=secret')
        assert (status, headers['Location']) == (303, '/')
        cookie = headers['Set-Cookie']
        assert 'HttpOnly' in cookie and 'SameSite=strict' in cookie
        assert ask('/', {'Cookie': cookie.partition(';')[0]})[0] == 200
        assert ask('/', {'Cookie': cookie.partition('=')[0] + '=wrong'})[0] == 401


def test_robots_are_ordered_by_own_pages_only(runs):
    robots = Robots()
    with serving([runs], robots) as ask:
        body = json.dumps({'ticks': 3})
        assert ask('/robots/step', JSON, 'POST', body)[0] == 200
        assert robots.orders == [('step', {'ticks': 3})]
        assert ask('/robots/refused', JSON, 'POST', '{}')[0] == 409
        robots.orders.clear()
        foreign = JSON | {'Origin': 'http://evil.example'}
        assert ask('/robots/step', foreign, 'POST', body)[0] == 403
        assert ask('/robots/step', JSON | {'Sec-Fetch-Site': 'cross-site'}, 'POST', body)[0] == 403
        assert ask('/robots/step', {'Content-Type': 'text/plain'}, 'POST', body)[0] == 415
        assert ask('/robots/step', JSON, 'POST', '[1]')[0] == 400
        assert ask('/robots/step', JSON, 'POST', '"' + 'x' * 70_000 + '"')[0] == 413
        assert ask('/robots/step')[0] == 405
        assert robots.orders == []
        key = json.loads(ask('/watch')[2])[0]['key']
        chosen = {'species': 'prey', 'run': key, 'generation': 20, 'rank': 'best'}
        assert ask('/robots/genome', JSON, 'POST', json.dumps(chosen))[0] == 200
        ((_, values),) = robots.orders
        assert len(values['parameters']['genome']) == 442
        assert values['parameters']['max_wheel_speed'] == 10.0
        for wrong in ({'run': '../mine'}, {'species': 'cat'}):
            assert ask('/robots/genome', JSON, 'POST', json.dumps(chosen | wrong))[0] == 404
        assert ask('/robots/genome', JSON, 'POST', json.dumps(chosen | {'rank': 9}))[0] == 409


@pytest.mark.parametrize(
    ('arguments', 'sentence'),
    [
        (['nowhere'], 'nowhere is no folder, expected one with runs'),
        ([], 'runs is no folder, expected one with runs; name another'),
        (['--port', '70000', '.'], 'port is 70000, expected a whole number from 0 to 65535'),
        (['--host', 'example.org', '.'], "host is 'example.org', expected an address"),
        (['--host', '192.0.2.1', '.'], 'annot assign requested address'),
    ],
)
def test_bad_options_are_refused_in_one_sentence(
    tmp_path, monkeypatch, capsys, arguments, sentence
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(command.signal, 'signal', lambda *_: None)
    try:
        code = command.main(arguments)
    except SystemExit as error:
        code = error.code
    assert code == 2
    errors = capsys.readouterr().err
    assert sentence in errors
    assert errors.count('\n') == 1
