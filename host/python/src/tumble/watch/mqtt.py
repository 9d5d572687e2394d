"""Tells a broker of MQTT every change of a run, as JSON of schema tumble.watch/1. Nothing is subscribed to.

Needs paho-mqtt.
"""

from __future__ import annotations

import os
from contextlib import suppress
from typing import Any
from urllib.parse import unquote, urlsplit

import paho.mqtt.client as paho
from paho.mqtt.enums import CallbackAPIVersion

from tumble.documents.base import to_json
from tumble.errors import UsageError, quoted
from tumble.messages import tell
from tumble.watch.snapshot import View, document

USER, PASSWORD = "TUMBLE_MQTT_USER", "TUMBLE_MQTT_PASSWORD"  # of the environment, where the URL has none
_PORTS = {"mqtt": 1883, "mqtts": 8883}
_SLOWEST_S = 30  # between two tries
_LAST_S = 5.0  # that the last message may take


class Publisher:
    """`with Publisher(url) as publish:` tells the broker each view that `publish(view)` is given. Who subscribes later
    gets the newest one, for messages are retained. A broker that is gone is told once and tried again; meanwhile
    nothing waits, and it gets the newest view when it is back. Raises UsageError for what is no such URL."""

    def __init__(self, url: str):
        parts, port = _parsed(url)
        self._topic = unquote(parts.path[1:])
        self._place = f"{parts.scheme}://{parts.hostname}:{port}"  # without the password
        self._newest: str | None = None
        self._sent: paho.MQTTMessageInfo | None = None  # the last message
        self._is_told = False
        self._client = paho.Client(CallbackAPIVersion.VERSION2)
        user, password = unquote(parts.username or ""), unquote(parts.password or "")
        if user := user or os.environ.get(USER, ""):
            self._client.username_pw_set(user, password or os.environ.get(PASSWORD))
        if parts.scheme == "mqtts":
            self._client.tls_set()
        self._client.on_connect = self._connected
        self._client.on_connect_fail = lambda *_: self._lost("no connection")
        self._client.on_disconnect = lambda _client, _data, _flags, reason, _more: self._lost(str(reason).lower())
        self._client.reconnect_delay_set(1, _SLOWEST_S)
        self._client.connect_async(str(parts.hostname), port)

    def __enter__(self) -> Publisher:
        self._client.loop_start()
        return self

    def __exit__(self, *_: object) -> None:
        self._is_told = True  # the end is no loss
        if self._sent is not None:
            with suppress(RuntimeError, ValueError):  # it never left
                self._sent.wait_for_publish(_LAST_S)
        self._client.disconnect()
        self._client.loop_stop()

    def __call__(self, view: View) -> None:
        """Tell this one."""
        self._newest = to_json(document(view))
        if self._client.is_connected():
            self._send(self._newest)

    def _send(self, text: str) -> None:
        # at most once (QoS 0): what a dead line has lost must not come after the newest one
        self._sent = self._client.publish(self._topic, text, qos=0, retain=True)

    def _connected(self, _client: Any, _data: Any, _flags: Any, reason: Any, _properties: Any) -> None:
        if reason.is_failure:
            self._lost(str(reason).lower())
            return
        self._is_told = False
        if self._newest is not None:
            self._send(self._newest)

    def _lost(self, why: str) -> None:
        if not self._is_told:
            self._is_told = True
            tell(f"tumble: {self._place}: {why}; tried again until it answers")


def _parsed(url: str) -> tuple[Any, int]:
    try:
        parts = urlsplit(url)
        port = parts.port or _PORTS[parts.scheme]
    except (ValueError, KeyError):
        parts, port = urlsplit(""), 0
    topic = unquote(parts.path[1:])
    if not parts.hostname or not topic or parts.query or parts.fragment or set(topic) & set("+#\0"):
        raise UsageError(f"--mqtt: {quoted(_hidden(url))} is not mqtt://HOST[:PORT]/TOPIC, or mqtts:// for TLS")
    return parts, port


def _hidden(url: str) -> str:
    """Without user and password."""
    scheme, mark, rest = url.partition("://")
    return scheme + mark + rest.rpartition("@")[2]
