"""Who may ask the dashboard: this machine's own pages, or whoever has the token."""

from __future__ import annotations

import secrets
from http.cookies import SimpleCookie
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders, QueryParams
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

POLICY = (
    "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
)
"""No script, style or picture comes from elsewhere; charts set the style of their elements."""


class Guard:
    """Lets requests through that are meant for this server and come from its own pages.

    Parameters
    ----------
    app : ASGI application
    hosts : set of str, optional
        Names, each with the port, under which the server may be asked; any where it is None. This
        keeps out pages whose name was made to point here (DNS rebinding).
    token : str
        Without it nobody is answered; '' where none is wanted. It is given once, in the address,
        and kept as a cookie.
    """

    def __init__(self, app: ASGIApp, hosts: frozenset[str] | None, token: str) -> None:
        self._app = app
        self._hosts = hosts
        self._token = token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or pass it on."""
        if scope['type'] == 'lifespan':
            await self._app(scope, receive, send)
            return

        async def careful(message: Message) -> None:
            if message['type'] == 'http.response.start':
                headers = MutableHeaders(scope=message)
                headers['Content-Security-Policy'] = POLICY
                headers['X-Content-Type-Options'] = 'nosniff'
                headers['Referrer-Policy'] = 'no-referrer'
                headers['Cross-Origin-Resource-Policy'] = 'same-origin'
                headers['Cache-Control'] = 'no-store'
            await send(message)

        refusal = self._refusal(scope)
        await (refusal or self._app)(scope, receive, careful)

    def _refusal(self, scope: Scope) -> Response | None:
        if scope['type'] != 'http':
            return PlainTextResponse('only HTTP is spoken here', 400)
        headers = Headers(scope=scope)
        host = headers.get('host', '')
        if self._hosts is not None and host not in self._hosts:
            return PlainTextResponse(f'this is no server of the name {host[:100]!r}', 421)
        origin = headers.get('origin')
        if origin is not None and urlsplit(origin).netloc != host:
            return PlainTextResponse('pages of other servers are not answered', 403)
        if scope['method'] not in ('GET', 'HEAD'):
            if headers.get('sec-fetch-site', 'same-origin') != 'same-origin':
                return PlainTextResponse('pages of other servers are not answered', 403)
            if headers.get('content-type') != 'application/json':
                return PlainTextResponse('commands are JSON', 415)
        return self._token_refusal(scope, headers)

    def _token_refusal(self, scope: Scope, headers: Headers) -> Response | None:
        if not self._token:
            return None
        name = f'red_queen_{(scope.get("server") or ("", 0))[1]}'
        given = QueryParams(scope['query_string']).get('token')
        if given is not None and self._same(given):
            answer = RedirectResponse('/', 303)
            answer.set_cookie(name, self._token, httponly=True, samesite='strict')
            return answer
        cookie = SimpleCookie(headers.get('cookie', '')).get(name)
        if cookie is not None and self._same(cookie.value):
            return None
        return PlainTextResponse('the token is missing or wrong; the dashboard printed it', 401)

    def _same(self, given: str) -> bool:
        return secrets.compare_digest(given.encode(), self._token.encode())
