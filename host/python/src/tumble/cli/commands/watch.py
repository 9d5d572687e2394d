"""`tumble watch`: look on at a run, on the terminal or as a page in a browser, and change nothing."""

from __future__ import annotations

import argparse
import sys
import time
from contextlib import ExitStack
from typing import TYPE_CHECKING, NamedTuple, TextIO

from tumble import interruption
from tumble.cli import options
from tumble.cli.commands import bench
from tumble.errors import EXIT_PASS, BenchFault, UsageError, needing, quoted
from tumble.messages import tell

if TYPE_CHECKING:
    from collections.abc import Mapping

    from tumble.watch.mqtt import Publisher
    from tumble.watch.runs import Follower
    from tumble.watch.server import HistoryPage
    from tumble.watch.snapshot import Source

_BENCH = "bench"
_HTTP = "127.0.0.1:8402"
_LIMIT_G = "3e-4"  # of the page of a history
_FASTEST_S, _SLOWEST_S = 0.1, 60.0
_PACES = 1e-3, 1e6
_LOOK_S = 0.1


def describe(parser: argparse.ArgumentParser) -> None:
    parser.usage = (
        "%(prog)s [-h] SOURCE [--http [HOST:PORT]] [--metrics] [--mqtt URL]\n"
        "                    [--history FILE|URL] [--every S] [--json]\n"
        "       %(prog)s [-h] bench [--http [HOST:PORT]] [--metrics] [--mqtt URL]\n"
        "                    [--history FILE|URL] [--pace X] [bench options]"
    )
    parser.description = (
        "Follow a run live: state, reason and remedy, table angle, running mean and its standard error,"
        " coefficients, gravity check. It only reads and sends no command."
    )
    parser.epilog = (
        "Exit codes: 0 the run is over; 2 bad usage or input; 3 (--json) the source does not answer; 77 a"
        " package is missing, or this kernel has no CAN; 130 ended by Ctrl-C. Of bench: those of tumble bench."
    )
    parser.add_argument(
        "source",
        metavar="SOURCE",
        help="can:IF: the computer on this CAN interface, can:KIND@CHANNEL on any that python-can knows;"
        " modbus:HOST:PORT or modbus-rtu:DEVICE[,BAUD[,PARITY]]: behind this gateway; bench: a simulated run that"
        " begins now; or the folder of a run",
    )
    parser.add_argument(
        "--http",
        metavar="HOST:PORT",
        nargs="?",
        const=_HTTP,
        help=f"serve a page for browsers instead; default: {_HTTP}, which is for this machine alone; port 0: any",
    )
    parser.add_argument("--metrics", action="store_true", help="of that page: /metrics for Prometheus; implies --http")
    parser.add_argument(
        "--mqtt",
        metavar="URL",
        help="mqtt://[USER:PASSWORD@]HOST[:PORT]/TOPIC, or mqtts:// for TLS: publish every change there as JSON;"
        " default: user and password of the environment, TUMBLE_MQTT_USER and TUMBLE_MQTT_PASSWORD",
    )
    parser.add_argument(
        "--history",
        metavar="FILE|URL",
        help="of tumble history: on that page /history, when blocks are due, and their charts; implies --http",
    )
    parser.add_argument("--every", metavar="S", default="0.5", help="seconds between two readings; default: 0.5")
    parser.add_argument("--pace", metavar="X", help="of bench: virtual seconds per second; default: 1, as a real stand")
    bench.add_options(parser.add_argument_group("with SOURCE bench"), shows_interactive=False)
    parser.set_defaults(run_command=run)


def run(arguments: argparse.Namespace) -> int:
    """Look on until the run is over, or for ever. Returns the exit code; raises TumbleError."""
    every_s = options.parse_number(arguments.every, "--every", _FASTEST_S, _SLOWEST_S)
    audience = _audience(arguments)
    if arguments.source == _BENCH:
        return _bench(arguments, audience)
    _refuse_options_of_bench(arguments)

    from tumble.watch.node_run import opened

    source = opened(arguments.source)
    if arguments.json:
        return _print_once(source, arguments.source)
    return _follow(source, arguments.source, every_s, audience)


class _Audience(NamedTuple):
    """Who looks on: `address` of a page for browsers (None: the terminal), whether it `has_metrics`, what is
    `publish`ed to, and what makes the page of a `history`."""

    address: tuple[str, int] | None
    has_metrics: bool
    publish: Publisher | None
    history: HistoryPage | None


def _audience(arguments: argparse.Namespace) -> _Audience:
    """Raises UsageError, NotInstalled."""
    is_asked = arguments.metrics or arguments.history is not None
    http = _HTTP if is_asked and arguments.http is None else arguments.http
    address, publish = None if http is None else _address(http), None
    if address is not None:
        with needing("--http", extra="watch"):
            import starlette  # noqa: F401
            import uvicorn  # noqa: F401
    if arguments.metrics:
        with needing("--metrics", "prometheus-client", extra="watch"):
            import prometheus_client  # noqa: F401
    if arguments.mqtt is not None:
        with needing("--mqtt", "paho-mqtt", extra="mqtt"):
            from tumble.watch.mqtt import Publisher
        publish = Publisher(arguments.mqtt)
    history = None if arguments.history is None else _history(arguments.history)
    return _Audience(address, arguments.metrics, publish, history)


def _history(db: str) -> HistoryPage:
    """The page of a history by what its address asks: one block `serial`, another `limit`. Raises TumbleError for a
    history that cannot be read."""
    from tumble.documents.labels import iso
    from tumble.history import History
    from tumble.report import history
    from tumble.report.make import HTML, require_installed

    require_installed(HTML)

    def page(query: Mapping[str, str]) -> str:
        limit_g = options.parse_number(query.get("limit", _LIMIT_G), "limit", options.ABOVE_0, 1.0, "a number of g")
        serial = query.get("serial")
        with History(db) as blocks:
            return history.page(blocks.trend(serial), blocks.due(limit_g, serial), iso(time.time())[:10])

    page({})
    return page


def _address(text: str) -> tuple[str, int]:
    """Host and port. Raises UsageError."""
    host, _, port = text.rpartition(":")
    if not host or not port.isascii() or not port.isdigit() or int(port) > 65535:
        raise UsageError(f"--http: {quoted(text)} is not HOST:PORT, such as {_HTTP}; SOURCE comes before --http")
    return host.removeprefix("[").removesuffix("]"), int(port)


def _refuse_options_of_bench(arguments: argparse.Namespace) -> None:
    """Raises UsageError for an option that only a simulated run has."""
    usual = argparse.ArgumentParser(add_help=False)
    bench.add_options(usual)
    unasked = usual.parse_args([])
    options.choose_estimator(unasked)
    for name, value in vars(unasked).items():
        if name != "json" and getattr(arguments, name) != value:
            raise UsageError(f"--{name.replace('_', '-')} is of SOURCE bench alone")
    if arguments.pace is not None:
        raise UsageError("--pace is of SOURCE bench alone")


def _print_once(source: Source, name: str) -> int:
    from tumble.documents.base import to_json
    from tumble.watch.runs import Follower
    from tumble.watch.snapshot import document

    view = Follower(source, name, 1.0).ask()
    source.close()
    if view.lost_since is not None:
        raise BenchFault(f"{name}: {view.why}")
    sys.stdout.write(to_json(document(view)))
    return EXIT_PASS


def _follow(source: Source, name: str, every_s: float, audience: _Audience) -> int:
    """Until nothing more will come; with a page, until Ctrl-C."""
    with ExitStack() as stack:
        follower = _shown(stack, source, name, every_s, audience, sys.stdout)
        while not follower.is_over() or audience.address is not None:
            time.sleep(_LOOK_S)
    return EXIT_PASS


def _bench(arguments: argparse.Namespace, audience: _Audience) -> int:
    """A run of the bench. Its end stays on the page until Ctrl-C; a screen ends before the result is printed."""
    from tumble.watch.runs import BenchRun

    source, address = BenchRun(_pace(arguments)), audience.address
    with ExitStack() as stack:
        follower = _shown(stack, source, _BENCH, _LOOK_S, audience, sys.stderr)

        def end() -> None:
            follower.ask()
            stack.close()

        source.when_over = follower.ask if address is not None else end
        try:
            code = bench.run(arguments, source)
        except BenchFault as error:
            source.failed(str(error))
            if address is None:
                raise
            tell(f"tumble: {error}")
            code = error.exit_code
        if address is not None:
            _until_interrupted()
    return code


def _pace(arguments: argparse.Namespace) -> float:
    from tumble.world import realbus

    if arguments.interactive:
        raise UsageError("--interactive: who watches commands nothing; tumble bench --interactive asks")
    if arguments.pace is not None and arguments.bus != realbus.INPROCESS:
        raise UsageError("--pace: on a real bus a run goes in real time")
    return 1.0 if arguments.pace is None else options.parse_number(arguments.pace, "--pace", *_PACES)


def _until_interrupted() -> None:
    """The run is over, so the first signal ends this in good order. No lock is waited for: a signal
    comes within any call of this thread, and a lock that it holds then would never be free."""
    with interruption.instead(lambda: None):
        interruption.heed_again()
        tell("tumble: the run is over; the page stays until Ctrl-C")
        while not interruption.has_come():
            time.sleep(_LOOK_S)


def _shown(
    stack: ExitStack, source: Source, name: str, every_s: float, audience: _Audience, stream: TextIO | None
) -> Follower:
    """Follow a source and show it until the stack is closed: as a page, on the terminal `stream`, or in lines on it;
    and publish it."""
    from tumble.watch.runs import Follower

    told = [] if audience.publish is None else [stack.enter_context(audience.publish)]
    if audience.address is not None:
        from tumble.watch.server import Server

        follower = Follower(source, name, every_s, on_change=told)
        server = stack.enter_context(Server(follower.view, *audience.address, audience.has_metrics, audience.history))
        tell(f"tumble: {server.url} (Ctrl-C ends it)")
        if server.open_to_others:
            tell("tumble: warning: anyone who reaches this address can read the page; there is no password")
    else:
        from tumble.watch import terminal

        lines = terminal.Lines(stream) if stream is None or not stream.isatty() else None
        follower = Follower(source, name, every_s, on_change=[*told, *filter(None, [lines])])
        if lines is None:
            stack.enter_context(terminal.Screen(follower.view, stream))
    stack.enter_context(follower)
    return follower
