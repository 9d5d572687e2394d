"""The live view as a web page: a small server that sends every change as a server-sent event, and takes no command.

Needs Starlette and uvicorn (`pip install './host/python[watch]'`).
"""

from __future__ import annotations

import asyncio
import base64
import hashlib
import json
import logging
import re
import socket
import threading
from collections.abc import AsyncIterator, Callable, Mapping
from importlib import resources
from urllib.parse import urlsplit

import uvicorn
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.datastructures import Headers
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, PlainTextResponse, Response, StreamingResponse
from starlette.routing import Route
from starlette.types import ASGIApp, Receive, Scope, Send

from tumble.errors import TumbleError, UsageError
from tumble.watch.snapshot import View, document

_LOOK_S = 0.1  # a change is told so late at most
_SIGN_OF_LIFE_S = 5.0  # a comment, so that both ends and what is between them notice a line that is dead
_MOST_CONNECTIONS = 64
_LOOPBACK = ["localhost", "127.0.0.1", "::1"]
HistoryPage = Callable[[Mapping[str, str]], str]  # HTML by the query; raises TumbleError for a bad one


def application(
    view: Callable[[], View],
    ending: Callable[[], bool],
    hosts: list[str] | None,
    has_metrics: bool = False,
    history: HistoryPage | None = None,
) -> Starlette:
    """The pages. `view`: returns the current view. `ending`: set when streams are to end. `hosts`: the host names that
    requests may use (None: any), so that no web page can read it under a name of its own (DNS rebinding).
    `has_metrics`: serve /metrics to Prometheus, too. `history`: makes the page /history."""
    page = resources.files("tumble.watch").joinpath("page.html").read_text(encoding="utf-8")
    if history is not None:
        page = page.replace("</footer>", '. <a href="history">Calibrations of the blocks</a></footer>')
    headers = {"Content-Security-Policy": _policy(page), **_HEADERS}

    async def index(_: Request) -> Response:
        return HTMLResponse(page, headers=headers)

    async def snapshot(_: Request) -> Response:
        return JSONResponse(document(view()), headers=_HEADERS)

    async def events(request: Request) -> Response:
        if request.method == "HEAD":  # a stream without a body would never end
            return Response(media_type="text/event-stream", headers=_HEADERS)
        return StreamingResponse(_changes(view, ending), media_type="text/event-stream", headers=_HEADERS)

    async def icon(_: Request) -> Response:
        return Response(status_code=204, headers=_HEADERS)  # a browser asks, and tells its console where there is none

    routes = [
        Route("/", index),
        Route("/favicon.ico", icon),
        Route("/snapshot.json", snapshot),
        Route("/events", events),
    ]
    if has_metrics:
        from tumble.watch import metrics

        async def numbers(_: Request) -> Response:
            return Response(metrics.text(view()), media_type=metrics.CONTENT_TYPE, headers=_HEADERS)

        routes.append(Route("/metrics", numbers))
    if history is not None:
        make, one_at_a_time = history, asyncio.Lock()  # of the database and matplotlib

        async def calibrations(request: Request) -> Response:
            try:
                async with one_at_a_time:
                    text = await run_in_threadpool(make, dict(request.query_params))
            except TumbleError as error:
                return PlainTextResponse(f"{error}\n", status_code=400, headers=_HEADERS)
            return HTMLResponse(text, headers={"Content-Security-Policy": _NO_SCRIPT, **_HEADERS})

        routes.append(Route("/history", calibrations))
    return Starlette(routes=routes, middleware=[Middleware(_OwnNames, names=hosts)])


class _OwnNames:
    """Refuse requests under any other host name (None: accept all), in upper or lower case, with or without a port."""

    def __init__(self, app: ASGIApp, names: list[str] | None):
        self._app, self._names = app, names

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        try:
            name = urlsplit("//" + Headers(scope=scope).get("host", "")).hostname
        except ValueError:
            name = None
        if self._names is None or name in self._names:
            await self._app(scope, receive, send)
        else:
            await PlainTextResponse("not one of my names", status_code=400)(scope, receive, send)


_HEADERS = {
    "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
}


_NO_SCRIPT = (
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none';"
    " frame-ancestors 'none'"
)


def _policy(page: str) -> str:
    """The page may run its own script and ask its own server, and nothing else."""
    script = re.search(r"<script>(.*?)</script>", page, re.DOTALL)
    assert script is not None
    digest = base64.b64encode(hashlib.sha256(script[1].encode()).digest()).decode()
    return (
        f"default-src 'none'; script-src 'sha256-{digest}'; style-src 'unsafe-inline'; img-src data:;"
        " connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    )


async def _changes(view: Callable[[], View], ending: Callable[[], bool]) -> AsyncIterator[str]:
    told, silent_s = -1, 0.0
    while not ending():
        now = view()
        if now.number != told:
            told, silent_s = now.number, 0.0
            yield f"id: {now.number}\ndata: {json.dumps(document(now), allow_nan=False)}\n\n"
        elif silent_s >= _SIGN_OF_LIFE_S:
            silent_s = 0.0
            yield ": still there\n\n"
        await asyncio.sleep(_LOOK_S)
        silent_s += _LOOK_S


class Server:
    """Serve in a thread of its own within the `with` block. `server.url`: the address. Raises UsageError where it
    cannot listen."""

    def __init__(
        self,
        view: Callable[[], View],
        host: str,
        port: int,
        has_metrics: bool = False,
        history: HistoryPage | None = None,
    ):
        self._socket = _listening(host, port)
        address, port = self._socket.getsockname()[:2]
        shown = f"[{address}]" if ":" in address else address
        self.url = f"http://{shown}:{port}/"
        self.open_to_others = address not in _LOOPBACK and not address.startswith("127.")
        hosts = None if self.open_to_others else [*_LOOPBACK, address]
        pages = application(view, lambda: self._server.should_exit, hosts, has_metrics, history)
        config = uvicorn.Config(
            pages,
            log_config=None,
            access_log=False,
            lifespan="off",
            ws="none",
            server_header=False,
            limit_concurrency=_MOST_CONNECTIONS + 1,  # at which it refuses
            timeout_graceful_shutdown=2,
        )
        logging.getLogger("uvicorn").addHandler(logging.NullHandler())  # a line for each bad request that others send
        self._server = uvicorn.Server(config)
        self._thread = threading.Thread(target=self._server.run, args=([self._socket],), daemon=True)

    def __enter__(self) -> Server:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._server.should_exit = True
        self._thread.join()
        self._socket.close()


def _listening(host: str, port: int) -> socket.socket:
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        found = socket.socket(family, kind, protocol)
    except (OSError, UnicodeError) as error:
        raise UsageError(f"--http: {host}: {_words(error)}") from None
    try:
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        found.bind(address)
        found.listen(_MOST_CONNECTIONS)
        return found
    except OSError as error:
        found.close()
        raise UsageError(f"--http: cannot listen on {host} port {port}: {_words(error)}") from None


def _words(error: Exception) -> str:
    return (getattr(error, "strerror", None) or str(error)).lower()
