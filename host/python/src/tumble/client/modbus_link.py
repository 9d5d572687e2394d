"""The link over Modbus: pymodbus and the register map of docs/modbus.csv, through tumble-gateway."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from tumble.client import names
from tumble.client.errors import DEVICE_STATE, NO_SUCH_OBJECT, OUT_OF_RANGE, READ_ONLY, CommunicationError, Refused
from tumble.client.link import Link, Value
from tumble.client.registers import Register, finest, read_map, requests
from tumble.errors import NotInstalled, Skipped

EXTRA = "client"
MAGIC, KNOWN = 0x54554D42, 123456.0
KEYS = [0x4F50, 0x454E]
ANSWERS_AT_LAST_S = 10.0  # for a snapshot, or the result of a command
NODE_IS_UP_S = 3.0
LOOK_AGAIN_S = 0.005
TIMES_READ = 5  # until what took several requests is of one snapshot
ACCEPTED, REFUSED, UNANSWERED, UNFIT, LEVEL = 2, 3, 4, 5, 6
UP = 1
LINK = {0: "nothing was heard of the node yet", 2: "the node is silent", 3: "the bus is down"}
_BUSY = 6
_EXCEPTIONS = {1: "1: it takes no commands unless started with --allow-commands", 11: "11: node 1 is silent"}
_LOCKED = "; the service level is not open: unlock() opens it"


class ModbusLink(Link):
    """Node 1 as the gateway's snapshots have it; commands and settings by its staging registers. `client`: of
    pymodbus, not connected yet; `unit`: of the gateway."""

    def __init__(self, client: Any, unit: int = 1):
        self._client, self._unit, self._map = client, unit, read_map()
        self._executed = 0
        self._old: int | None = None  # the snapshot that was there when something was executed last
        if not client.connect():
            raise CommunicationError("the gateway cannot be reached")
        self._require_order()
        self._wait_for_the_node()
        self.fresh()

    @classmethod
    def tcp(cls, host: str, port: int, unit: int = 1) -> ModbusLink:
        """Over TCP. Raises NotInstalled, CommunicationError."""
        return cls(_pymodbus().ModbusTcpClient(host, port=port, timeout=5, retries=0), unit)

    @classmethod
    def rtu(cls, device: str, baud: int, parity: str, unit: int = 1) -> ModbusLink:
        """Over a serial line. Raises NotInstalled, Skipped without pyserial, CommunicationError."""
        try:
            client = _pymodbus().ModbusSerialClient(device, baudrate=baud, parity=parity, timeout=2, retries=1)
        except RuntimeError as error:  # pyserial is missing
            raise Skipped(f"modbus-rtu:{device}: {error}") from None
        return cls(client, unit)

    def has(self, name: str) -> bool:
        return name in self._map.input

    def step(self, name: str, value: float) -> float:
        return min(register.step(value) for register in self._registers(name))

    def _registers(self, name: str) -> list[Register]:
        if not self.has(name):
            raise Refused(f"reading {name}", NO_SUCH_OBJECT)
        return self._map.input[name]

    def _require_order(self) -> None:
        magic, known = self._own("Magic word"), self._own("Known number")
        if (magic, known) != (MAGIC, KNOWN):
            raise CommunicationError(f"this is no tumble-gateway: magic word {magic:#x}, known number {known}")

    def _wait_for_the_node(self) -> None:
        """Gateway or node may have been started just now."""
        end = time.monotonic() + NODE_IS_UP_S
        while self._own("Link state") != UP and time.monotonic() < end:
            time.sleep(LOOK_AGAIN_S)

    def wait_for_news(self) -> None:
        self._wait_for_another_than(self._own("Snapshot number"))

    def _wait_for_another_than(self, before: int | None) -> None:
        end = time.monotonic() + ANSWERS_AT_LAST_S
        while self._own("Snapshot number") == before:
            self._require_link(self._own("Link state"))
            if time.monotonic() > end:
                raise CommunicationError("the gateway takes no new snapshot")
            time.sleep(LOOK_AGAIN_S)

    @staticmethod
    def _require_link(state: int) -> None:
        if state != UP:
            raise CommunicationError(f"the gateway says: {LINK.get(state, state)}")

    def fresh(self) -> None:
        self.wait_for_news()  # was being taken already
        self.wait_for_news()

    def read_together(self, *names: str) -> list[Value]:
        """All of the newest snapshot. Raises Refused, CommunicationError."""
        found = [self._registers(name) for name in names]
        asked = requests([register for registers in found for register in registers])
        for _ in range(TIMES_READ):
            taken = self._take_snapshot()
            words = {at + place: word for at, count in asked for place, word in enumerate(self._input(at, count))}
            if len(asked) == 1 or self._own("Snapshot held") == taken:
                return [finest(registers, words) for registers in found]
        raise CommunicationError("the gateway cannot be read as fast as it takes snapshots")

    def _take_snapshot(self) -> Any:
        """The newest one, read after what was executed last; its number. Raises CommunicationError where it is of a
        node that is silent now."""
        if self._old is not None:
            self._wait_for_another_than(self._old)
            self._old = None
        number, state = self._map.input["Snapshot number"][0], self._map.input["Link state"][0]
        words = self._input(number.at, state.at + state.words - number.at)
        self._require_link(int(state.number(words[state.at - number.at :])))
        return number.number(words[: number.words])

    def _own(self, name: str) -> Any:
        """Of the gateway itself."""
        [register] = self._map.input[name]
        return register.number(self._input(register.at, register.words))

    def _holding(self, name: str) -> Any:
        register = self._map.holding[name]
        read = self._client.read_holding_registers
        return register.number(self._answer(read, register.at, count=register.words).registers)

    def _input(self, at: int, count: int) -> list[int]:
        found: list[int] = self._answer(self._client.read_input_registers, at, count=count).registers
        return found

    def _answer(self, call: Callable[..., Any], *arguments: Any, **options: Any) -> Any:
        """While a command is under way, such as one of which an interrupt kept us from the result, it asks again."""
        end = time.monotonic() + ANSWERS_AT_LAST_S
        while (answer := self._ask(call, *arguments, **options)).isError():
            code = getattr(answer, "exception_code", answer)
            if code != _BUSY or time.monotonic() > end:
                raise CommunicationError(f"the gateway answers with exception {_EXCEPTIONS.get(code, code)}")
            time.sleep(LOOK_AGAIN_S)
        return answer

    def _ask(self, call: Callable[..., Any], *arguments: Any, **options: Any) -> Any:
        from pymodbus.exceptions import ModbusException

        try:
            return call(*arguments, **options, device_id=self._unit)
        except (ModbusException, OSError) as error:
            raise CommunicationError(f"the gateway does not answer: {error}") from None

    def write(self, name: str, value: float) -> None:
        if name not in self._map.settings:
            raise Refused(f"writing {name}", READ_ONLY if self.has(name) else NO_SUCH_OBJECT)
        setting, number = self._map.settings[name], self._map.holding["Value"].pack(value)
        self._execute(f"writing {name}", ("Setting", [setting, *number]), ("Execute", []))

    def command(self, number: int, argument: int = 0, angle_deg: float | None = None, proposal: int = 0) -> None:
        angle = self._map.holding["Angle"].pack(angle_deg or 0.0)
        staged = [("Proposal", self._map.holding["Proposal"].pack(proposal))] if proposal else []
        # A setting that was staged and never executed would go in the command's place.
        words = ("Command object", [0, argument, *angle, number])
        self._execute(names.command(number), ("Setting", [0]), *staged, words)

    def _execute(self, what: str, *written: tuple[str, list[int]]) -> None:
        """Unlock, stage, and execute with a number of its own, which is the last word of all. Raises Refused."""
        self._executed = self._executed % 0x7FFF + 1
        last = written[-1]
        for name, words in [("Unlock key 1", KEYS), *written[:-1], (last[0], [*last[1], self._executed])]:
            self._answer(self._client.write_registers, self._map.holding[name].at, words)
        self._require_obeyed(what)
        self._old = self._own("Snapshot number")

    def _require_obeyed(self, what: str) -> None:
        end = time.monotonic() + ANSWERS_AT_LAST_S
        while (result := self._holding("Result")) not in (ACCEPTED, REFUSED, UNANSWERED, UNFIT, LEVEL):
            if time.monotonic() > end:
                raise CommunicationError(f"the gateway does not say what became of {what}")
            time.sleep(LOOK_AGAIN_S)
        if result == UNANSWERED:
            raise CommunicationError("the node did not answer")
        if result == LEVEL:
            raise Refused(what, DEVICE_STATE, _LOCKED)
        if result != ACCEPTED:
            raise Refused(what, self._holding("Abort code") if result == REFUSED else OUT_OF_RANGE)

    def close(self) -> None:
        self._client.close()


def _pymodbus() -> Any:
    try:
        import pymodbus.client
    except ModuleNotFoundError:
        raise NotInstalled("a gateway", "pymodbus", extra=EXTRA) from None
    return pymodbus.client
