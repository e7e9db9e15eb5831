# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The HTML page in a real browser: Chromium without a window, driven by the chromedriver of the same Debian package."""

from __future__ import annotations

import base64
import json
import shutil
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select
from support.refined_recording import R_CAM2GRIPPER, T_CAM2GRIPPER, K, refined_recording

from cv_active_handeye.report import write_report
from cv_active_handeye.workflow.compare import BoardCamera, Comparison, MethodResult

CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
pytestmark = pytest.mark.skipif(
    not (CHROMIUM and DRIVER), reason="chromium or chromedriver is missing; scripts/system-packages python3 test"
)

DRAWN = "return !document.querySelector('[aria-busy=true]')"
FITTED = "[...document.querySelectorAll('.plot')].every((p) => p.clientWidth == p.querySelector('svg').clientWidth)"
WIDTHS = {"narrow": 390, "middle": 900, "wide": 1600}


def start(*arguments: str) -> webdriver.Chrome:
    """A browser that reports what its console and its network say."""
    options = webdriver.ChromeOptions()
    options.binary_location = str(CHROMIUM)
    # --no-sandbox: containers run as root; swiftshader: WebGL without a graphics card.
    for argument in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--enable-unsafe-swiftshader"):
        options.add_argument(argument)
    for argument in arguments:
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    return webdriver.Chrome(options=options, service=Service(DRIVER))


@pytest.fixture(scope="module")
def browser() -> Iterator[webdriver.Chrome]:
    browser = start()
    yield browser
    browser.quit()


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Everything the page can show: laser, board, views that were not believed."""
    folder = tmp_path_factory.mktemp("report")
    r = refined_recording(folder / "set")
    r.summary.rejectedViews, r.summary.culprits = [3], ["view 3: its pose is off by 0.0005"]
    ours = MethodResult("ours", R_CAM2GRIPPER, T_CAM2GRIPPER, 0.12, 0.01, 0.3, (K, np.zeros(5)))
    comparison = Comparison(BoardCamera(0.2, K, np.zeros(5), [0, 1, 2]), [ours])
    write_report(folder / "report.html", r.dataset, r.calibration, r.evidence, r.summary, comparison)
    return folder / "report.html"


def wait_for(browser: webdriver.Chrome, condition: str, seconds: float = 30) -> None:
    """Until the script `condition` returns true."""
    end = time.monotonic() + seconds
    while not browser.execute_script(condition):
        assert time.monotonic() < end, f"after {seconds} s still not: {condition}"
        time.sleep(0.05)


def show(browser: webdriver.Chrome, page: Path, width: int = 1600, scheme: str = "light") -> None:
    """Opens the page where it is not open yet, in a window of this width, and waits until all figures are drawn."""
    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 600}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    prefer(browser, scheme)
    if browser.current_url != page.as_uri():
        browser.get(page.as_uri())
    wait_for(browser, f"{DRAWN} && {FITTED}")


def prefer(browser: webdriver.Chrome, scheme: str) -> None:
    """Switches between light and dark as the system of the reader does."""
    wishes = {"prefers-color-scheme": scheme, "prefers-reduced-motion": "reduce"}
    features = [{"name": name, "value": value} for name, value in wishes.items()]
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})


def log(browser: webdriver.Chrome, name: str) -> list[Any]:
    """What came into this log since the last call."""
    return list(browser.get_log(name))  # type: ignore[no-untyped-call]  # selenium gives it no types


def console_errors(browser: webdriver.Chrome) -> list[Any]:
    return [entry for entry in log(browser, "browser") if entry["level"] == "SEVERE"]


def requested(browser: webdriver.Chrome) -> set[str]:
    """Addresses of everything asked for since the last call."""
    messages = [json.loads(entry["message"])["message"] for entry in log(browser, "performance")]
    sent = [m["params"]["request"]["url"] for m in messages if m["method"] == "Network.requestWillBeSent"]
    return {url for url in sent if not url.startswith(("data:", "blob:"))}


def lightness(colour: str) -> float:
    """Mean of the channels of `rgb(r, g, b)`."""
    return float(np.mean([float(x) for x in colour[colour.index("(") + 1 : -1].split(",")[:3]]))


def test_page_opens_from_a_file_and_asks_for_nothing_else(browser: webdriver.Chrome, page: Path) -> None:
    requested(browser)
    show(browser, page)
    assert requested(browser) == {page.as_uri()}
    assert console_errors(browser) == []
    assert browser.title == "Usable – calibration report"


def test_all_figures_are_drawn(browser: webdriver.Chrome, page: Path) -> None:
    show(browser, page)
    marks = {
        "view_rms": ".bars .point path",
        "residuals": ".scatterlayer .lines path",
        "coverage": ".heatmaplayer image",
        "correlation": ".heatmaplayer image",
        "motion": "canvas",
        "poses": ".scatterlayer .points path",
        "stripes": ".scatterlayer .lines path",
    }
    plots = browser.find_elements(By.CSS_SELECTOR, "[data-figure]")
    assert {plot.get_attribute("data-figure") for plot in plots} == set(marks)
    for plot in plots:
        drawn = plot.find_elements(By.CSS_SELECTOR, marks[str(plot.get_attribute("data-figure"))])
        assert drawn, plot.get_attribute("data-figure")
        assert drawn[0].rect["width"] > 3
        assert plot.rect["height"] > 150


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", WIDTHS.values(), ids=WIDTHS.keys())
def test_nothing_is_wider_than_the_window(browser: webdriver.Chrome, page: Path, width: int, scheme: str) -> None:
    show(browser, page, width, scheme)
    browser.execute_script("for (const part of document.querySelectorAll('details')) part.open = true")
    root = "document.documentElement"
    assert browser.execute_script(f"return {root}.scrollWidth - {root}.clientWidth") == 0
    script = """return [...document.querySelectorAll('main *')].filter((part) =>
        part.getBoundingClientRect().right > innerWidth + 1 && !part.closest('.scroll, pre, svg'))
        .map((part) => part.outerHTML.slice(0, 80))"""
    assert browser.execute_script(script) == []


def test_page_and_figures_follow_the_colour_scheme_while_open(browser: webdriver.Chrome, page: Path) -> None:
    show(browser, page, scheme="light")
    assert lightness(colour(browser, "body", "backgroundColor")) > 200
    light = colour(browser, ".plot-poses .xtick text", "fill")
    assert lightness(light) < 130
    prefer(browser, "dark")
    tick = "getComputedStyle(document.querySelector('.plot-poses .xtick text'))"
    wait_for(browser, f"return {tick}.fill != '{light}'", 5)
    assert lightness(colour(browser, "body", "backgroundColor")) < 50
    assert lightness(colour(browser, ".plot-poses .xtick text", "fill")) > 130
    assert console_errors(browser) == []


def colour(browser: webdriver.Chrome, selector: str, name: str) -> str:
    script = f"return getComputedStyle(document.querySelector('{selector}')).{name}"
    return str(browser.execute_script(script))


def scale_of_arrows(browser: webdriver.Chrome) -> str:
    return browser.find_element(By.CSS_SELECTOR, ".plot-residuals .textpoint text").text


def test_a_view_is_chosen_by_list_buttons_keys_and_bars(browser: webdriver.Chrome, page: Path) -> None:
    show(browser, page)
    choice = browser.find_element(By.ID, "view-choice")
    words = browser.find_element(By.ID, "view-words")
    averaged = scale_of_arrows(browser)
    Select(choice).select_by_visible_text("View 3")
    assert "the pose of this view was not believed" in words.text
    wait_for(browser, "return document.querySelectorAll('.plot-residuals .points path').length > 20")
    assert scale_of_arrows(browser) != averaged
    browser.find_element(By.CSS_SELECTOR, "[data-step='1']").click()
    assert choice.get_property("value") == "5"
    choice.send_keys(Keys.ARROW_UP)
    assert choice.get_property("value") == "4"
    bar = browser.find_elements(By.CSS_SELECTOR, ".plot-view_rms .bars .point path")[7]
    browser.execute_script("scrollTo(0, arguments[0].getBoundingClientRect().top + scrollY - 300)", bar)
    webdriver.ActionChains(browser).move_to_element(bar).pause(0.2).click().perform()
    wait_for(browser, "return document.getElementById('view-choice').value == '8'", 5)
    assert console_errors(browser) == []


def test_motion_is_turned_by_buttons(browser: webdriver.Chrome, page: Path) -> None:
    show(browser, page)
    button = browser.find_element(By.XPATH, "//button[text()='from above']")
    button.send_keys(Keys.ENTER)
    wait_for(browser, "return document.querySelector('.plot-motion')._fullLayout.scene.camera.eye.x == 0", 5)


def test_numbers_are_copied(browser: webdriver.Chrome, page: Path) -> None:
    show(browser, page)
    browser.find_element(By.CSS_SELECTOR, "[data-copy=table-text]").click()
    wait_for(browser, "return document.getElementById('announcement').textContent == 'Copied'", 5)


def test_print_is_light_and_fits_the_paper(browser: webdriver.Chrome, page: Path) -> None:
    show(browser, page, scheme="dark")
    script = """addEventListener('beforeprint', () => {
        const plot = document.querySelector('.plot-poses');
        window.printed = [plot.querySelector('.main-svg').clientWidth,
                          getComputedStyle(plot.querySelector('.xtick text')).fill];
    })"""
    browser.execute_script(script)
    printed = browser.execute_cdp_cmd("Page.printToPDF", {"preferCSSPageSize": True})
    assert base64.b64decode(printed["data"])[:5] == b"%PDF-"
    width, fill = browser.execute_script("return window.printed")
    assert width == 670
    assert lightness(fill) < 130
    wait_for(browser, "return document.querySelector('.plot-poses .main-svg').clientWidth > 1000", 5)


@pytest.mark.parametrize("edit", ["unusable", "bare"])
def test_results_with_little_to_show_open_without_errors(browser: webdriver.Chrome, tmp_path: Path, edit: str) -> None:
    r = refined_recording(tmp_path / "set", laser=False)
    changes: dict[str, Callable[[], None]] = {"unusable": lambda: setattr(r.summary, "usable", False)}
    changes["bare"] = lambda: r.summary.rejectedObservations.fill(1)
    changes[edit]()
    write_report(tmp_path / "report.html", r.dataset, r.calibration, r.evidence, r.summary)
    show(browser, tmp_path / "report.html", 390)
    assert console_errors(browser) == []


def test_motion_is_drawn_flat_where_there_is_no_webgl(page: Path) -> None:
    browser = start("--disable-3d-apis")
    try:
        show(browser, page, 390)
        assert len(browser.find_elements(By.CSS_SELECTOR, ".plot-motion .subplot")) == 2
        assert not browser.find_element(By.ID, "eye-control").is_displayed()
        assert console_errors(browser) == []
    finally:
        browser.quit()
