"""The README's picture: python fmpy-tests/browser/picture.py target/demo/report.html docs/report.png"""

import shutil
import sys
from pathlib import Path

from playwright.sync_api import sync_playwright

report, picture = map(Path, sys.argv[1:])
with sync_playwright() as playwright:
    chromium = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
    page = chromium.new_page(viewport={"width": 1366, "height": 1440})
    page.goto(report.resolve().as_uri())
    # A little after the second set point was given.
    page.evaluate("seek(2.7)")
    page.wait_for_timeout(200)
    page.screenshot(path=picture)
    chromium.close()
