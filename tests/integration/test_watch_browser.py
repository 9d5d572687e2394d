"""The page of tumble watch in headless Chromium: runs of the bench to their end, on a narrow screen and with the
keyboard, in the dark, and a server that goes and comes again. Pictures go to build/test/watch, to be looked at."""

import json
import re
import shutil
import urllib.request

import pytest
from conftest import ROOT
from played_run import AVERAGING, DONE, PlayedSource
from test_watch_bench import ended, faulty, hasty, page

from tumble.watch.runs import Follower
from tumble.watch.snapshot import Lost

assert hasty
webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")
pytest.importorskip("uvicorn", reason="uvicorn is not installed")
from selenium.webdriver.chrome.service import Service  # noqa: E402
from selenium.webdriver.common.keys import Keys  # noqa: E402
from selenium.webdriver.support.ui import WebDriverWait  # noqa: E402

pytestmark = [pytest.mark.python, pytest.mark.toolchain]
PICTURES = ROOT / "build/test/watch"
PHONE, DESK = (360, 1300), (960, 860)


class Page:
    """Chromium with a page of tumble watch."""

    def __init__(self, driver):
        self.driver = driver

    def open(self, url, size=DESK):
        screen = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": size == PHONE}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
        self.driver.get(url)

    def text(self, name):
        return self.driver.execute_script("return document.getElementById(arguments[0]).textContent", name)

    def shows(self, name):
        return self.driver.execute_script("return !document.getElementById(arguments[0]).hidden", name)

    def wait(self, condition, timeout=120):
        WebDriverWait(self.driver, timeout, 0.05).until(lambda _: condition())

    def wait_for(self, name, text):
        self.wait(lambda: re.search(text, self.text(name)))

    def picture(self, name):
        PICTURES.mkdir(parents=True, exist_ok=True)
        assert self.driver.save_screenshot(str(PICTURES / f"{name}.png"))

    def complaints(self):
        """What the browser has logged: faults of the script, of the policy."""
        return [one["message"] for one in self.driver.get_log("browser")]

    def is_wider_than_the_screen(self):
        return self.driver.execute_script("return document.documentElement.scrollWidth > innerWidth")


@pytest.fixture(scope="module")
def chromium():
    browser, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if browser is None or driver is None:
        pytest.skip("chromium is not installed (Debian: chromium, chromium-driver)")
    options = webdriver.ChromeOptions()
    options.binary_location = browser
    for switch in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--lang=en"):
        options.add_argument(switch)
    found = webdriver.Chrome(options=options, service=Service(driver))
    found.set_script_timeout(60)
    yield Page(found)
    found.quit()


def test_a_run_from_its_beginning_to_its_end(chromium, hasty, tmp_path):
    options = "--stand", hasty, "--samples", 200, "--pace", 4, "--out", tmp_path / "run"
    with page(*options, cwd=tmp_path) as (process, url):
        chromium.open(url)
        chromium.wait_for("mean-of", r"of 200 samples, mounting (1, position [3-9]|2)")
        chromium.wait_for("angle", r"^\+\d+\.\d{3} deg$")
        assert not chromium.shows("reason") and not chromium.shows("lost") and chromium.text("source") == "bench"
        chromium.picture("running")
        chromium.open(url, PHONE)  # another onlooker, in the middle of it
        chromium.wait_for("place", "positions finished")
        assert not chromium.is_wider_than_the_screen()
        chromium.picture("running-phone")
        chromium.wait_for("state", "^DONE$")
        chromium.wait_for("verdict", "PASS")
        assert not chromium.is_wider_than_the_screen()
        chromium.picture("done-phone")
        chromium.open(url)
        chromium.wait_for("state", "^DONE$")
        details = "return document.getElementById('uncertainties').open"
        assert not chromium.driver.execute_script(details)
        for _ in range(2):  # past the table, which scrolls where it is too wide, to what opens
            chromium.driver.switch_to.active_element.send_keys(Keys.TAB)
        chromium.driver.switch_to.active_element.send_keys(Keys.ENTER)
        chromium.wait(lambda: chromium.driver.execute_script(details))
        chromium.picture("done")
        assert chromium.complaints() == []
        chromium.driver.find_element("link text", "The numbers as JSON").click()
        shown = json.loads(chromium.driver.find_element("tag name", "pre").text)
        code, _, _ = ended(process)
    result = json.loads((tmp_path / "run/result.json").read_text())
    assert code == 0 and shown["snapshot"]["k_v_per_g"] == result["K"]


def test_a_run_that_ends_in_a_fault(chromium, hasty, tmp_path):
    options = "--stand", hasty, "--pace", 20, *faulty(tmp_path), "--out", tmp_path / "run"
    with page(*options, cwd=tmp_path) as (process, url):
        chromium.open(url)
        chromium.wait_for("state", "^FAULT$")
        chromium.wait(lambda: chromium.shows("reason"))
        assert "DRIVE_FAULT" in chromium.text("reason-name")
        chromium.wait_for("remedy", "CLEAR_FAULT")
        assert chromium.driver.find_element("id", "reason").get_attribute("role") == "alert"
        chromium.picture("fault")
        chromium.open(url, PHONE)
        chromium.wait_for("state", "^FAULT$")
        assert not chromium.is_wider_than_the_screen() and chromium.complaints() == []
        ended(process)


def contrast(first, second):
    """Of two colours "rgb(r, g, b)", as WCAG 2 defines it."""
    def luminance(colour):
        parts = [int(part) / 255 for part in re.findall(r"\d+", colour)[:3]]
        linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
        return sum(weight * part for weight, part in zip((0.2126, 0.7152, 0.0722), linear))

    light, dark = sorted((luminance(first), luminance(second)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_connection_that_goes_and_comes_again(chromium, scheme):
    from tumble.watch.server import Server

    follower = Follower(PlayedSource(AVERAGING, Lost("node 1 is silent"), DONE), "can:vcan0", 1.0)
    follower.ask()
    media = {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
    chromium.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", media)
    with Server(follower.view, "127.0.0.1", 0) as server:
        chromium.open(server.url)
        chromium.wait_for("state", "^AVERAGE$")
        assert chromium.text("angle") == "+135.000 deg" and chromium.text("mean").startswith("x+1.3719455.1e")
        follower.ask()
        chromium.wait(lambda: chromium.shows("lost"))
        assert re.fullmatch(r"since \d\d:\d\d:\d\d", chromium.text("lost-since"))
        assert chromium.text("lost-why") == "node 1 is silent." and chromium.text("state") == "AVERAGE"
        chromium.picture(f"lost-{scheme}")
        style = "return getComputedStyle(document.querySelector(arguments[0])).getPropertyValue(arguments[1])"
        colours = [chromium.driver.execute_script(style, *of) for of in (
            (".alarm strong", "color"), (".alarm", "background-color"), ("#meaning", "color"),
            ("#state", "color"), ("section", "background-color"))]
        alarm, alarm_back, soft, text, back = colours
        assert min(contrast(alarm, alarm_back), contrast(soft, back), contrast(text, back)) >= 4.5, colours
        follower.ask()
        chromium.wait_for("state", "^DONE$")
        assert not chromium.shows("lost")
        port = int(server.url.rstrip("/").rpartition(":")[2])
    chromium.wait(lambda: chromium.shows("lost"))  # the server itself has ended
    assert chromium.text("lost-why") == "tumble watch itself does not answer."
    with Server(follower.view, "127.0.0.1", port) as server:
        chromium.wait(lambda: not chromium.shows("lost"))
        assert chromium.text("state") == "DONE"
        with urllib.request.urlopen(server.url, timeout=20) as answer:
            assert answer.status == 200
