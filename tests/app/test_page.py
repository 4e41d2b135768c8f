"""The page in a headless Chromium, as a visitor uses it; the machine's own is driven, none is downloaded."""

import re
import shutil

import pytest

pytest.importorskip("uvicorn")
pytest.importorskip("starlette")
pytest.importorskip("playwright")

from app_site import CASE, served
from playwright.sync_api import expect, sync_playwright

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
CHROMIUM = next(filter(None, map(shutil.which, NAMES)), None)
pytestmark = [
    pytest.mark.slow,
    pytest.mark.timing,  # it waits for runs: alone
    pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium on the path"),
]
PATIENCE = 60_000  # ms


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page")
    (folder / "tiny.py").write_text(CASE)
    with served(folder / "tiny.py", folder / "runs") as visitor:
        yield f"http://127.0.0.1:{visitor.port}/"


@pytest.fixture(scope="module")
def browser():
    with sync_playwright() as driver:
        chromium = driver.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield chromium
        chromium.close()


@pytest.fixture
def page(browser, address):
    """A page of a new visitor; whatever it complains of fails the test."""
    visitor = browser.new_context(viewport={"width": 1500, "height": 940}, accept_downloads=True)
    made, complaints = visitor.new_page(), []
    made.set_default_timeout(PATIENCE)
    expect.set_options(timeout=PATIENCE)
    made.on("pageerror", lambda error: complaints.append(str(error)))
    made.on("console", lambda line: complaints.append(line.text) if line.type == "error" else None)
    made.goto(address)
    expect(made.locator("#scene option")).to_have_count(2)
    yield made
    visitor.close()
    assert [line for line in complaints if "status of 4" not in line] == []


def picture(page):
    return page.evaluate("document.getElementById('picture').toDataURL()")


def number(page, name):
    cell = page.locator("#numbers tr", has_text=name).locator("td").nth(1)
    return float(re.match(r"[\d.]+", cell.inner_text())[0])


def run(page, **values):
    """Set values, in the units of the page, run, and wait for the first picture."""
    for name, value in values.items():
        page.fill(f"#knob-{name}", str(value))
    page.click("#run")
    expect(page.locator("#stop")).to_be_enabled()
    expect(page.locator("#picture")).to_have_attribute("data-step", re.compile(r"\d+"))
    expect(page.locator("#hint")).to_be_hidden()


def test_a_visit(page, browser, address):
    """Preset, thickness, run, a picture that changes, replay, stop, reload, go on, compare."""
    page.select_option("#case", "figure3")
    expect(page.locator("#scene option")).to_have_text(["three hypotheses"])
    expect(page.locator("#hint")).to_contain_text("Figure 3: pattern, tension and growth")
    expect(page.locator("#side h2", has_text="Numbers")).to_be_hidden()
    expect(page.locator("#knob-kinetics option")).to_have_count(10)
    expect(page.locator("#knob-half_waves")).to_have_value("")  # the case chooses
    expect(page.locator("#knob-half_waves")).to_have_attribute("placeholder", "auto")
    page.select_option("#case", "tiny")
    expect(page.locator("#scene option")).to_have_count(2)
    expect(page.locator("#knob-thickness")).to_have_value("8")  # mm
    expect(page.locator("#knob-young_gray")).to_have_value("1")  # kPa
    run(page, thickness=9, steps=10)
    expect(page.locator("#left")).to_have_text("done")
    page.locator("#time").fill("0")
    first = picture(page)
    assert number(page, "growth factor") == 1
    page.locator("#time").press("End")
    last = picture(page)
    assert last != first
    assert number(page, "growth factor") == pytest.approx(1.2)
    page.select_option("#field", "layer")
    assert picture(page) != last
    page.select_option("#field", "growth")
    expect(page.locator("#runs li").first).to_contain_text("thickness 9 mm")

    run(page, steps=1500)  # and stop, look again, go on, stop
    expect(page.locator("#left")).to_contain_text("left")
    page.click("#stop")
    expect(page.locator("#left")).to_have_text("interrupted")
    page.click("#resume")
    expect(page.locator("#left")).to_contain_text("left")
    page.reload()
    expect(page.locator("#left")).to_contain_text("left")
    expect(page.locator("#knob-thickness")).to_have_value("9")
    expect(page.locator("#runs li")).to_have_count(2)
    page.click("#stop")
    expect(page.locator("#left")).to_have_text("interrupted")

    alone = picture(page)
    page.get_by_role("button", name="compare").click()
    expect(page.locator("#numbers")).to_have_attribute("data-compared", "yes")
    assert picture(page) != alone
    expect(page.locator("#curves polyline")).to_have_count(6)


def test_a_link_carries_case_scene_and_parameters(page, browser, address):
    page.select_option("#scene", "half")
    page.fill("#knob-thickness", "9.5")
    page.locator("#knob-pattern").uncheck()
    link = page.url
    other = browser.new_context().new_page()
    other.goto(link)
    expect(other.locator("#scene")).to_have_value("half")
    expect(other.locator("#knob-thickness")).to_have_value("9.5")
    expect(other.locator("#knob-pattern")).not_to_be_checked()
    other.click("#run")
    expect(other.locator("#left")).to_have_text("done", timeout=PATIENCE)
    words = "--set thickness=0.0095 --set pattern=off --quick --only half"
    expect(other.locator("#about")).to_contain_text(words)
    with other.expect_download() as saved:
        other.get_by_role("button", name="CSV").click()
    assert saved.value.suggested_filename.endswith("history.csv")
    other.context.close()
    page.goto("about:blank")
    page.goto(f"{address}#case=tiny&thicknes=1")
    expect(page.locator("#notice")).to_have_text("tiny has no parameter thicknes; its own values are shown.")


def test_a_case_that_is_left_before_its_scenes_are_known_leaves_nothing_behind(page):
    waiting = []
    page.route("**/api/cases/figure3/scenes", lambda route: waiting.append(route))
    page.select_option("#case", "figure3")
    expect(page.locator("#scene option")).to_have_count(0)
    page.select_option("#case", "tiny")
    expect(page.locator("#scene option")).to_have_text(["whole", "half"])
    with page.expect_response("**/api/cases/figure3/scenes"):
        waiting.pop().continue_()
    page.wait_for_timeout(200)
    expect(page.locator("#scene option")).to_have_text(["whole", "half"])
    expect(page.locator("#notice")).to_be_hidden()
    page.select_option("#case", "figure3")
    expect(page.locator("#scene option")).to_have_text(["three hypotheses"])


def test_while_the_scenes_of_a_case_load_that_of_the_case_before_is_neither_run_nor_linked(page):
    waiting = []
    page.route("**/api/cases/figure2/scenes", lambda route: waiting.append(route))
    expect(page.locator("#run")).to_be_enabled()
    page.select_option("#case", "figure2")
    expect(page.locator("#scene option")).to_have_count(0)
    expect(page.locator("#run")).to_be_disabled()
    page.fill("#knob-thickness", "2.6")  # which writes the link
    expect(page).to_have_url(re.compile("case=figure2"))
    assert "whole" not in page.url
    waiting.pop().continue_()
    expect(page.locator("#run")).to_be_enabled()
    expect(page).to_have_url(re.compile("scene=[^&]"))


@pytest.mark.parametrize("values", [[1.0, 1.0, 1.0003], [0.0, 0.0], [5.0, 5.0], [-2.0, -2.0, -2.0]])
def test_numbers_that_hardly_change_have_ticks_that_can_be_told_apart(page, values):
    """Of an index next to 1, the ticks were 1, 1.0e+0, 1.0e+0, 1.0e+0."""
    drawn = """async values => {
        const script = document.querySelector("script[type=module]").src;
        const {chart} = await import(script.replace("page.js", "curves.js"));
        const series = [{points: values.map((v, k) => [k, v]), color: "red"}];
        const made = chart("it", "time", series, 2, 1, [300, 180]);
        return [...made.querySelectorAll("text[text-anchor=end]")].map(one => one.textContent);
    }"""
    ticks = page.evaluate(drawn, values)
    assert len(ticks) > 1
    assert len(set(map(float, ticks))) == len(ticks)
    assert not any("e" in tick for tick in ticks)


def test_a_narrow_page_gives_the_picture_its_whole_width(page):
    page.set_viewport_size({"width": 800, "height": 900})
    assert page.locator("#stage").bounding_box()["width"] > 700
    assert page.evaluate("document.documentElement.scrollWidth") <= 800


def test_what_is_refused_is_said(page):
    page.fill("#knob-thickness", "80")
    page.click("#run")
    expect(page.locator("#notice")).to_contain_text("thickness=0.08 is out of range")
    page.fill("#knob-thickness", "20")
    page.fill("#knob-radius", "30")
    page.click("#run")
    expect(page.locator("#notice")).to_contain_text("must be at most half of radius=0.03")
    expect(page.locator("#runs .status").first).to_have_text("refused")
