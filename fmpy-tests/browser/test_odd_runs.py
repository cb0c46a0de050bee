"""Reports of runs that are unlike the paper's: crowded, turned, without a goal."""

import csv
import shutil
import time

import pytest

from recorded_run import SCREENSHOTS, Recorded, cable_robot, record

TURNED = """
title = "Turned from the start"
start = [0.0, 0.0, 1.0, 0.05, -0.03, 0.4]
duration = 6.0
[[goals]]
time = 0.5
pose = [0.05, 0.05, 0.9, 0.0, 0.1, -0.3]
[controller]
planner = "exact"
"""
THROWN = """
title = "Thrown"
duration = 1.0
[[disturbances]]
from = 0.1
force = [1e5, 0.0, 0.0]
"""


@pytest.fixture(scope="session")
def crowded(paper, tmp_path_factory) -> Recorded:
    """20 s at 1 kHz with another set point and another goal in each row."""
    folder = tmp_path_factory.mktemp("runs") / "crowded"
    folder.mkdir()
    shutil.copy(paper.folder / "run.json", folder)
    with (paper.folder / "run.csv").open() as file:
        header, *rows = csv.reader(file)
    place = {name: k for k, name in enumerate(header)}
    with (folder / "run.csv").open("w", newline="") as file:
        out = csv.writer(file)
        out.writerow(header)
        for k in range(20_001):
            row = list(rows[min(k, len(rows) - 1)])
            row[0] = k * 1e-3
            row[place["controller.setPointIndex"]] = k
            for axis in "xy":
                x = float(row[place[f"plant.encoderPose.{axis}"]]) + 1e-3 * (k % 7) / 7
                row[place[f"controller.setPoint.{axis}"]] = row[place[f"controller.goalPose.{axis}"]] = x
            out.writerow(row)
    cable_robot("report", folder)
    return Recorded(folder)


def recorded(tmp_path_factory, text) -> Recorded:
    folder = tmp_path_factory.mktemp("runs")
    (folder / "odd.toml").write_text(text)
    return record(folder / "odd.toml", folder / "odd")


@pytest.fixture(scope="session")
def turned(tmp_path_factory) -> Recorded:
    return recorded(tmp_path_factory, TURNED)


def look(page, name):
    SCREENSHOTS.mkdir(parents=True, exist_ok=True)
    page.wait_for_timeout(100)
    page.screenshot(path=SCREENSHOTS / f"{name}.png", full_page=True)


def test_a_set_point_at_each_step_stays_small_and_quick(open_report, crowded):
    assert crowded.page.stat().st_size < 6_000_000
    begun = time.monotonic()
    page = open_report(crowded)
    page.evaluate("seek(0.5 * end)")
    page.wait_for_function("document.querySelectorAll('#plane-picture text').length > 0")
    assert time.monotonic() - begun < 2
    per_move = page.evaluate("(() => { const t = performance.now(); for (let k = 0; k < 20; k++) show(40 * k); return (performance.now() - t) / 20; })()")
    assert per_move < 50, f"{per_move} ms to move the cursor"
    page.evaluate("seek(0.5 * end)")
    at = float(page.locator("#clock b").inner_text())
    assert float(page.locator("#now-set-x").inner_text()) == pytest.approx(crowded.at(at, "controller.setPoint.x"), abs=6e-5)
    assert f"set point {crowded.at(at, 'controller.setPointIndex'):.0f} of 20000" in page.locator("#robot-now").inner_text()
    assert page.locator("#marks i.step").count() == 0 and page.locator("#plane-picture circle").count() < 10
    assert page.locator("#plane-picture text").count() < 20, "no ring of numbers"
    look(page, "crowded")


def test_no_cable_that_pulls_is_said_to_push(open_report, turned, pushed):
    for run in (turned, pushed):
        page = open_report(run)
        claims = page.evaluate("""() => rows.time.map((_, row) => { show(row); return [row, byId("plane-now").innerText]; })
            .map(([row, said]) => [row, said.match(/cable (\\d) would have to push/)]).filter(([, claim]) => claim)
            .map(([row, claim]) => (rows.slack[row] >> (claim[1] - 1)) & 1)""")
        assert all(claims) and bool(claims) == (run is pushed), claims
    page = open_report(turned)
    said = page.locator("#plane-now").inner_text()
    assert "turned: the facets are those of zero orientation" in said and "all cables taut" in said
    assert page.locator("#plane-picture .facet").get_attribute("visibility") == "hidden"
    look(page, "turned")


def test_the_names_of_p_and_goal_never_cover_each_other(open_report, paper):
    page = open_report(paper)
    page.wait_for_function("document.querySelectorAll('#plane-picture text').length > 0")
    covered = page.evaluate("""() => {
        const named = (name) => [...document.querySelectorAll("#plane-picture text")].find((t) => t.textContent === name).getBBox();
        return rows.time.map((_, row) => {
            show(row);
            const [p, goal] = [named("p"), named("goal")];
            return p.x < goal.x + goal.width && goal.x < p.x + p.width && p.y < goal.y + goal.height && goal.y < p.y + p.height;
        }).filter(Boolean).length;
    }""")
    assert covered == 0
    look(page, "paper-end")


def test_a_limit_far_above_the_tensions_is_told(open_report, paper):
    page = open_report(paper)
    written = page.evaluate("""async () => {
        const written = [], { fillText } = CanvasRenderingContext2D.prototype;
        CanvasRenderingContext2D.prototype.fillText = function (text, ...at) { written.push(text); return fillText.call(this, text, ...at); };
        tension.redraw();
        await new Promise((resolve) => setTimeout(resolve, 100));
        return written;
    }""")
    assert "limit 100 N ↑" in written


def test_a_run_without_a_goal_and_with_a_fault_says_so(open_report, tmp_path_factory):
    page = open_report(recorded(tmp_path_factory, THROWN))
    verdict = page.locator(".verdict").inner_text()
    assert "goal the start, held" in verdict and "at the goal" not in verdict
    assert "sensor fault" in page.locator(".verdict .bad").last.inner_text()
    look(page, "thrown")
