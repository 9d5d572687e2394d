"""The units of the pages, for systemd: it takes them, and they give the programs no more than they need."""

import re
import shutil
import subprocess

import pytest
from conftest import ROOT

UNITS = ("tumble-gateway", "tumble-node")
PAGE = (ROOT / "docs/gateway.md").read_text(encoding="utf-8")
WORST = 16  # of systemd's 0 to 100 for exposure; unhardened they are above 80
WANTED = {
    "CapabilityBoundingSet": "", "DynamicUser": "yes", "NoNewPrivileges": "yes", "ProtectSystem": "strict",
    "ProtectHome": "yes", "PrivateTmp": "yes", "RestrictNamespaces": "yes", "IPAddressDeny": "any",
    "PrivateMounts": "yes", "SystemCallFilter": {"@system-service", "~@privileged @resources"},
}  # fmt: skip
FAMILIES = {"tumble-gateway": {"AF_CAN", "AF_INET", "AF_INET6", "AF_UNIX"}, "tumble-node": {"AF_CAN", "AF_UNIX"}}
needs_systemd = pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd-analyze is not installed")


def unit(name):
    [found] = [block for block in re.findall(r"```ini\n(.*?)```", PAGE, re.DOTALL) if f"/bin/{name} " in block]
    return found


@pytest.fixture
def analyze(tmp_path):
    """systemd-analyze on a unit whose program is one that every machine has."""

    def run(name, text, *arguments):
        path = tmp_path / f"{name}.service"
        path.write_text(re.sub(r"/usr/local/bin/[\w-]+|/sbin/ip", "/bin/true", text))
        return subprocess.run(["systemd-analyze", *arguments, path], capture_output=True, text=True, timeout=60)

    return run


@pytest.mark.parametrize("name", UNITS)
def test_a_unit_has_what_hardens_it_and_no_capability(name):
    pairs = [line.split("=", 1) for line in unit(name).splitlines() if "=" in line]
    settings = dict(pairs) | {"SystemCallFilter": {value for key, value in pairs if key == "SystemCallFilter"}}
    assert {key: settings.get(key) for key in WANTED} == WANTED
    assert set(settings["RestrictAddressFamilies"].split()) == FAMILIES[name]
    assert "AmbientCapabilities" not in settings
    assert settings["ExecStart"].startswith(f"/usr/local/bin/{name} ") and settings["ExecStart"].endswith(" --log text")


def starts(unit_text, tmp_path, times):
    """Whether its ExecStartPre let the program start, so many times, on an interface as the kernel has it: no bit rate
    is taken while it is up, and it does not come up without one."""
    state, ip = tmp_path / "state", tmp_path / "ip"
    state.mkdir()
    ip.write_text(f"""#!/bin/sh
cd {state}
for word; do case $word in bitrate) [ ! -e up ] || exit 2; touch bitrate ;; up) up=1 ;; esac; done
[ -z "$up" ] || {{ [ -e bitrate ] && touch up; }}
""")
    ip.chmod(0o755)

    def start():
        for prefix, command in re.findall(r"^ExecStartPre=([-+]*)(.*)$", unit_text, re.MULTILINE):
            done = subprocess.run(command.replace("/sbin/ip", str(ip)).split(), check=False)
            if done.returncode and "-" not in prefix:
                return False
        return True

    return [start() for _ in range(times)]


def test_the_interface_comes_up_and_the_unit_can_be_started_anew(tmp_path):
    assert starts(unit("tumble-node"), tmp_path, 3) == [True, True, True]


def test_one_command_for_both_would_not_start_anew(tmp_path):
    """Canary: the line that the page had."""
    line = "ExecStartPre=+/sbin/ip link set can0 up type can bitrate 500000 restart-ms 100\n"
    assert starts(line, tmp_path, 2) == [True, False]


@needs_systemd
@pytest.mark.parametrize("name", UNITS)
def test_systemd_takes_the_unit(name, analyze):
    done = analyze(name, unit(name), "verify", "--man=no")
    assert (done.returncode, done.stderr) == (0, "")
    wrong = analyze(name, unit(name).replace("ProtectSystem=", "ProtectSistem="), "verify", "--man=no")
    assert "ProtectSistem" in wrong.stderr


@needs_systemd
@pytest.mark.parametrize("name", UNITS)
def test_systemd_finds_little_exposure(name, analyze):
    options = ("security", "--offline=true", "--no-pager", f"--threshold={WORST}")
    done = analyze(name, unit(name), *options)
    if "unrecognized option" in done.stderr:
        pytest.skip("this systemd-analyze knows no --offline")
    assert done.returncode == 0, done.stdout.splitlines()[-1]
    bare = re.sub(r"^(Cap|IPA|Pro|Priv|Restrict[A-Z]|System|Lock|Memory|NoNew).*\n", "", unit(name), flags=re.MULTILINE)
    assert analyze(name, bare, *options).returncode == 1
