"""A real browser for the tests of web pages: headless Chromium, driven through its driver."""

import contextlib
import shutil
import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from selenium.webdriver import Chrome

BROWSERS = ('chromium', 'chromium-browser', 'google-chrome')
DRIVERS = ('chromedriver', 'chromium.chromedriver')
SHOW = "arguments[0].scrollIntoView({block: 'center', behavior: 'instant'})"


def _find(names: tuple[str, ...]) -> str:
    for name in names:
        if path := shutil.which(name):
            return path
    raise AssertionError(
        f'none of {", ".join(names)} was found; install them (Debian: chromium chromium-driver), '
        "or leave the tests of web pages out: scripts/test -m 'not browser'"
    )


@contextlib.contextmanager
def open_browser(width: int = 1280, height: int = 1000) -> 'Iterator[Chrome]':
    """Yield a browser whose window has this size, px; it is ended when the block is left."""
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = _find(BROWSERS)
    for argument in (
        *('--headless=new', '--no-sandbox', '--disable-gpu', f'--window-size={width},{height}'),
        *('--no-first-run', '--disable-background-networking', '--disable-component-update'),
        '--disable-dev-shm-usage',
    ):
        options.add_argument(argument)
    options.set_capability('goog:loggingPrefs', {'browser': 'ALL'})
    browser = webdriver.Chrome(options, webdriver.ChromeService(_find(DRIVERS)))
    browser.set_script_timeout(300)
    browser.set_page_load_timeout(300)
    try:
        yield browser
    finally:
        browser.quit()


def until(condition: Callable[[], Any], seconds: float = 60.0) -> Any:
    """Wait for a condition; its last value."""
    deadline = time.monotonic() + seconds
    while not (value := condition()) and time.monotonic() < deadline:
        time.sleep(0.05)
    return value


def click(page: 'Chrome', element: Any) -> None:
    """Bring an element into view and click it."""
    page.execute_script(SHOW, element)
    element.click()


def ask(page: 'Chrome', script: str, *arguments: Any) -> Any:
    """Return the value of an expression of JavaScript."""
    return page.execute_script(f'return {script}', *arguments)
