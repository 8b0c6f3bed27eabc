"""The control page in Chromium and Firefox, on the virtual camera, as a user has it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.web.page.firefox import started

playwright = pytest.importorskip("playwright.sync_api")

FOLDER = Path(__file__).parent
HALO = Path(sys.executable).with_name("halo")
SOURCE = "sim:demo,mode=NFOV_2X2BINNED"
"""A quarter of the pixels: the page is as before, and the camera costs less."""
VIEWS = ("guide", "live", "setup", "settings", "profiles", "outputs", "nodes", "record", "log")
STEPS = ("camera", "background", "touch", "sweep", "projector", "anchor", "surface", "verify")
START_S, STEP_MS = 90.0, 300_000
"""Patience with a busy machine."""
FIRST_PAINT_MS = 1000.0
WIDTH_PX = 1200

pytestmark = pytest.mark.long


class Service:
    """`halo serve`, which can be killed and started again."""

    def __init__(self, folder: Path, port: int, control: int) -> None:
        self.config = folder / "halo.toml"
        self.config.write_text(f"# The stage.\n[page]\nport = {port}\n\n[sensing]\n# Far.\n")
        self.url = f"http://127.0.0.1:{port}/"
        self._data, self._control = folder / "data", control
        self.start()

    def start(self) -> None:
        self.process = subprocess.Popen(
            [
                HALO, "serve", "--source", SOURCE, "--no-zenoh", "--no-web", "--no-osc",
                "--control-port", str(self._control), "--config", str(self.config),
            ],
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, "XDG_DATA_HOME": str(self._data)},
        )  # fmt: skip
        assert self.process.stderr is not None
        until_s = time.monotonic() + START_S
        for line in self.process.stderr:
            assert time.monotonic() < until_s
            if f"page: {self.url}" in line:
                return
        pytest.fail("the service ended before its page was there")

    def end(self, how: int = signal.SIGTERM) -> None:
        self.process.send_signal(how)
        self.process.communicate()


@pytest.fixture(scope="module")
def service(
    tmp_path_factory: pytest.TempPathFactory, free_port: Callable[[], int]
) -> Iterator[Service]:
    service = Service(tmp_path_factory.mktemp("page"), free_port(), free_port())
    yield service
    service.end()


@pytest.fixture(scope="module")
def chromium(external_program: Callable[[str], str]) -> Iterator[Any]:
    with playwright.sync_playwright() as started:
        browser = started.chromium.launch(
            executable_path=external_program("chromium"), args=["--no-sandbox"]
        )
        yield browser
        browser.close()


@pytest.fixture
def page(chromium: Any) -> Iterator[Any]:
    """A page; whatever it reports as an error fails the test."""
    page = chromium.new_context(viewport={"width": WIDTH_PX, "height": 900}).new_page()
    page.set_default_timeout(20_000)
    errors: list[str] = []
    page.on("console", lambda each: errors.append(each.text) if each.type == "error" else None)
    page.on("pageerror", lambda each: errors.append(str(each)))
    page.on("request", lambda each: errors.extend(_outside(each.url)))
    page.halo_errors = errors
    yield page
    page.context.close()
    assert errors == []


def _outside(url: str) -> list[str]:
    inside = url.startswith(("http://127.0.0.1:", "blob:", "data:"))
    return [] if inside else [f"request to {url}"]


def open_view(page: Any, service: Service, view: str) -> None:
    page.goto(f"{service.url}#{view}")
    page.reload()
    page.wait_for_selector("main h1")


def test_every_view_opens_fast_without_errors_and_is_accessible(
    service: Service, page: Any, chromium: Any
) -> None:
    axe = FOLDER / "node_modules" / "axe-core" / "axe.min.js"
    if not axe.is_file():
        message = f"axe-core is not installed: run npm install in {FOLDER}"
        pytest.fail(message) if os.environ.get("HALO_CI") else pytest.skip(message)
    # axe is not of the page, so its policy refuses it; this context does not ask the policy.
    context = chromium.new_context(bypass_csp=True)
    checked = context.new_page()
    for view in VIEWS:
        open_view(page, service, view)
        open_view(checked, service, view)
        checked.wait_for_timeout(700)
        checked.add_script_tag(path=str(axe))
        found = checked.evaluate("axe.run()")["violations"]
        serious = [each for each in found if each["impact"] in ("serious", "critical")]
        assert not serious, json.dumps([
            (view, each["id"], [node["html"] for node in each["nodes"][:3]]) for each in serious
        ], indent=1)  # fmt: skip
    painted = checked.evaluate(
        "performance.getEntriesByName('first-contentful-paint')[0].startTime"
    )
    print(f"first contentful paint after {painted:.0f} ms")
    assert painted < FIRST_PAINT_MS
    context.close()


def test_firefox_shows_every_view_with_its_pictures_and_runs_a_step(
    service: Service, external_program: Callable[[str], str], tmp_path: Path
) -> None:
    with started(external_program("firefox-esr"), tmp_path) as firefox:
        firefox.open(service.url)
        firefox.wait("document.getElementById('state').textContent === '✓ connected'")
        for view in VIEWS:
            firefox.run(f"void (location.hash = '{view}')")
            firefox.wait(f"document.querySelector('nav a[aria-current]').hash === '#{view}'")
            firefox.wait("document.querySelector('main h1') !== null")
            if view == "live":
                firefox.wait("document.body.innerText.includes('right index')")
                firefox.run(
                    "for (const each of document.querySelectorAll('main input')) each.click()"
                )
                firefox.wait(
                    "document.querySelectorAll('.pictures canvas[width=\"160\"]').length === 2"
                )
        firefox.run("void (location.hash = 'setup')")
        firefox.wait("document.querySelector('[aria-label=\"Start camera\"]') !== null")
        firefox.run("document.querySelector('[aria-label=\"Start camera\"]').click()")
        firefox.wait("document.querySelector('.prompt')?.textContent === '✓ camera'", START_S)
        assert firefox.errors == []


def test_the_live_view_shows_fingers_and_only_the_chosen_pictures(
    service: Service, page: Any
) -> None:
    open_view(page, service, "live")
    page.wait_for_selector("text=right index", timeout=60_000)
    assert page.locator(".pictures canvas").count() == 0
    for kind, width in (("depth", 160), ("infrared", 160), ("colour", 640)):
        page.check(f"#show-{kind}")
        page.wait_for_selector(f".pictures canvas[aria-label={kind}][width='{width}']")
    page.uncheck("#show-colour")
    assert page.locator(".pictures canvas").count() == 2


def test_a_finger_drags_a_corner_without_scrolling_the_page(
    service: Service, chromium: Any
) -> None:
    context = chromium.new_context(viewport={"width": 390, "height": 844}, has_touch=True)
    page = context.new_page()
    open_view(page, service, "setup")
    page.select_option("#by-surface", "picture")
    page.wait_for_selector("figure canvas[width='160']")
    picture = page.locator("figure canvas")
    picture.scroll_into_view_if_needed()
    page.locator("figure button").first.press("ArrowRight")  # the corners are there
    box, before = picture.bounding_box(), page.evaluate("scrollY")
    touch = context.new_cdp_session(page)

    def send(kind: str, *points: tuple[float, float]) -> None:
        at = [
            {"x": box["x"] + x * box["width"], "y": box["y"] + y * box["height"]} for x, y in points
        ]
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": at})

    colour = """([x, y]) => {
      const canvas = document.querySelector("figure canvas");
      const at = [x * canvas.width, y * canvas.height];
      return [...canvas.getContext("2d").getImageData(...at, 1, 1).data];
    }"""
    target = (0.2, 0.1)
    send("touchStart", (0.27, 0.38))
    for n in range(1, 11):
        send("touchMove", (0.27 - 0.007 * n, 0.38 - 0.028 * n))
    send("touchEnd")
    red, _, blue, _ = page.evaluate(colour, target)
    assert red - blue > 100, "the yellow corner is where the finger left it"
    assert page.evaluate("scrollY") == before
    context.close()


def test_the_projector_page_fills_its_window_from_the_first_pixel(
    service: Service, page: Any
) -> None:
    page.goto(f"{service.url}projector.html")
    page.wait_for_selector("#size:has-text('pixels')")
    box = page.locator("#picture").bounding_box()
    assert box == {"x": 0, "y": 0, "width": WIDTH_PX, "height": 900}


def test_a_setting_is_changed_with_the_keyboard_alone_and_read_back(
    service: Service, page: Any
) -> None:
    open_view(page, service, "settings")
    field = page.locator("#set-sensing-hover_range_mm")
    field.focus()
    page.keyboard.press("Control+A")
    page.keyboard.type("64.5")
    save = page.get_by_role("button", name="Save").first
    while not save.evaluate("node => node === document.activeElement"):
        page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    page.wait_for_selector("#toast:has-text('used from now on')")
    text = service.config.read_text()
    assert text.startswith("# The stage.\n") and "# Far.\n" in text
    assert tomllib.loads(text)["sensing"] == {"hover_range_mm": 64.5}
    page.reload()
    assert page.locator("#set-sensing-hover_range_mm").input_value() == "64.5"
    page.fill("#set-sensing-up_level", "0.9")
    save.click()
    page.wait_for_selector("#toast:has-text(\"'up_level' must be below 'down_level'\")")
    page.halo_errors[:] = [each for each in page.halo_errors if "422" not in each]
    assert "up_level" not in service.config.read_text()


def test_every_setting_is_changed_and_read_back(service: Service, page: Any) -> None:
    """Through the page's own connection, so that each setting is written and validated once."""
    open_view(page, service, "settings")
    before = service.config.read_text()
    changed = page.evaluate(CHANGE_ALL)
    assert len(changed) > 40
    values = tomllib.loads(service.config.read_text())
    for section, key, value in changed:
        table = values[section] if section else values
        assert table[key] == value, (section, key)
    service.config.write_text(before)


CHANGE_ALL = """async () => {
  const call = async (name, body) => {
    const answer = await fetch(`/call/${name}`, {
      method: "POST", body: JSON.stringify(body),
      headers: { "Content-Type": "application/json", "X-Halo-Page": "1" } });
    const value = await answer.json();
    if (!answer.ok) throw new Error(JSON.stringify(body) + value.error);
    return value;
  };
  const { schema, values } = await call("settings", {});
  const other = (property, value, key) => {
    if (property.enum) return property.enum.find((each) => each !== value);
    if (typeof value === "boolean") return !value;
    if (key === "destinations") return ["127.0.0.1:4999"];
    if (Array.isArray(value)) return ["tcp/127.0.0.1:7999"];
    if (key === "node") return "hall";
    if (key === "token") return "abcdefghijklmnop";
    if (typeof value === "string") return "changed";
    const low = property.minimum ?? property.exclusiveMinimum ?? 0;
    if (property.type === "integer") return value > low ? value - 1 : value + 1;
    return value * 1.125 + 0.0625;
  };
  const done = [];
  for (const [name, property] of Object.entries(schema.properties)) {
    const reference = property.$ref ?? property.allOf?.[0]?.$ref;
    const section = reference ? name : "";
    const table = reference ? schema.$defs[reference.split("/").pop()].properties : null;
    const fields = table ?? { [name]: property };
    for (const [key, field] of Object.entries(fields)) {
      const now = section ? values[section][key] : values[key];
      const value = other(field, now, key);
      await call("change-settings", { changes: [{ section, key, value }] });
      done.push([section, key, value]);
    }
  }
  return done;
}"""


def test_a_recording_is_replayed_in_the_camera_s_place_until_it_is_stopped(
    service: Service, page: Any
) -> None:
    open_view(page, service, "record")
    page.get_by_role("button", name="Record", exact=True).click()
    page.wait_for_selector("text=● recording")
    open_view(page, service, "live")
    page.wait_for_selector("text=right index", timeout=60_000)  # the replay shows it, too
    page.wait_for_timeout(1000)
    open_view(page, service, "record")
    page.click("text=Stop recording")
    page.wait_for_selector("text=The last recording:")
    page.click("[aria-label^='Replay ']")
    page.wait_for_selector("#notice:has-text('is replayed, not the camera')")
    open_view(page, service, "live")
    page.wait_for_selector("text=right index")
    open_view(page, service, "setup")
    page.click("[aria-label='Start camera']")
    page.wait_for_selector("text=stop the replay in Record first")
    open_view(page, service, "record")
    page.click("text=Stop the replay")
    page.wait_for_selector("#notice:has-text('Virtual camera')")
    open_view(page, service, "live")
    page.wait_for_selector("text=right index", timeout=60_000)


def test_the_page_comes_back_when_the_service_was_killed(service: Service, page: Any) -> None:
    open_view(page, service, "live")
    page.wait_for_selector("#state:has-text('connected')")
    service.end(signal.SIGKILL)
    page.wait_for_selector("#state:has-text('no service')")
    service.start()
    page.wait_for_selector("#state:has-text('connected')", timeout=30_000)
    page.wait_for_selector("text=right index", timeout=60_000)
    # Chromium itself reports each connection that is refused.
    page.halo_errors[:] = [each for each in page.halo_errors if "ERR_CONNECTION" not in each]


def press(page: Any, selector: str) -> None:
    """Go to an element with the Tab key alone, and press Enter."""
    target = page.locator(selector)
    for _ in range(150):
        page.keyboard.press("Tab")
        if target.evaluate("node => node === document.activeElement"):
            page.keyboard.press("Enter")
            return
    pytest.fail(f"the Tab key does not reach {selector}")


def test_from_an_empty_folder_to_a_verified_profile_through_the_page_alone(
    service: Service, page: Any
) -> None:
    """The first steps are done with the keyboard alone."""
    page.goto(f"{service.url}#log")
    page.wait_for_selector("main h1")
    for view in (*VIEWS, "setup"):
        press(page, f"nav a[href='#{view}']")
        page.wait_for_selector(f"nav a[href='#{view}'][aria-current]")
        page.wait_for_selector("#main:focus")
    press(page, "#profile-name")
    page.keyboard.press("Control+A")
    page.keyboard.type("stage")
    press(page, "text=Use this name")
    page.wait_for_selector("text='stage' does not exist yet")
    page.wait_for_selector("text=Still missing: background, touch, sweep")
    popup = page.context.new_page()
    popup.goto(f"{service.url}projector.html")
    popup.wait_for_selector("#size:has-text('pixels')")
    # A small surface has few crossings to verify, and the virtual user needs its time for each.
    for step in STEPS:
        if step == "surface":
            page.fill("#surface-width_mm", "100")
            page.fill("#surface-height_mm", "100")
        started_s = time.monotonic()
        if step in ("camera", "background"):
            press(page, f"[aria-label='Start {step}']")
        else:
            page.click(f"[aria-label='Start {step}']")
        if step == "sweep":
            page.wait_for_selector(".map:has-text('██')", timeout=STEP_MS)
        page.wait_for_selector(f".prompt:text-matches('^[✓✕] {step}$')", timeout=STEP_MS)
        verdict = page.locator(".card:has(.prompt)").inner_text()
        print(f"{step}: {time.monotonic() - started_s:.0f} s:", *verdict.split())
        assert page.locator(".prompt.good").count() == 1, verdict
        if step == "background":
            page.wait_for_selector(
                "li:has(#by-surface) >> text=/^◦ .*placed by the background step/"
            )
            page.wait_for_selector("text=Still missing: touch, sweep.")
    page.wait_for_selector("text=✓ The calibration is complete.")
    page.wait_for_selector("li:has([aria-label='Start verify']) >> text=/^✓ good, .* 95 % of/")
    page.click("text=Use it at every start")
    page.wait_for_selector("text=The service uses it at every start.")
    assert tomllib.loads(service.config.read_text())["profile"] == "stage"
    assert popup.evaluate("document.getElementById('picture').width") == WIDTH_PX
    open_view(page, service, "profiles")
    page.wait_for_selector(".card:has-text('stage') >> text=in use")
