"""A person at the report: scrubs, plays, reads the values at the cursor, uses the keyboard alone."""

import re

import pytest
from playwright.sync_api import Page, expect

from recorded_run import SCREENSHOTS, Recorded

WINDOWS = {
    "laptop": {},
    "laptop-dark": {"color_scheme": "dark"},
    "phone": {"viewport": {"width": 390, "height": 844}, "device_scale_factor": 2, "is_mobile": True, "has_touch": True},
}


def clock(page: Page) -> float:
    return float(page.locator("#clock b").inner_text())


def scrub(page: Page, share: float) -> float:
    """Presses on the time slider, at this share of its length; gives the time shown then."""
    box = page.locator("#time").bounding_box()
    page.mouse.click(box["x"] + share * box["width"], box["y"] + box["height"] / 2)
    return clock(page)


def number(page: Page, selector: str) -> float:
    return float(re.search(r"-?[\d.]+", page.locator(selector).inner_text()).group())


def compare_with_csv(page: Page, recorded: Recorded):
    time = clock(page)
    for axis in "xyz":
        assert number(page, f"#now-{axis}") == pytest.approx(recorded.at(time, f"plant.encoderPose.{axis}"), abs=6e-5)
        assert number(page, f"#now-set-{axis}") == pytest.approx(recorded.at(time, f"controller.setPoint.{axis}"), abs=6e-5)
    for angle in ("roll", "pitch", "yaw"):
        if page.locator(f"#now-{angle}").count():
            assert number(page, f"#now-{angle}") == pytest.approx(recorded.at(time, f"plant.encoderPose.{angle}"), abs=1e-4)
    tensions = [recorded.at(time, f"plant.measuredTension[{i}]") for i in range(1, 7)]
    for i, tension in enumerate(tensions, 1):
        assert number(page, f"#measured-{i}") == pytest.approx(tension, abs=6e-4)
        shown_slack = page.locator(f"#measured-{i}").get_attribute("class") == "bad"
        assert shown_slack == (recorded.at(time, f"plant.slack[{i}]") != 0)
    assert number(page, "#now-smallest") == pytest.approx(min(tensions), abs=6e-4)
    assert number(page, "#now-margin") == pytest.approx(recorded.at(time, "controller.tensionMargin"), abs=6e-4)


@pytest.mark.parametrize("share", [0.0, 0.13, 0.21, 0.5, 0.98])
@pytest.mark.parametrize("run", ["paper", "pushed"])
def test_values_at_the_cursor_are_those_of_the_csv(open_report, request, run, share):
    recorded = request.getfixturevalue(run)
    page = open_report(recorded)
    time = scrub(page, share)
    assert abs(time - share * recorded.columns["time"][-1]) < 0.03 * recorded.columns["time"][-1]
    compare_with_csv(page, recorded)


def test_a_press_on_a_chart_moves_the_cursor_in_every_panel(open_report, paper):
    page = open_report(paper)
    chart = page.locator("#tension-chart .u-over")
    chart.scroll_into_view_if_needed()
    box = chart.bounding_box()
    page.mouse.move(box["x"] + 20, box["y"] + 40)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + 60)
    page.mouse.up()
    assert clock(page) == pytest.approx(paper.columns["time"][-1] / 2, abs=0.1)
    compare_with_csv(page, paper)
    over = [line.bounding_box()["x"] - line.locator("..").bounding_box()["x"] for line in page.locator(".cursor").all()]
    assert len(over) == 5 and all(x > 50 for x in over), over


def test_play_runs_at_the_speed_chosen_and_stops_at_the_end(open_report, paper):
    page = open_report(paper)
    page.locator("#speed").select_option("4")
    page.get_by_role("button", name="Play", exact=True).click()
    page.wait_for_timeout(500)
    page.get_by_role("button", name="Pause").click()
    time = clock(page)
    assert 1 < time < paper.columns["time"][-1], "half a second or more at four times the speed"
    compare_with_csv(page, paper)
    page.wait_for_timeout(100)
    assert clock(page) == time, "a pause stands still"
    scrub(page, 0.95)
    page.get_by_role("button", name="Play", exact=True).click()
    expect(page.get_by_role("button", name="Play", exact=True)).to_be_visible(timeout=20_000)
    assert clock(page) == paper.columns["time"][-1]


def test_the_keyboard_is_enough(open_report, paper):
    page = open_report(paper)
    end = paper.columns["time"][-1]
    page.keyboard.press("End")
    assert clock(page) == end
    page.keyboard.press("ArrowLeft")
    assert clock(page) == pytest.approx(end - end / 200, abs=0.01)
    page.keyboard.press("Home")
    page.keyboard.press("Shift+ArrowRight")
    assert clock(page) == pytest.approx(end / 20, abs=0.01)
    page.keyboard.press("Space")
    page.wait_for_timeout(300)
    page.keyboard.press("Space")
    time = clock(page)
    assert time > end / 20
    compare_with_csv(page, paper)

    # From one end of the page to the other with Tab; each stop is seen.
    stops = []
    for _ in range(16):
        page.keyboard.press("Tab")
        stops.append(page.evaluate("document.activeElement.id || document.activeElement.textContent"))
        if stops[-1] == "speed":
            break
        assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") != "none", stops
    assert [stop for stop in stops if stop in ("scene", "reset-view", "u5", "play", "time", "speed")] == [
        "scene", "reset-view", "u5", "play", "time", "speed"], stops
    page.locator("#scene").focus()
    before = page.locator("#scene .platform").get_attribute("d")
    page.keyboard.press("ArrowRight")
    assert page.locator("#scene .platform").get_attribute("d") != before, "the view turns"
    assert clock(page) == time, "and time stands"


@pytest.mark.parametrize("window", ["laptop", "phone"])
def test_a_drag_turns_the_view_and_the_button_resets_it(open_report, paper, window):
    page = open_report(paper, **WINDOWS[window])
    platform = page.locator("#scene .platform")
    before, box = platform.get_attribute("d"), page.locator("#scene").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    if window == "phone":
        touch = page.context.new_cdp_session(page)
        for kind, dx in [("touchStart", 0), ("touchMove", 30), ("touchMove", 80), ("touchEnd", None)]:
            points = [] if dx is None else [{"x": x + dx, "y": y}]
            touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
    else:
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 80, y + 30)
        page.mouse.up()
    assert platform.get_attribute("d") != before
    page.locator("#reset-view").click()
    assert platform.get_attribute("d") == before


def test_slack_cables_are_red_where_the_csv_says_so_and_p_tells_why(open_report, pushed):
    page = open_report(pushed)
    slack = [[i for i in range(1, 7) if pushed.columns[f"plant.slack[{i}]"][row]] for row in range(len(pushed.columns["time"]))]
    row = next(row for row, cables in enumerate(slack) if len(cables) == 1 and slack[row - 20] == cables)
    page.evaluate(f"seek({pushed.columns['time'][row]})")
    compare_with_csv(page, pushed)
    (cable,) = slack[row]
    assert page.locator("#now-roll").count() == 1, "a platform that turns has a chart of angles"
    assert f"slack: cable {cable}" in page.locator("#robot-now").inner_text()
    assert page.locator("#scene path.slack").count() == 1
    assert f"slack: cable {cable} (turned" in page.locator("#plane-now").inner_text(), "the push has turned the platform"
    page.evaluate("seek(0.5)")
    assert page.locator("#scene path.slack").count() == 0
    assert " mm inside facet" in page.locator("#plane-now").inner_text()
    assert page.locator("h1").inner_text() == "A push that slackens cables <&>"
    assert page.locator(".verdict .bad", has_text="slack cables").count() == 1


def test_one_cable_can_be_shown_alone(open_report, paper):
    page = open_report(paper)
    button = page.get_by_role("button", name="Show cable 5 alone")
    button.click()
    expect(button).to_have_attribute("aria-pressed", "true")
    button.click()
    expect(button).to_have_attribute("aria-pressed", "false")


def test_who_asked_for_little_motion_sees_few_pictures(open_report, paper):
    def pictures(**window) -> int:
        page = open_report(paper, **window)
        page.evaluate("""() => {
            window.count = 0;
            new MutationObserver(() => { window.count++; }).observe(document.getElementById("clock"), { childList: true });
        }""")
        page.keyboard.press("Space")
        page.wait_for_timeout(1000)
        return page.evaluate("window.count")

    assert 1 <= pictures(reduced_motion="reduce") < pictures() / 2


@pytest.mark.parametrize("window", WINDOWS)
@pytest.mark.parametrize("run", ["paper", "pushed"])
def test_fits_the_window_and_looks_like_this(open_report, request, run, window):
    recorded = request.getfixturevalue(run)
    page = open_report(recorded, **WINDOWS[window])
    page.evaluate("seek(1.15)")
    assert page.evaluate("document.documentElement.scrollWidth") <= page.viewport_size["width"], "nothing sticks out"
    for target in page.locator("#play, #time, #speed").all():
        assert target.bounding_box()["height"] >= 44, "large enough for a finger"
    background = page.evaluate("getComputedStyle(document.body).backgroundColor")
    assert (sum(map(int, re.findall(r"\d+", background))) < 200) == (window == "laptop-dark")
    # The same names each time: target/screenshots/ is there to be looked at.
    SCREENSHOTS.mkdir(parents=True, exist_ok=True)
    page.wait_for_timeout(100)
    page.screenshot(path=SCREENSHOTS / f"{run}-{window}.png", full_page=True)


def test_is_small(paper, pushed):
    for recorded in (paper, pushed):
        assert recorded.page.stat().st_size < 6_000_000


def test_a_window_without_room_draws_no_nonsense(open_report, paper):
    """A page that is laid out late, or a window made very small, put NaN into paths; open_report looks at the console."""
    page = open_report(paper, viewport={"width": 60, "height": 400})
    page.set_viewport_size({"width": 1366, "height": 768})
    page.evaluate("seek(1.15)")
    compare_with_csv(page, paper)
    assert page.locator("#plane-picture .hexagon").count() == 1
