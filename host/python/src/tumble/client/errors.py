"""What goes wrong between a client and a node. All are `tumble.errors.TumbleError`, and their text is one line."""

from __future__ import annotations

from tumble.client.names import Reason, abort_code
from tumble.errors import BenchFault

NO_SUCH_OBJECT = 0x06020000
NO_SUCH_SUBINDEX = 0x06090011
READ_ONLY = 0x06010002
OUT_OF_RANGE = 0x06090030
NO_DATA = 0x08000024
DEVICE_STATE = 0x08000022
_WORDS = {
    DEVICE_STATE: "the state does not allow it",
    OUT_OF_RANGE: "value out of range",
    0x06090031: "value too high",
    0x06090032: "value too low",
    0x08000020: "not the signature that it wants",
    0x06060000: "the memory failed",
    NO_SUCH_OBJECT: "no such object",
    NO_SUCH_SUBINDEX: "no such object",
    READ_ONLY: "it is read only",
}


class CommunicationError(BenchFault):
    """The node, or the gateway before it, does not answer, or not as one of Tumble's."""


class Refused(BenchFault):
    """The node does not do what it is told. `what` that was; `code`: its SDO abort code, which the text has in words
    where it is a usual one."""

    def __init__(self, what: str, code: int, hint: str = ""):
        self.what, self.code = what, code
        super().__init__(f"{what} was refused: {_WORDS.get(code, 'abort code')} ({abort_code(code)}){hint}")


class RunFailed(BenchFault):
    """The run has stopped. `state`: FAULT, which can be mended and resumed, or ABORT; `reason`: why, and what to do;
    `drive_refusal`: what the drive refused, "" for nothing."""

    def __init__(self, state: str, reason: Reason, drive_refusal: str = ""):
        self.state, self.reason, self.drive_refusal = state, reason, drive_refusal
        super().__init__(f"the run is in {state}: {reason}{drive_refusal and f' ({drive_refusal})'}")


class RunGone(RunFailed):
    """The run that was waited for is no more: the node has restarted, or somebody has begun another. `run`: its number;
    `state`, `reason`: the node's now."""

    def __init__(self, run: int, now: int, state: str, reason: Reason):
        self.run, self.state, self.reason, self.drive_refusal = run, state, reason, ""
        why = "the node has restarted" if now < run else f"run {now} has been begun"
        BenchFault.__init__(self, f"run {run} is gone: {why}; the state is {state}")


class TimedOut(BenchFault, TimeoutError):
    """What was waited for did not come in time. `state`: the last that was seen."""

    def __init__(self, waited_for: str, timeout_s: float, state: str):
        self.state = state
        super().__init__(f"{waited_for} did not come within {timeout_s:g} s; the state is {state}")


class NoResult(BenchFault):
    """The node has no result: no run has been finished since it was switched on, or since the last START."""
