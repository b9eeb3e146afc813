"""A browser that opens pages from files; tests that need one skip where there is none."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

_FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-dev-shm-usage",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--window-size=1400,1000",
)


@pytest.fixture(scope="session")
def start_browser() -> Callable[..., Any]:
    """Starts headless Chromium with WebGL 2 in software, and further flags."""
    pytest.importorskip("selenium", reason="selenium drives the browser")
    from selenium import webdriver
    from selenium.webdriver.chrome.options import Options
    from selenium.webdriver.chrome.service import Service

    browser, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if browser is None or driver is None:
        pytest.skip("chromium and chromedriver are not installed")

    def start(*flags: str) -> Any:
        options = Options()
        options.binary_location = browser
        for flag in (*_FLAGS, *flags):
            options.add_argument(flag)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        started = webdriver.Chrome(options=options, service=Service(driver))
        started.set_script_timeout(60)
        return started

    return start


@pytest.fixture(scope="session")
def browser(start_browser: Callable[..., Any]) -> Iterator[Any]:
    started = start_browser()
    yield started
    started.quit()


@pytest.fixture(scope="session")
def open_page(browser: Any) -> Callable[[Path], Any]:
    """Opens a page from a file, its console empty, and returns the browser."""

    def open_file(path: Path) -> Any:
        browser.get("about:blank")
        browser.get_log("browser")
        browser.get(path.as_uri())
        return browser

    return open_file
