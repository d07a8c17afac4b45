"""The dashboard's pages and what they ask for (docs/dashboard.md)."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Callable
from importlib.resources import files
from typing import Any, Protocol

from jinja2 import Environment as Templates
from plotly.offline import get_plotlyjs
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, Response, StreamingResponse
from starlette.routing import Route

from coevo_manager.core.evolution.fields import all_fields
from coevo_manager.core.species import COLOURS, SPECIES
from coevo_manager.dashboard.charts import BY_RUN, run_charts
from coevo_manager.dashboard.guard import Guard
from coevo_manager.dashboard.library import Library
from coevo_manager.dashboard.plays import Plays, individual, watch_view
from coevo_manager.dashboard.watched import WatchedRun

PERIOD = 1.0
"""How often a page hears of its runs, s, ..."""

FRAME_PERIOD = 0.1
"""... and of robots."""

MOST_COMPARED = 50
"""Runs in one chart."""

MOST_BYTES = 2**16
"""Of a command."""

_KINDS = {'.js': 'text/javascript', '.css': 'text/css'}
_SHARED = ('charts.js', 'charts.css', 'arena.js', 'player.js', 'player.css')
_OWN = ('dashboard.js', 'dashboard.css', 'runs.js', 'watch.js', 'robots.js')


class Robots(Protocol):
    """Robots that run now."""

    def frame(self) -> dict[str, Any]:
        """Return what they and their arena do, ready for JSON; the same one until it changes."""
        ...

    def order(self, command: str, values: dict[str, Any]) -> str:
        """Ask a service of theirs; returns '' or, in a sentence, why it was not done."""
        ...


def make_app(
    library: Library,
    robots: Robots | None,
    hosts: frozenset[str] | None,
    token: str,
    stopping: Callable[[], bool],
) -> Starlette:
    """Make the application.

    Parameters
    ----------
    library : Library
    robots : Robots, optional
        Shown on a page of their own.
    hosts, token
        As for `Guard`.
    stopping : callable
        Whether the server is about to end; streams then end too.
    """
    dashboard = _Dashboard(library, robots, stopping)
    routes = [
        Route('/', dashboard.page),
        Route('/assets/{name}', dashboard.asset),
        Route('/events', dashboard.events),
        Route('/charts', dashboard.charts),
        Route('/watch', dashboard.watch),
        Route('/runs/{key}/episode', dashboard.episode),
        Route('/runs/{key}/tournament', dashboard.tournament),
    ]
    if robots is not None:
        routes += [
            Route('/robots/frames', dashboard.frames),
            Route('/robots/{command}', dashboard.order, methods=['POST']),
        ]
    return Starlette(
        routes=routes,
        middleware=[Middleware(Guard, hosts=hosts, token=token)],
        exception_handlers={ValueError: _tell_problem},
    )


def _tell_problem(request: Request, error: Exception) -> Response:
    return JSONResponse({'problem': str(error)}, 409)


class _Dashboard:
    def __init__(
        self, library: Library, robots: Robots | None, stopping: Callable[[], bool]
    ) -> None:
        self._library = library
        self._robots = robots
        self._stopping = stopping
        self._plays = Plays()
        own = files('coevo_manager.dashboard') / 'assets'
        shared = files('coevo_manager.analysis.report') / 'assets'
        self._assets = {name: (shared / name).read_text('utf-8') for name in _SHARED}
        self._assets |= {name: (own / name).read_text('utf-8') for name in _OWN}
        self._assets['plotly.js'] = get_plotlyjs()
        template = (own / 'dashboard.html').read_text('utf-8')
        self._page = Templates(autoescape=True).from_string(template)

    async def page(self, request: Request) -> Response:
        fields = {name: option.help for name, option in all_fields().items()}
        text = self._page.render(colours=COLOURS, fields=fields, robots=self._robots is not None)
        return HTMLResponse(text)

    async def asset(self, request: Request) -> Response:
        name = request.path_params['name']
        if name not in self._assets:
            raise HTTPException(404)
        kind = _KINDS[name[name.rindex('.') :]]
        return Response(self._assets[name], media_type=kind)

    async def events(self, request: Request) -> Response:
        """Stream the summaries of runs: all of them first, then those that have changed."""

        async def stream() -> AsyncIterator[str]:
            sent: tuple[dict[str, Any], list[str]] | None = None
            while not self._stopping():
                found = await run_in_threadpool(self._library.look)
                problems = self._library.problems
                if (found, problems) != sent:
                    known = sent[0] if sent else {}
                    news = [run for key, run in found.items() if known.get(key) != run]
                    yield _event({'runs': news, 'keys': list(found), 'problems': problems})
                    sent = found, problems
                await asyncio.sleep(PERIOD)

        return StreamingResponse(stream(), media_type='text/event-stream')

    async def charts(self, request: Request) -> Response:
        keys = request.query_params.get('runs', '').split(',')[:MOST_COMPARED]
        runs = [run for run in map(self._library.run, keys) if run is not None]
        field = request.query_params.get('by', BY_RUN)
        if field not in all_fields():
            field = BY_RUN
        return JSONResponse(await run_in_threadpool(run_charts, runs, field))

    async def watch(self, request: Request) -> Response:
        """Return the runs whose individuals can meet."""
        found = map(self._library.run, await run_in_threadpool(self._library.look))
        return JSONResponse([watch_view(run) for run in found if run and run.snapshots])

    async def episode(self, request: Request) -> Response:
        given = request.query_params
        pair = [(given.get(s, ''), given.get(f'{s}_rank', '')) for s in SPECIES]
        return JSONResponse(
            await run_in_threadpool(self._plays.episode, self._run(request), *pair)
        )

    async def tournament(self, request: Request) -> Response:
        return JSONResponse(await run_in_threadpool(self._plays.tournament, self._run(request)))

    def _run(self, request: Request) -> WatchedRun:
        run = self._library.run(request.path_params['key'])
        if run is None:
            raise HTTPException(404)
        return run

    async def frames(self, request: Request) -> Response:
        """Stream what the robots do."""
        assert self._robots is not None
        robots = self._robots

        async def stream() -> AsyncIterator[str]:
            sent: dict[str, Any] | None = None
            while not self._stopping():
                frame = robots.frame()
                if frame is not sent:
                    yield _event(frame)
                    sent = frame
                await asyncio.sleep(FRAME_PERIOD)

        return StreamingResponse(stream(), media_type='text/event-stream')

    async def order(self, request: Request) -> Response:
        assert self._robots is not None
        values = await _json_body(request)
        command = request.path_params['command']
        if command == 'genome':
            values = await run_in_threadpool(self._genome, values)
        problem = await run_in_threadpool(self._robots.order, command, values)
        return JSONResponse({'problem': problem}, 409 if problem else 200)

    def _genome(self, values: dict[str, Any]) -> dict[str, Any]:
        """Return the genome of an individual that was chosen, and what it evolved with."""
        species = values.get('species')
        run = self._library.run(str(values.get('run')))
        if run is None or species not in SPECIES:
            raise HTTPException(404)
        genome = individual(run, species, str(values.get('generation')), str(values.get('rank')))
        speed = run.environment.max_wheel_speeds[SPECIES.index(species)]
        settings = {'max_wheel_speed': float(speed), **run.environment.network_settings}
        return {'species': species, 'parameters': {'genome': genome.tolist(), **settings}}


async def _json_body(request: Request) -> dict[str, Any]:
    content = b''
    async for part in request.stream():
        content += part
        if len(content) > MOST_BYTES:
            raise HTTPException(413)
    try:
        values = json.loads(content or b'{}')
    except ValueError:
        raise HTTPException(400) from None
    if not isinstance(values, dict):
        raise HTTPException(400)
    return values


def _event(content: Any) -> str:
    return f'data: {json.dumps(content, separators=(",", ":"))}\n\n'
