"""The page in a real browser: its pixels, its objects, its controls and its address.

Skipped where there is no Chromium with its driver; with FIRSTCONTACT_REQUIRE_BROWSER=1 that is a failure.
"""

import base64
import json
import os
import shutil
import time

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.view.assembly import SceneView
from firstcontact.view.html import write_page
from mechanism import oracle
from view import scenes

WINDOW = "960,780"  # the page gets some 140 pixels less in height
FLAGS = [
    "--headless",
    "--no-sandbox",
    "--enable-unsafe-swiftshader",  # WebGL without a graphics card
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--hide-scrollbars",
    "--force-device-scale-factor=1",
    f"--window-size={WINDOW}",
]


def missing(what):
    if os.environ.get("FIRSTCONTACT_REQUIRE_BROWSER") == "1":
        pytest.fail(f"{what} not found, but FIRSTCONTACT_REQUIRE_BROWSER=1")
    pytest.skip(f"{what} not found: the page is not tried in a browser")


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    chromium = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    driver = shutil.which("chromedriver")
    if chromium is None or driver is None:
        missing("chromium with chromedriver")
    try:
        from selenium import webdriver
    except ModuleNotFoundError:
        missing("selenium")
    options = webdriver.ChromeOptions()
    options.binary_location = chromium  # given, as the driver is: nothing is looked up or downloaded
    for flag in [*FLAGS, f"--user-data-dir={tmp_path_factory.mktemp('chromium')}"]:
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"performance": "ALL", "browser": "ALL"})
    running = webdriver.Chrome(options=options, service=webdriver.ChromeService(executable_path=driver))
    running.get("about:blank")
    running.get_log("performance")  # what the browser's own start page asked for
    yield running
    running.quit()


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """Address of a page with six pairs: a contact with its intervals, one for each other status, and two solids."""
    a, b = scenes.falling_spike()
    results = [
        fc.first_contact(a, b),
        fc.contact_intervals(a, b),
        fc.first_contact(*scenes.passing_by()),
        scenes.undecided(),
        scenes.overlapping_at_start(),
        scenes.plugged(),
        scenes.tip_on_floor(),
    ]
    return write_page(tmp_path_factory.mktemp("page") / "all.html", results).as_uri()


@pytest.fixture
def opened(browser, page):
    """The page, freshly loaded; afterwards nothing may have gone wrong and nothing been fetched."""
    show(browser, page)
    yield browser
    complaints = [entry["message"] for entry in browser.get_log("browser")]
    assert [text for text in complaints if "GL Driver" not in text] == []
    messages = [json.loads(entry["message"])["message"] for entry in browser.get_log("performance")]
    asked = [m["params"]["request"]["url"] for m in messages if m["method"] == "Network.requestWillBeSent"]
    assert asked != [] and all(url.startswith(("file:", "data:", "about:")) for url in asked)


def show(browser, address):
    browser.get("about:blank")  # else another hash on the same file would not load it again
    browser.get(address)
    wait_until(lambda: browser.execute_script("return window.firstcontact?.scale"))  # is drawn with the first picture


def state(browser, expression):
    return browser.execute_script(f"return window.firstcontact.{expression}")


def wait_until(condition, seconds=120.0):  # a limit, not a measure: browsers are slow on busy machines
    end = time.monotonic() + seconds
    while not (value := condition()):
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.03)
    return value


def press(browser, identifier):
    browser.find_element("id", identifier).click()


def hash_of(browser):
    text = browser.execute_script("return location.hash.slice(1)")
    return dict(part.split("=") for part in text.split("&") if part)


def picture(browser):
    """(height, width, 3) int: what the window shows, without the card, the bar and the buttons."""
    hide = "for (const id of ['card', 'bar', 'views', 'triad']) document.getElementById(id).style.opacity = 0"
    browser.execute_script(hide)
    browser.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")
    encoded = browser.execute_async_script(
        """const [png, done] = arguments;
        const image = new Image();
        image.onload = () => {
          const {width, height} = image;
          const context = Object.assign(document.createElement("canvas"), {width, height}).getContext("2d");
          context.drawImage(image, 0, 0);
          const bytes = context.getImageData(0, 0, width, height).data;
          let text = "";
          for (let k = 0; k < bytes.length; k += 30000) {
            text += String.fromCharCode(...bytes.subarray(k, k + 30000));
          }
          done([width, height, btoa(text)]);
        };
        image.src = "data:image/png;base64," + png;""",
        browser.get_screenshot_as_base64(),
    )
    width, height, pixels = encoded
    return np.frombuffer(base64.b64decode(pixels), np.uint8).reshape(height, width, 4)[..., :3].astype(int)


def is_blue(pixels):
    return (pixels[..., 2] > pixels[..., 0] + 45) & (pixels[..., 0] < 130)  # the ghost is paler


def is_sand(pixels):
    return (pixels[..., 0] > pixels[..., 2] + 45) & (pixels[..., 1] > pixels[..., 2] + 15)


def is_accent(pixels):
    return (pixels[..., 0] > 180) & (pixels[..., 1] < 90) & (pixels[..., 2] < 110)


def around(pixels, place, reach=2):
    x, y = (round(c) for c in place)
    return pixels[y - reach : y + reach + 1, x - reach : x + reach + 1]


def test_the_picture_at_contact(opened):
    assert state(opened, "atContact") and state(opened, "time") == 0.5
    pixels = picture(opened)
    assert is_blue(pixels).sum() > 3000
    assert is_sand(pixels).sum() > 3000
    assert is_accent(around(pixels, state(opened, "contactPixel"))).all()
    # the marker and the arrow of the normal, which points up from the box
    x, y = (round(c) for c in state(opened, "contactPixel"))
    arrow = is_accent(pixels[y - 60 : y - 12, x - 30 : x + 31])
    assert arrow.any(axis=1).all()


@pytest.mark.thorough
def test_the_bodies_are_where_the_motion_puts_them(opened):
    beside = np.array([-14, -14])  # the arrow covers the middle of the spike
    state(opened, "setTime(0)")
    before, start = picture(opened), np.add(state(opened, "centrePixel(0)"), beside)
    state(opened, "toContact()")
    after, end = picture(opened), np.add(state(opened, "centrePixel(0)"), beside)
    assert end[1] > start[1] + 100 and abs(end[0] - start[0]) < 10  # it falls
    assert is_blue(around(before, start)).all() and is_blue(around(after, end)).all()
    assert not is_blue(around(after, start)).any()  # the ghost there is faint
    # at t = 1/2 the spike's centre is 1/2 above the contact point, which is the page's zero, and falls by 2 t
    half = state(opened, "pose(0)")[11]
    state(opened, "setTime(0.625)")
    assert state(opened, "pose(0)")[11] == pytest.approx(half / 2, rel=1e-12)


def test_the_objects_of_the_scene(opened):
    names = [entry["name"] for entry in state(opened, "objects")]
    for name in ("body spike", "body box", "ghost of spike", "path of spike", "contact", "normal"):
        assert names.count(name) == 1
    assert f"element spike vertex {scenes.APEX}" in names
    assert f"element box face {scenes.TOP}" in names
    assert "ghost of box" not in names and "path of box" not in names
    assert state(opened, "contactVisible") is True
    assert state(opened, "contactTime") == 0.5


def test_the_facts_beside_the_picture(opened):
    card = opened.find_element("id", "card").text
    for text in ("contact", "vertex 0", "face 1", "0.5", "(0.125, 0.25, 0.5)", "(0, 0, 1)", "[0.5, 1.0]"):
        assert text in card
    assert str(scenes.first_hit()).splitlines()[0] in card


RECORD = """
const page = window.firstcontact, seen = window.seen = [];
page.setTime(0.4);
document.getElementById("play").click();
(function look() {
    seen.push([page.time, page.atContact, page.isPlaying]);
    if (page.time > 0.55) document.getElementById("play").click();
    else requestAnimationFrame(look);
})();
"""
"""Plays past the contact and pauses there; the page itself records every frame: asking from here may take too long."""


@pytest.mark.thorough
def test_play_moves_time_on_and_rests_at_the_contact(opened):
    opened.execute_script(RECORD)
    wait_until(lambda: state(opened, "time") > 0.55 and not state(opened, "isPlaying"))
    stopped = state(opened, "time")
    seen = opened.execute_script("return window.seen")
    times = [t for t, _, _ in seen]
    assert times == sorted(times) and times[0] < 0.42 and all(playing for _, _, playing in seen)
    rests = [t for t, at_contact, _ in seen if at_contact]
    assert rests and set(rests) == {0.5}
    time.sleep(0.2)
    assert state(opened, "time") == stopped
    press(opened, "contact")
    assert state(opened, "time") == 0.5


def test_play_ends_at_the_end(opened):
    state(opened, "setTime(0.97)")
    press(opened, "play")
    wait_until(lambda: not state(opened, "isPlaying"))
    assert state(opened, "time") == 1.0


def test_the_slider_changes_time_and_address(opened):
    from selenium.webdriver import ActionChains

    slider = opened.find_element("id", "slider")
    ActionChains(opened).drag_and_drop_by_offset(slider, -120, 0).perform()
    moved = state(opened, "time")
    assert 0.0 < moved < 0.49
    wait_until(lambda: hash_of(opened).get("t") == repr(moved))
    ActionChains(opened).click(slider).perform()
    assert state(opened, "time") == pytest.approx(0.5, abs=0.01)
    assert float(opened.find_element("id", "time").text) == pytest.approx(state(opened, "time"), abs=1e-4)


def test_the_address_sets_the_time(opened, page):
    show(opened, f"{page}#t=0.4")
    assert state(opened, "time") == 0.4
    assert state(opened, "atContact") is False
    opened.execute_script("location.hash = '#t=0.75'")
    wait_until(lambda: state(opened, "time") == 0.75)
    opened.execute_script("location.hash = '#t=nonsense'")
    time.sleep(0.1)
    assert state(opened, "time") == 0.75


@pytest.mark.thorough
def test_the_address_keeps_the_camera(opened, page):
    from selenium.webdriver import ActionChains

    before = state(opened, "camera")
    stage = opened.find_element("id", "stage")
    ActionChains(opened).drag_and_drop_by_offset(stage, 90, 30).perform()
    turned = state(opened, "camera")
    assert np.abs(np.subtract(turned, before)).max() > 0.1
    kept = wait_until(lambda: hash_of(opened).get("camera"))
    show(opened, f"{page}#t=0.5&camera={kept}")
    assert state(opened, "camera") == pytest.approx(turned, rel=1e-4, abs=1e-4)
    press(opened, "whole")
    assert state(opened, "camera") == pytest.approx(before, rel=1e-6, abs=1e-6)
    wait_until(lambda: "camera" not in hash_of(opened))


def test_the_timeline(opened):
    bars = "[...document.querySelectorAll('#timeline i')]"
    kinds = opened.execute_script(f"return {bars}.map(i => [i.className, i.style.left, i.style.width])")
    assert kinds == [["free", "0%", "50%"], ["contact last", "50%", "50%"]]
    tick = opened.execute_script("return document.querySelector('#timeline b').style.left")
    assert tick == "50%"


@pytest.mark.share(2)
@pytest.mark.parametrize(
    "pair, status, kinds, moment",
    [
        (1, "FREE", ["free last"], None),
        (2, "UNDECIDED", ["free", "undecided last"], None),
        (3, "INITIAL_CONTACT", ["not-asked last"], 0.0),
    ],
)
def test_other_answers(opened, pair, status, kinds, moment):
    from selenium.webdriver.support.ui import Select

    Select(opened.find_element("id", "pairs")).select_by_index(pair)
    assert (state(opened, "pair"), state(opened, "status")) == (pair, status)
    assert state(opened, "time") == 0.0 and state(opened, "contactTime") == moment
    assert opened.find_element("id", "contact").is_enabled() is (moment is not None)
    bars = "[...document.querySelectorAll('#timeline i')]"
    assert opened.execute_script(f"return {bars}.map(i => i.className)") == kinds
    pixels = picture(opened)
    assert is_blue(pixels).sum() > 2000 and is_sand(pixels).sum() > 2000
    wait_until(lambda: hash_of(opened) == {"t": "0", "pair": str(pair)})


def test_a_name_is_text_and_steps_are_followed(opened, page):
    show(opened, f"{page}#pair=1&t=2")
    names = [entry["name"] for entry in state(opened, "objects")]
    assert "body <b>mover</b></script>" in names
    turned = state(opened, "pose(0)")
    # after step one and half of the three quarter turns: (3, 0, 1) turned by 135 degrees about z
    c = np.sqrt(0.5)
    assert [turned[0], turned[1], turned[4]] == pytest.approx([-c, -c, c], abs=1e-5)


SOLIDS, ON_FLOOR = 4, 5


@pytest.mark.thorough
def test_solids_are_drawn_with_their_contact_curve(opened, page):
    show(opened, f"{page}#pair={SOLIDS}")
    wait_until(lambda: state(opened, "pair") == SOLIDS)
    assert state(opened, "time") == 0.75 and state(opened, "atContact") is True
    names = [entry["name"] for entry in state(opened, "objects")]
    for name in ("body plug", "body plate", "plate edges", "ghost of plug", "path of plug", "contact set"):
        assert names.count(name) == 1
    assert "normal" not in names  # it is not the same all around
    assert "element plug.side face 0" in names
    assert any(name.startswith("element plate.hole.rim.top edge") for name in names)
    card = opened.find_element("id", "card").text
    for text in ("plug.side", "plate.hole.rim.top", "a conic arc", "0.75"):
        assert text in card
    pixels = picture(opened)
    assert is_blue(pixels).sum() > 2000 and is_sand(pixels).sum() > 3000
    assert is_accent(around(pixels, state(opened, "contactPixel"))).all()


def test_the_contact_curve_is_where_the_circle_is(opened, page):
    show(opened, f"{page}#pair={SOLIDS}")
    wait_until(lambda: state(opened, "pair") == SOLIDS)
    pixels = picture(opened)
    curve = state(opened, "contactCurve")
    assert len(curve) == 91
    assert np.allclose(curve[0], state(opened, "contactPixel"), atol=0.5)
    on_screen = [is_accent(around(pixels, place, reach=1)).any() for place in curve]
    assert np.mean(on_screen) > 0.95


@pytest.mark.thorough
def test_solids_are_shaded_smoothly_and_meshes_flat(opened, page):
    smooth = {entry["name"]: entry["smooth"] for entry in state(opened, "objects")}
    assert smooth["spike surface"] is False and smooth["box surface"] is False
    show(opened, f"{page}#pair={ON_FLOOR}")
    wait_until(lambda: state(opened, "pair") == ON_FLOOR)
    smooth = {entry["name"]: entry["smooth"] for entry in state(opened, "objects")}
    assert smooth["plug surface"] is True and smooth["floor surface"] is True
    press(opened, "closer")
    pixels = picture(opened)
    x, y = (round(c) for c in state(opened, "contactPixel"))
    row = pixels[y - 100, x - 200 : x + 200]
    brightness = row[is_blue(row)].sum(axis=1)
    assert len(brightness) > 60 and np.ptp(brightness) > 10  # round: lit from one side
    assert np.percentile(np.abs(np.diff(brightness)), 80) <= 4


@pytest.mark.thorough
def test_the_slider_moves_solids(opened, page):
    show(opened, f"{page}#pair={ON_FLOOR}&t=0.25")
    wait_until(lambda: state(opened, "time") == 0.25)
    assert state(opened, "atContact") is False
    above = state(opened, "centrePixel(0)")
    press(opened, "contact")
    assert state(opened, "time") == 0.5
    assert state(opened, "centrePixel(0)")[1] > above[1] + 20
    assert "element plug.apex vertex 0" in [entry["name"] for entry in state(opened, "objects")]


# -- intersection curves, and surfaces that deform ------------------------------------------------------------

LOOP, CROSSING, FLAT, CUSP, ROLLER = range(5)


@pytest.fixture(scope="module")
def surfaces(tmp_path_factory):
    """Address of a page with four intersection curves, and with a surface that deforms."""
    results = [scenes.cone_and_pipe(), scenes.crossing_pipes(), scenes.flat_pieces(), scenes.cusped(), scenes.roller()]
    return write_page(tmp_path_factory.mktemp("surfaces") / "curves.html", results).as_uri()


def rgb(text):
    return np.array([int(text[k : k + 2], 16) for k in (1, 3, 5)])


def share_of(pixels, layer):
    """How much of a layer shows its colour within two pixels, of what is in the window."""
    places = np.array(layer["pixels"])
    if "line" in layer["kind"]:  # ends of segments
        part = np.linspace(0, 1, 40)[:, None]
        places = np.concatenate([(1 - part) * p + part * q for p, q in places.reshape(-1, 2, 2)])
    places = places[np.all((places > 10) & (places < np.array(pixels.shape[1::-1]) - 10), axis=1)]
    _, spread = np.unique(np.round(places / 6), axis=0, return_index=True)
    near = [np.abs(around(pixels, p) - rgb(layer["colour"])).sum(axis=2).min() < 90 for p in places[spread]]
    return np.mean(near)


@pytest.mark.thorough
def test_an_intersection_curve_with_its_legend(opened, surfaces):
    show(opened, surfaces)
    assert state(opened, "status") == "CURVE" and not opened.find_element("id", "bar").is_displayed()
    labels = [label.text for label in opened.find_elements("css selector", "#layers label")]
    layers = {layer["name"]: layer for layer in state(opened, "layers")}
    assert labels == ["cone", "cone: rulings", "pipe", "pipe: rulings", *layers]
    assert list(layers) == ["common rulings", "component 1, closed", "isolated points"]
    pixels = picture(opened)
    assert all(share_of(pixels, layer) > 0.9 for layer in layers.values())
    for name in labels:  # everything off, from the top to the bottom of the legend
        box = opened.find_element("css selector", f"#layers input[name='{name}']")
        opened.execute_script("arguments[0].click()", box)
    pixels = picture(opened)
    assert all(share_of(pixels, layer) == 0 for layer in layers.values())
    assert not is_blue(pixels).any() and not is_sand(pixels).any()
    hidden = {entry["name"] for entry in state(opened, "objects") if not entry["visible"]}
    assert hidden >= {"layer component 1, closed", "layer isolated points", "cone surface", "pipe edges"}


@pytest.mark.thorough
def test_singular_points_and_overlaps(opened, surfaces):
    show(opened, f"{surfaces}#pair={FLAT}")
    (overlap,) = wait_until(lambda: state(opened, "pair") == FLAT and state(opened, "layers"))
    pixels = picture(opened)
    pink = (pixels[..., 0] > 180) & (pixels[..., 1] < 120) & (pixels[..., 2] > 90)
    x, y = np.array(overlap["pixels"]).T
    inside = pink[round(y.min()) : round(y.max()) + 1, round(x.min()) : round(x.max()) + 1]
    assert inside.sum() > 0.98 * pink.sum() > 2000
    for pair, kind, count in ((CROSSING, "node", 2), (CUSP, "cusp", 1)):
        opened.execute_script(f"location.hash = '#pair={pair}'")
        lines, spots = wait_until(lambda pair=pair: state(opened, "pair") == pair and state(opened, "layers"))
        assert (lines["kind"], spots["kind"], len(spots["pixels"])) == ("line", kind, count)
        pixels = picture(opened)
        # a ring is white in the middle, a diamond dark
        bright = [around(pixels, place, reach=1).mean() for place in spots["pixels"]]
        assert all((b > 240) == (kind == "node") for b in bright)
        assert share_of(pixels, lines) > 0.8


@pytest.mark.thorough
def test_a_surface_deforms_with_the_time(opened, surfaces):
    show(opened, f"{surfaces}#pair={ROLLER}")
    wait_until(lambda: state(opened, "pair") == ROLLER)
    assert opened.find_element("id", "bar").is_displayed() and "deforms" in opened.find_element("id", "card").text
    centres = []
    for t in (-1.5, 0.0):
        state(opened, f"setTime({t})")
        rows, columns = np.nonzero(is_blue(picture(opened)))
        assert len(rows) > 1000
        centres.append((columns.mean(), rows.mean()))
    (right, low), (left, high) = centres
    assert low > high + 60 and abs(right - left) > 30  # y = -T and z = -T^2


@pytest.fixture(scope="module")
def assembly(tmp_path_factory):
    """Address of a page of 60 cubes in a row and a sled that strikes 20 of them, one after the other."""
    sled = scenes.cube("sled").translated((-2, 0, 0)).moving(fc.Translation((40, 0, 0)))
    posts = [scenes.cube(f"post{k}").translated((2 * k, 0, 0.25)) for k in range(60)]
    results = [fc.first_contact(sled, post) for post in posts]
    bodies = {body.name: body for body in (sled, *posts)}
    path = tmp_path_factory.mktemp("assembly") / "all.html"
    return write_page(path, reversed(results), SceneView(bodies, "mm")).as_uri()


@pytest.mark.thorough
def test_an_assembly_steps_through_its_contacts(opened, assembly):
    """The k-th post is struck when the sled has gone 1 + 2 k of 40."""
    show(opened, assembly)
    assert state(opened, "partCount") == 61 and state(opened, "pairCount") == 20
    assert opened.find_element("id", "count").text == "1 of 20" and state(opened, "contactTime") == 1 / 40
    assert not opened.find_element("id", "before").is_enabled()
    for k in range(1, 20):
        press(opened, "after")
        assert state(opened, "contactTime") == (1 + 2 * k) / 40 and state(opened, "time") == (1 + 2 * k) / 40
    assert not opened.find_element("id", "after").is_enabled() and hash_of(opened) is not None
    ticks = opened.find_elements("css selector", "#ticks button")
    assert len(ticks) == 20 and [tick.get_attribute("class") for tick in ticks].index("chosen") == 19
    assert ticks[2].get_attribute("title") == "sled and post2: 0.125"
    opened.execute_script("arguments[0].click()", ticks[2])
    assert state(opened, "contactTime") == 0.125


@pytest.mark.thorough
def test_parts_are_hidden_and_shown(opened, assembly):
    show(opened, assembly)
    press(opened, "all")
    before = picture(opened)
    opened.execute_script("document.getElementById('parts').open = true")
    boxes = opened.find_elements("css selector", "#partsList input")
    assert [box.get_attribute("name") for box in boxes[:3]] == ["sled", "post0", "post1"]
    for box in boxes[2:]:
        opened.execute_script("arguments[0].click()", box)
    assert opened.find_element("id", "partsCount").get_attribute("textContent") == "61 parts, 59 hidden"
    visible = {entry["name"] for entry in state(opened, "objects") if entry["visible"]}
    assert "part post1" not in visible and "body sled" in visible
    assert np.abs(picture(opened) - before).sum(axis=2).max() > 20
    opened.execute_script("arguments[0].click()", boxes[0])
    assert "body sled" not in {entry["name"] for entry in state(opened, "objects") if entry["visible"]}


@pytest.mark.thorough
def test_the_scale_has_the_unit_of_the_scene(opened, assembly, page):
    show(opened, assembly)
    near = state(opened, "scale")
    press(opened, "all")
    wait_until(lambda: state(opened, "scale") != near)
    lengths = [text.split() for text in (near, state(opened, "scale"))]
    assert [unit for _, unit in lengths] == ["mm", "mm"] and float(lengths[0][0]) < float(lengths[1][0])
    show(opened, page)
    assert float(state(opened, "scale")) > 0


@pytest.mark.thorough
def test_faces_are_coloured_near_the_contact_alone(opened, tmp_path):
    """A small cube on a plate of a hundred times its size: its red does not reach the plate's border."""
    plate = fc.examples.box((100.0, 100.0, 1.0)).translated((0, 0, -1)).named("plate")
    hit = fc.first_contact(scenes.cube("cube").translated((0, 0, 2)).moving(fc.Translation((0, 0, -4))), plate)
    show(opened, write_page(tmp_path / "near.html", [hit]).as_uri())
    press(opened, "whole")
    pixels = picture(opened)
    red = (pixels[..., 0] > pixels[..., 1] + 60) & (pixels[..., 0] > pixels[..., 2] + 50)
    sand = is_sand(pixels)
    assert red.any() and sand.sum() > 20 * red.sum()


# -- joints ---------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def jointed(tmp_path_factory):
    """Address of a page of the arm's first contacts, with the arm as a whole."""
    course = scenes.jointed()
    bodies = {body.name: body for own in course.bodies.values() for body in own}
    path = tmp_path_factory.mktemp("jointed") / "arm.html"
    return write_page(path, course.first_contacts(), SceneView(bodies, "mm")).as_uri()


def claw_by_hand(shoulder, elbow, grip):
    """The claw's rotation and its centre in the world, by products of SciPy's rotations."""
    pose = oracle.turn((0, 0, 1), (0, 0, 0), shoulder) @ oracle.turn((0, 1, 2), (2, 0, 0), elbow)
    pose = pose @ oracle.shift((1, 0, 0), grip)
    return pose[:3, :3], (pose @ (4, 0, 0.5, 1))[:3]


def claw_on_page(browser):
    """The same of the chosen pair's claw, as the page draws it."""
    data = browser.execute_script("return JSON.parse(document.getElementById('data').textContent)")
    pair = data["pairs"][state(browser, "pair")]
    T = np.reshape(state(browser, f"pose({pair['names'].index('claw')})"), (3, 4))
    return T[:, :3], pair["origin"] + pair["unit"] * T[:, 3]


def check_claw(browser, values):
    for found, expected in zip(claw_on_page(browser), claw_by_hand(*values), strict=True):
        assert found == pytest.approx(expected, abs=1e-13)


def joint_values(browser):
    return {joint["name"]: joint["value"] for joint in state(browser, "joints")}


def sliders(browser):
    found = browser.find_elements("css selector", "#jointList input")
    return {x.get_attribute("name"): float(x.get_attribute("value")) for x in found}


@pytest.mark.thorough
def test_sliders_of_joints_follow_the_time(opened, jointed):
    """Values are those of SciPy's natural spline, the claw is where products of SciPy's rotations have it."""
    from scipy.interpolate import CubicSpline

    show(opened, jointed)
    assert set(sliders(opened)) == {"shoulder", "elbow", "grip"}
    assert opened.find_element("id", "jointsCount").text == "3 joints"
    splines = [CubicSpline([0, 1, 2], x, bc_type="natural") for x in ([0, 90, 120], [0, 30, 60])]
    pair = state(opened, "pair")  # fore and claw, which touch at the start
    for t in (0.0, 0.4, 1.0, 1.7, 2.0):
        show(opened, f"{jointed}#pair={pair}&t={t}")
        wait_until(lambda t=t: state(opened, "time") == t)
        shoulder, elbow = (float(x(t)) for x in splines)
        expected = {"shoulder": shoulder, "elbow": elbow, "grip": elbow / 100 + 0.125}
        assert joint_values(opened) == pytest.approx(expected, abs=1e-12)
        assert sliders(opened) == pytest.approx(expected, abs=1e-12)
        check_claw(opened, expected.values())
    texts = [x.text.split("\n") for x in opened.find_elements("css selector", "#jointList li")]
    assert texts == [["shoulder", "120.00 deg", "0", "180"], ["elbow", "60.00 deg", "-150", "150"],
                     ["grip", "0.7250 mm", "-1.375", "1.625"]]  # fmt: skip


@pytest.mark.thorough
def test_a_joint_moved_by_hand_leaves_the_path(opened, jointed):
    from selenium.webdriver.common.keys import Keys

    show(opened, jointed)
    pair = state(opened, "pair")
    assert state(opened, "atContact") and not opened.find_element("id", "offPath").is_displayed()
    before = joint_values(opened)
    slider = opened.find_element("css selector", "#jointList input[name=elbow]")
    slider.send_keys(Keys.ARROW_LEFT, Keys.ARROW_LEFT)
    after = joint_values(opened)
    assert after["elbow"] < before["elbow"] - 1 and after["shoulder"] == before["shoulder"]
    assert after["grip"] == pytest.approx(after["elbow"] / 100 + 0.125, abs=1e-12)
    note = opened.find_element("id", "offPath")
    assert note.is_displayed() and "off the path" in note.text
    assert not state(opened, "atContact") and not state(opened, "contactVisible")
    check_claw(opened, after.values())
    # the follower moves its leader, and the address keeps both
    opened.find_element("css selector", "#jointList input[name=grip]").send_keys(Keys.HOME)
    moved = joint_values(opened)
    assert moved["grip"] == pytest.approx(moved["elbow"] / 100 + 0.125, abs=1e-12) and moved["elbow"] < after["elbow"]
    kept = wait_until(lambda: (x := hash_of(opened).get("joints")) and x.split(",")[1] == repr(moved["elbow"]) and x)
    show(opened, f"{jointed}#pair={pair}&joints={kept}")
    wait_until(lambda: state(opened, "byHand"))
    assert joint_values(opened) == moved
    press(opened, "back")
    assert not state(opened, "byHand") and joint_values(opened) == before and state(opened, "contactVisible")
    assert not opened.find_element("id", "offPath").is_displayed()


@pytest.mark.thorough
def test_playing_goes_back_to_the_path(opened, jointed):
    from scipy.interpolate import CubicSpline

    show(opened, f"{jointed}#t=0.2")
    wait_until(lambda: state(opened, "time") == 0.2)
    opened.execute_script("const s = document.querySelector('#jointList input[name=shoulder]');"
                          "s.value = 150; s.dispatchEvent(new Event('input'));")  # fmt: skip
    assert state(opened, "byHand") and joint_values(opened)["shoulder"] == 150
    press(opened, "play")
    wait_until(lambda: state(opened, "time") > 0.25)
    state(opened, "pause()")  # a press would begin anew where a slow browser has come to the end
    shoulder = CubicSpline([0, 1, 2], [0, 90, 120], bc_type="natural")(state(opened, "time"))
    assert not state(opened, "byHand") and joint_values(opened)["shoulder"] == pytest.approx(float(shoulder), abs=1e-9)


@pytest.mark.thorough
def test_all_parts_move_with_their_joints(opened, jointed):
    """What is behind the pair is posed by the same joints."""
    show(opened, jointed)
    press(opened, "all")
    before = picture(opened)
    opened.execute_script("const s = document.querySelector('#jointList input[name=shoulder]');"
                          "s.value = 10; s.dispatchEvent(new Event('input'));")  # fmt: skip
    assert np.abs(picture(opened) - before).sum(axis=2).max() > 60


def test_pages_without_joints_have_no_sliders(opened):
    assert not opened.find_element("id", "joints").is_displayed() and state(opened, "joints") == []
