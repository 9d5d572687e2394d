"""The board zcu102 in its emulator: what it needs, and how it is started."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

from tumble.errors import BenchFault, Skipped, set_up
from tumble.world.programs import built, last_words

PACKAGES = "qemu-system-arm gcc-aarch64-linux-gnu"

_EMULATOR = "qemu-system-aarch64"
_IMAGES = "../zcu102/boards/zcu102"  # beside the build tree that the extension module is in
_COMMISSIONING_ADDRESS = 0x1800000  # boards/zcu102/configuration.h
_GAINS_ADDRESS = 0x1A00000  # boards/zcu102/gains.c
_RECORDING_ADDRESS = 0x2000000  # boards/zcu102/replay_main.c
_MOST_RECORDING_BYTES = 0x6000000
_PATIENCE_S = 120.0


def image(name: str) -> Path:
    """An image of the board, whether or not it exists; TUMBLE_ZCU102 may name their folder."""
    chosen = os.environ.get("TUMBLE_ZCU102")
    return (Path(chosen) if chosen else built(_IMAGES).resolve()) / f"{name}.elf"


def missing(name: str) -> str | None:
    """What keeps an image from running here, for one line to the user; None: nothing."""
    if shutil.which(_EMULATOR) is None:
        return f"no {_EMULATOR}: install {PACKAGES}"
    if not image(name).exists():
        by = set_up("real") or "tools/setup real of a checkout"
        return f"no image {name}.elf: {by} builds it, with the packages {PACKAGES}"
    return None


def command(name: str, *options: str) -> list[str]:
    """The command that runs an image; its serial port is standard output, its exit code the program's."""
    return [
        _EMULATOR,
        *("-M", "xlnx-zcu102", "-m", "128M", "-accel", "tcg,thread=single,tb-size=32"),
        *("-display", "none", "-monitor", "none", "-serial", "stdio", "-audiodev", "none,id=none"),
        *("-semihosting-config", "enable=on,target=native", "-kernel", str(image(name)), *options),
    ]


def on_interface(interface: str) -> list[str]:
    """Options that join the board's first CAN controller to an interface of Linux."""
    host = f"can-host-socketcan,id=host,if={interface},canbus=wire"
    return ["-object", "can-bus,id=wire", "-machine", "canbus0=wire", "-object", host]


def commissioned(record: Path) -> list[str]:
    """Options that put a commissioning record in its place."""
    return _loaded(record, _COMMISSIONING_ADDRESS)


def weighted(gains: Path | None) -> list[str]:
    """Options that put a gain record in its place; without one none."""
    return [] if gains is None else _loaded(gains, _GAINS_ADDRESS)


def replay(recording: Path, record: Path, gains: Path | None = None) -> dict[str, list[str]]:
    """Let the board, commissioned by `record`, replay a recording. Returns what it tells: words by their line's first.
    Raises Skipped, BenchFault."""
    if (lacking := missing("replay")) is not None:
        raise Skipped(f"--firmware zcu102: {lacking}")
    if recording.stat().st_size > _MOST_RECORDING_BYTES:
        raise BenchFault("this log is longer than the emulated board has memory for")
    loaded = [*commissioned(record), *weighted(gains), *_loaded(recording, _RECORDING_ADDRESS)]
    told = _run(command("replay", *loaded))
    lines = {line.split()[0]: line.split()[1:] for line in told.splitlines() if line.strip()}
    if "end" not in lines:
        raise BenchFault(f"the emulated board did not come to its end: {last_words(told)}")
    return lines


def _loaded(file: Path, address: int) -> list[str]:
    path = str(file).replace(",", ",,")
    return ["-device", f"loader,file={path},addr={address:#x},force-raw=on"]


def _run(arguments: list[str]) -> str:
    try:
        ended = subprocess.run(
            arguments,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=_PATIENCE_S,
            text=True,
            errors="replace",
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise BenchFault(f"the emulated board has not ended after {_PATIENCE_S:.0f} s") from None
    return ended.stdout or ended.stderr
