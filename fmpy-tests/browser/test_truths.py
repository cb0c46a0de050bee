"""What the report shows is so: regressions of pictures and words that misled."""

import re

import pytest

from recorded_run import Recorded, record


def recorded(tmp_path_factory, name) -> Recorded:
    return record(name, tmp_path_factory.mktemp("runs") / "run")


@pytest.fixture(scope="session")
def gust(tmp_path_factory) -> Recorded:
    return recorded(tmp_path_factory, "gust")


@pytest.fixture(scope="session")
def detour(tmp_path_factory) -> Recorded:
    return recorded(tmp_path_factory, "detour")


@pytest.fixture(scope="session")
def unreachable(tmp_path_factory) -> Recorded:
    return recorded(tmp_path_factory, "unreachable")


def centres(page, selector):
    return [tuple(float(c.get_attribute(k)) for k in ("cx", "cy")) for c in page.locator(selector).all()]


def ends(page):
    """Both ends of the axes x and y in the picture of the robot."""
    paths = [axis.get_attribute("d") for axis in page.locator("#scene .axis").all()[:2]]
    return [[float(number) for number in re.findall(r"-?[\d.]+", path)] for path in paths]


def test_the_robot_is_no_mirror_image(open_report, paper):
    """Seen from above with z down, y is a quarter turn clockwise from x; cables 1 and 2 looked swapped."""
    page = open_report(paper)
    page.locator("#scene").focus()
    for _ in range(20):
        page.keyboard.press("ArrowUp")
    for _ in range(7):
        (x0, y0, x1, y1), (_, _, x2, y2) = ends(page)
        across = (x1 - x0) * (y2 - y0) - (y1 - y0) * (x2 - x0)
        # Pixels count downwards.
        assert across > 0, "mirrored"
        page.keyboard.press("ArrowLeft")


def test_nothing_is_cut_off_from_wherever_one_looks(open_report, paper):
    """The base left the picture after a small drag."""
    page = open_report(paper)
    page.locator("#scene").focus()
    box = page.locator("#scene").bounding_box()
    for key, count in (("ArrowUp", 15), ("ArrowLeft", 20), ("ArrowDown", 30), ("ArrowRight", 25)):
        for _ in range(count):
            page.keyboard.press(key)
            for x, y in centres(page, "#scene .anchor, #scene .centre"):
                assert 0 <= x <= box["width"] and 0 <= y <= box["height"], (key, x, y)


def test_the_static_workspace_is_drawn_in_space_and_whole(open_report, paper):
    page = open_report(paper)
    box = page.locator("#scene").bounding_box()
    page.locator("#scene").focus()
    for key in ["ArrowUp"] * 15 + ["ArrowLeft"] * 10:
        page.keyboard.press(key)
        paths = [section.get_attribute("d") for section in page.locator("#scene .section").all()]
        numbers = [[float(number) for number in re.findall(r"-?[\d.]+", path)] for path in paths]
        assert [len(each) for each in numbers] == [12] * 5, "five hexagons"
        for each in numbers:
            assert all(0 <= x <= box["width"] for x in each[::2]) and all(0 <= y <= box["height"] for y in each[1::2])
    assert "static workspace at some heights" in page.locator("#robot").inner_text()


def test_a_goal_that_was_replaced_is_not_called_missed(open_report, detour):
    page = open_report(detour)
    chip = page.locator(".verdict li", has_text="goals reached")
    assert "1 of 2, 1 replaced on the way" in chip.inner_text()
    assert chip.get_attribute("class") != "bad"
    assert "replaced after" in page.locator("#facts").inner_text()


def test_who_holds_the_start_has_a_goal(open_report, gust):
    page = open_report(gust)
    assert "goal the start, held" in page.locator(".verdict").inner_text()


def test_disturbances_are_marked_in_time(open_report, gust):
    page = open_report(gust)
    pushes = gust.columns["plant.disturbanceForce.x"], gust.columns["plant.disturbanceTorque.z"], gust.columns["plant.disturbanceForce.y"]
    disturbed = [row for row in range(len(pushes[0])) if any(column[row] for column in pushes)]
    spans = page.evaluate("run.disturbedSpans")
    assert page.locator("#marks .disturbed-span").count() == len(spans) == 3
    inside = [any(low < gust.columns["time"][row] <= high + 1e-9 for low, high in spans) for row in disturbed]
    assert all(inside)
    assert "the platform is disturbed" in page.locator("#tensions").inner_text()


def test_equally_near_facets_are_all_named(open_report, paper):
    page = open_report(paper)
    page.keyboard.press("Home")
    assert "inside every facet, equally near" in page.locator("#plane-now").inner_text()


def test_why_a_goal_cannot_be_had_is_said(open_report, unreachable):
    page = open_report(unreachable)
    why = page.locator("#facts tr", has_text="Goal unreachable").inner_text()
    assert re.search(r"at rest at the goal cable \d would be slack; the last set point is 0\.\d+ m from it", why), why


def test_colours_of_tensions_are_the_same_in_every_run(open_report, paper, pushed):
    tops = [open_report(run).locator("#ramp-end").inner_text() for run in (paper, pushed)]
    assert tops[0] == tops[1] == "29.4 N and more"


def test_names_from_the_paper_stand_where_the_paper_speaks(open_report, paper, pushed):
    assert "Fig. 6" in open_report(paper).locator("body").inner_text()
    assert not re.search(r"Fig\. \d|\(15\)|law \(|°", open_report(pushed).locator("body").inner_text())


def test_the_tensions_are_above_the_fold(open_report, paper):
    page = open_report(paper, viewport={"width": 1280, "height": 800})
    box = page.locator("#tension-chart").bounding_box()
    assert box["y"] + box["height"] < 730


def luminance(colour):
    parts = [int(part) / 255 for part in colour]
    linear = [part / 12.92 if part <= 0.03928 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(a, b):
    high, low = sorted((luminance(a), luminance(b)), reverse=True)
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_lines_stand_out(open_report, paper, scheme):
    """Those of the domains had a contrast of 1.7; 3 is the least."""
    page = open_report(paper, color_scheme=scheme)
    page.evaluate("seek(7.0)")
    found = page.evaluate("""() => {
        const numbers = (text) => text.match(/[\\d.]+/g).map(Number);
        const card = numbers(getComputedStyle(document.querySelector(".card")).backgroundColor).slice(0, 3);
        const lines = [...document.querySelectorAll("#plane-picture path.domain, #plane-picture path.path, #plane-picture path.p-trail, #plane-picture path.hexagon, #scene path.ghost")];
        const probe = document.body.appendChild(document.createElement("i"));
        const named = ["--c1", "--c2", "--c3", "--c4", "--c5", "--c6", "--low", "--high", "--p"].map((name) => {
            probe.style.color = `var(${name})`;
            return [name, numbers(getComputedStyle(probe).color), 1];
        });
        const drawn = lines.map((line) => {
            const style = getComputedStyle(line);
            return [line.getAttribute("class"), numbers(style.stroke), Number(style.opacity)];
        });
        return { card, lines: [...named, ...drawn] };
    }""")
    for name, stroke, opacity in found["lines"]:
        seen = [opacity * s + (1 - opacity) * c for s, c in zip(stroke, found["card"])]
        assert contrast(seen, found["card"]) >= 3, (name, stroke, opacity)


def test_prints_on_white_with_everything_on_it(open_report, paper):
    page = open_report(paper, color_scheme="dark")
    page.emulate_media(media="print", color_scheme="dark")
    assert not page.locator(".transport").is_visible()
    ink = page.evaluate("getComputedStyle(document.documentElement).getPropertyValue('--ink').trim()")
    assert ink == "#16202c", "dark colours are for screens"
    for panel in ("scene", "tension-chart", "plane-picture", "positions-charts", "facts", "set-points"):
        assert page.locator(f"#{panel}").is_visible(), panel
    assert page.evaluate("getComputedStyle(document.querySelector('.scroll.tall')).maxHeight") == "none"


def test_the_goals_name_stands_on_no_other(open_report, paper, detour):
    for run in (paper, detour):
        page = open_report(run)
        for share in (0, 0.5, 1):
            page.evaluate(f"seek({share} * end)")
            boxes = [text.bounding_box() for text in page.locator("#plane-picture text").all() if text.is_visible()]
            name = page.locator("#plane-picture text", has_text="goal").bounding_box()
            over = [
                box for box in boxes
                if box != name
                and min(box["x"] + box["width"], name["x"] + name["width"]) - max(box["x"], name["x"]) > 1
                and min(box["y"] + box["height"], name["y"] + name["height"]) - max(box["y"], name["y"]) > 3
            ]
            assert over == [], (share, name)
