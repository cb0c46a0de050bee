"""The report of real runs in headless Chromium (Debian's package `chromium`)."""

import os
import shutil

import pytest
from playwright.sync_api import sync_playwright

from recorded_run import PUSHED, Recorded, record


@pytest.fixture(scope="session")
def paper(tmp_path_factory) -> Recorded:
    return record("paper", tmp_path_factory.mktemp("runs") / "paper")


@pytest.fixture(scope="session")
def pushed(tmp_path_factory) -> Recorded:
    folder = tmp_path_factory.mktemp("runs")
    (folder / "pushed.toml").write_text(PUSHED)
    return record(folder / "pushed.toml", folder / "pushed")


@pytest.fixture(scope="session")
def browser():
    path = shutil.which("chromium")
    if path is None and os.environ.get("CI") != "true":
        pytest.skip("chromium is not installed (Debian: chromium)")
    assert path, "chromium is not installed; continuous integration must not do without (Debian: chromium)"
    with sync_playwright() as playwright:
        # As root, as in a container, Chromium runs without its sandbox only; the page is our own.
        chromium = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield chromium
        chromium.close()


@pytest.fixture
def open_report(browser):
    """Opens a report in a window of its own and checks in the end that it was silent and fetched nothing."""
    contexts, fetched, said = [], [], []

    def open_it(recorded: Recorded, **window):
        context = browser.new_context(**{"viewport": {"width": 1366, "height": 768}, **window})
        contexts.append(context)
        page = context.new_page()
        page.on("request", lambda request: fetched.append(request.url))
        page.on("console", lambda message: said.append(message.text))
        page.on("pageerror", lambda error: said.append(str(error)))
        page.goto(recorded.page.as_uri())
        return page

    yield open_it
    for context in contexts:
        context.close()
    assert [url for url in fetched if not url.startswith(("file:", "data:"))] == []
    assert len([url for url in fetched if url.startswith("file:")]) == len(contexts), "the page itself and nothing else"
    assert said == []
