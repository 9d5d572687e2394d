"""The units of the pages, for systemd: it takes them, and they give the programs no more than they need."""

import re
import shutil
import subprocess

import pytest
from conftest import ROOT

UNITS = {"tumble-gateway": "docs/gateway.md", "tumble-node": "docs/real-bus.md"}
WORST = 16  # of systemd's 0 to 100 for exposure; unhardened they are above 80
WANTED = {
    "CapabilityBoundingSet": "", "DynamicUser": "yes", "NoNewPrivileges": "yes", "ProtectSystem": "strict",
    "ProtectHome": "yes", "PrivateTmp": "yes", "RestrictNamespaces": "yes", "IPAddressDeny": "any",
    "PrivateMounts": "yes", "SystemCallFilter": {"@system-service", "~@privileged @resources"},
}  # fmt: skip
FAMILIES = {"tumble-gateway": {"AF_CAN", "AF_INET", "AF_INET6", "AF_UNIX"}, "tumble-node": {"AF_CAN", "AF_UNIX"}}
needs_systemd = pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd-analyze is not installed")


def unit(name):
    return re.search(r"```ini\n(.*?)```", (ROOT / UNITS[name]).read_text(encoding="utf-8"), re.DOTALL)[1]


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
