"""The pytest plugin: fixtures `tumble_stand`, `tumble_node` and `tumble_client` (docs/client.md).

Where the package is installed, pytest finds it by itself; in a checkout: pytest -p tumble.testing.plugin. It loads
nothing before one of its fixtures or options is used.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, closing
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from pathlib import Path

    from tumble.client import Node as Client
    from tumble.testing.rigs import Node, Rig, Stand

_VIRTUAL, _UML, _CAN, _INSIDE = "virtual", "uml", "can:", "can:vcan0"


def pytest_addoption(parser: pytest.Parser) -> None:
    """--tumble-bus, and tumble_bus of the ini file."""
    about = "where tumble_stand, tumble_node and tumble_client are: virtual (the default: in one process, in virtual \
time), can:INTERFACE, or uml (the whole session in user-mode Linux)"
    parser.getgroup("tumble").addoption("--tumble-bus", metavar="WHERE", help=about)
    parser.addini("tumble_bus", about, default=_VIRTUAL)


def pytest_configure(config: pytest.Config) -> None:
    """The marker, and what is no bus."""
    config.addinivalue_line(
        "markers", "tumble(operator=, seed=, scenario=, memory=, **keys): what the stand and the node are like"
    )
    where = _where(config)
    if where not in (_VIRTUAL, _UML) and not (where.startswith(_CAN) and where != _CAN):
        raise pytest.UsageError(f"--tumble-bus: {where!r} is not virtual, uml, or can: and the name of an interface")


def _where(config: pytest.Config) -> str:
    return str(config.getoption("tumble_bus") or config.getini("tumble_bus"))


@pytest.hookimpl(tryfirst=True)
def pytest_cmdline_main(config: pytest.Config) -> int | None:
    """With uml the same command runs inside, on the interface there."""
    if _where(config) != _UML:
        return None
    import sys

    from tumble.errors import TumbleError
    from tumble.world import uml

    try:
        words = [sys.executable, "-m", "pytest", *map(str, config.invocation_params.args)]
        return uml.run_command([*words, f"--tumble-bus={_INSIDE}"])
    except TumbleError as error:
        print(f"--tumble-bus=uml: {error}", file=sys.stderr)
        return error.exit_code


@pytest.fixture
def _tumble_rig(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Rig]:
    """Stand and node as the test's marker has them."""
    from tumble.errors import TumbleError
    from tumble.testing import rigs

    marker = request.node.get_closest_marker("tumble")
    where = _where(request.config)
    with ExitStack() as stack:
        try:
            wanted = rigs.Wanted(*marker.args, **marker.kwargs) if marker else rigs.Wanted()
            made = rigs.virtual(wanted, tmp_path) if where == _VIRTUAL else rigs.on_can(wanted, tmp_path, where)
            rig = stack.enter_context(made)
        except TumbleError as error:
            pytest.fail(str(error), pytrace=False)
        yield rig


@pytest.fixture
def tumble_stand(_tumble_rig: Rig) -> Stand:
    """The simulated stand: drive, block, and who mounts the block. `end()` gives its document, with the truth."""
    return _tumble_rig.stand


@pytest.fixture
def tumble_node(_tumble_rig: Rig) -> Node:
    """The navigation computer. `link`: what tumble.client.connect takes; `end()` gives its document."""
    return _tumble_rig.node


@pytest.fixture
def tumble_client(tumble_node: Node) -> Iterator[Client]:
    """A client of it, as tumble.client.connect gives it."""
    from tumble import client

    with closing(client.connect(tumble_node.link)) as connected:
        yield connected
