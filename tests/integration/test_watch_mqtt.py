"""tumble watch --mqtt: what Mosquitto's own client gets from Mosquitto, in the clear and by TLS, and a broker that goes
and comes back."""

import json
import shutil
import socket
import subprocess
import sys
from contextlib import contextmanager

import pytest
from played_run import AVERAGING, DONE, FAULT

from tumble.errors import UsageError
from tumble.watch.snapshot import View, document

pytest.importorskip("paho.mqtt.client", reason="paho-mqtt is not installed")

from tumble.watch.mqtt import Publisher

pytestmark = [
    pytest.mark.python,
    pytest.mark.skipif(not shutil.which("mosquitto_sub"), reason="mosquitto-clients is not installed"),
]
BROKER = shutil.which("mosquitto", path="/usr/sbin:/usr/local/sbin:/usr/bin")
TOPIC = "lab 1/tumble"
VIEWS = [View("bench", number, 1e9 + number, shown) for number, shown in enumerate((AVERAGING, FAULT, DONE))]


@contextmanager
def broker(folder, port, *settings):
    """Mosquitto on this port, ready."""
    if BROKER is None:
        pytest.skip("mosquitto is not installed")
    (folder / "mosquitto.conf").write_text("\n".join([f"listener {port} 127.0.0.1", "user root", *settings, ""]))
    command = [BROKER, "-c", str(folder / "mosquitto.conf")]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as one:
        said = iter(one.stderr.readline, "")
        assert any(line.rstrip().endswith(" running") for line in said), "mosquitto did not start"
        try:
            yield
        finally:
            one.terminate()


@contextmanager
def subscribed(port, *options):
    """What comes, as (retained, document), one by one."""
    command = ["mosquitto_sub", "-h", "127.0.0.1", "-p", str(port), "-t", TOPIC, "-F", "%r %x", *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as one:
        lines = (line.split() for line in one.stdout)
        try:
            yield ((retained == "1", json.loads(bytes.fromhex(data))) for retained, data in lines)
        finally:
            one.terminate()


@pytest.fixture
def port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def test_every_change_comes_and_the_newest_stays(tmp_path, port):
    url = f"mqtt://127.0.0.1:{port}/lab%201/tumble"
    with broker(tmp_path, port, "allow_anonymous true"):
        with Publisher(url) as publish:
            publish(VIEWS[0])
            with subscribed(port) as messages:
                assert next(messages)[1] == document(VIEWS[0])  # as it was told, or a moment later, as it is kept
                for view in VIEWS[1:]:
                    publish(view)
                    assert next(messages) == (False, document(view))
        with subscribed(port) as messages:
            assert next(messages) == (True, document(VIEWS[-1]))


def test_a_broker_that_goes_gets_the_newest_when_it_is_back(tmp_path, port, capfd):
    settings = ["allow_anonymous true"]
    with Publisher(f"mqtt://127.0.0.1:{port}/lab%201/tumble") as publish:
        publish(VIEWS[0])
        with broker(tmp_path, port, *settings), subscribed(port) as messages:
            assert next(messages)[1] == document(VIEWS[0])
        publish(VIEWS[1])
        publish(VIEWS[2])
        with broker(tmp_path, port, *settings), subscribed(port) as messages:
            assert next(messages)[1] == document(VIEWS[2])
    place = f"tumble: mqtt://127.0.0.1:{port}: "
    told = [line for line in capfd.readouterr().err.splitlines() if line.startswith("tumble: ")]
    causes = "no connection", "unspecified error"
    assert set(told) <= {f"{place}{why}; tried again until it answers" for why in causes}
    assert 1 <= len(told) <= 3  # once each time that it is gone: before, between and after


def test_user_and_password_of_the_url_and_of_the_environment(tmp_path, port, monkeypatch, capfd):
    subprocess.run(["mosquitto_passwd", "-b", "-c", str(tmp_path / "users"), "me", "a:b@c/d"], check=True)
    with broker(tmp_path, port, "allow_anonymous false", f"password_file {tmp_path}/users"):
        known = ["-u", "me", "-P", "a:b@c/d"]
        with subscribed(port, *known) as messages:
            with Publisher(f"mqtt://me:a%3Ab%40c%2Fd@127.0.0.1:{port}/lab%201/tumble") as publish:
                publish(VIEWS[0])
                assert next(messages)[1] == document(VIEWS[0])
            monkeypatch.setenv("TUMBLE_MQTT_USER", "me")
            monkeypatch.setenv("TUMBLE_MQTT_PASSWORD", "a:b@c/d")
            with Publisher(f"mqtt://127.0.0.1:{port}/lab%201/tumble") as publish:
                publish(VIEWS[1])
                assert next(messages)[1] == document(VIEWS[1])
        monkeypatch.setenv("TUMBLE_MQTT_PASSWORD", "wrong")
        capfd.readouterr()
        with Publisher(f"mqtt://127.0.0.1:{port}/lab%201/tumble") as publish:
            wait_for_a_line(capfd, f"tumble: mqtt://127.0.0.1:{port}: not authorized; tried again until it answers\n")
            publish(VIEWS[2])


def wait_for_a_line(capfd, expected):
    said = ""
    while not said.endswith("answers\n"):
        said += capfd.readouterr().err
    assert said.splitlines(keepends=True)[-1] == expected


@pytest.mark.skipif(not shutil.which("openssl"), reason="openssl is not installed")
def test_tls_holds_the_certificate_against_those_that_are_trusted(tmp_path, port, monkeypatch):
    names = ["-subj", "/CN=127.0.0.1", "-addext", "subjectAltName=IP:127.0.0.1"]
    own = ["-keyout", tmp_path / "key.pem", "-out", tmp_path / "cert.pem", "-days", "2"]
    subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", *own,
                    *names], check=True, capture_output=True)  # fmt: skip
    settings = ["allow_anonymous true", f"certfile {tmp_path}/cert.pem", f"keyfile {tmp_path}/key.pem"]
    url = f"mqtts://127.0.0.1:{port}/lab%201/tumble"
    with broker(tmp_path, port, *settings):
        trusting = ["--cafile", str(tmp_path / "cert.pem")]
        with subscribed(port, *trusting) as messages:
            with Publisher(url) as publish:  # nobody trusts it: nothing is told
                publish(VIEWS[0])
            monkeypatch.setenv("SSL_CERT_FILE", str(tmp_path / "cert.pem"))
            with Publisher(url) as publish:
                publish(VIEWS[1])
                assert next(messages)[1] == document(VIEWS[1])


def test_a_watch_publishes_to_its_end(tmp_path, port):
    """The command itself, which does not wait for a broker that is not there."""
    command = [sys.executable, "-m", "tumble", "watch", "bench", "--pace", "1e6", "--out", str(tmp_path / "run")]
    url = f"mqtt://127.0.0.1:{port}/lab%201/tumble"
    with broker(tmp_path, port, "allow_anonymous true"):
        done = subprocess.run([*command, "--mqtt", url], capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, done.stderr
        with subscribed(port) as messages:
            retained, told = next(messages)
    result = json.loads((tmp_path / "run/result.json").read_text())
    assert retained and told["snapshot"]["over"] and told["snapshot"]["state"] == "DONE"
    assert told["snapshot"]["k_v_per_g"] == result["K"] and told["source"] == "bench"
    alone = subprocess.run([*command[:-1], str(tmp_path / "again"), "--mqtt", url], capture_output=True, text=True)
    assert alone.returncode == 0
    assert alone.stderr.count(f"tumble: mqtt://127.0.0.1:{port}: no connection; tried again until it answers\n") == 1


@pytest.mark.parametrize(
    "url",
    ["localhost", "http://h/t", "mqtt://h", "mqtt:///t", "mqtt://h/", "mqtt://h:0x/t", "mqtt://h/a/%23", "mqtt://h/+"],
)
def test_what_is_no_address_is_refused(url):
    with pytest.raises(UsageError) as refused:
        Publisher(url)
    assert str(refused.value) == f"--mqtt: '{url}' is not mqtt://HOST[:PORT]/TOPIC, or mqtts:// for TLS"


def test_a_refusal_does_not_show_the_password():
    with pytest.raises(UsageError) as refused:
        Publisher("mqtt://me:secret@h/")
    assert "secret" not in str(refused.value) and "mqtt://h/" in str(refused.value)


def test_without_the_package_one_line_says_so():
    code = ("import sys; sys.modules['paho'] = None; from tumble.cli.main import main; "
            "sys.exit(main(['watch', 'bench', '--mqtt', 'mqtt://h/t']))")  # fmt: skip
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == 77 and done.stdout == ""
    assert done.stderr.startswith("tumble: --mqtt needs paho-mqtt: ") and done.stderr.endswith("install paho-mqtt\n")
