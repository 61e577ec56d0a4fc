"""The page as text: complete, valid, offline, and exact at the contact."""

import base64
import json
import re
from html.parser import HTMLParser
from itertools import pairwise

import numpy as np
import pytest
import trimesh

import firstcontact as fc
from firstcontact import examples
from firstcontact.errors import InputError
from firstcontact.motion.translation import Translation
from firstcontact.result import FirstContact, Status
from firstcontact.view import html
from firstcontact.view.assembly import SceneView
from view import scenes

VOID = {"meta", "link", "input"}


class Outline(HTMLParser):
    """Checks that tags nest, and collects attributes and the text of scripts."""

    def __init__(self, text):
        super().__init__()
        self.open, self.attributes, self.texts = [], [], {}
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.attributes += [(tag, name, value) for name, value in attrs]
        if tag not in VOID:
            self.open.append((tag, dict(attrs).get("id")))

    def handle_endtag(self, tag):
        assert self.open, f"</{tag}> closes nothing"
        assert self.open.pop()[0] == tag

    def handle_data(self, data):
        if self.open:
            self.texts[self.open[-1]] = self.texts.get(self.open[-1], "") + data


@pytest.fixture(scope="module")
def text():
    a, b = scenes.falling_spike()
    return html.page_text([fc.first_contact(a, b), fc.contact_intervals(a, b)])


def page_data(text):
    """With the shapes of elements in these, as the page has it."""
    data = json.loads(Outline(text).texts["script", "data"])
    for element in (x for pair in data["pairs"] for body in pair["bodies"] for x in body["elements"]):
        element |= data["shapes"][element["shape"]]
    return data


def doubles(encoded):
    return np.frombuffer(base64.b64decode(encoded), "<f8")


def test_page_is_well_formed(text):
    outline = Outline(text)
    assert outline.open == []
    ids = [value for _, name, value in outline.attributes if name == "id"]
    assert len(ids) == len(set(ids))
    assert "@@" not in text.replace(html._asset("three.js"), "")


def test_page_names_nothing_outside_itself(text):
    for _, name, value in Outline(text).attributes:
        if name in ("src", "href", "action", "data", "poster"):
            assert value.startswith("data:")
    # the only address in it is the name of the XHTML namespace, which is never fetched
    assert set(re.findall(r"https?://[\w./-]+", text)) <= {"http://www.w3.org/1999/xhtml"}
    assert "default-src 'none'" in text


def test_page_keeps_the_licence_of_three(text):
    assert "Permission is hereby granted, free of charge" in text
    assert "three.js authors" in text


def test_contact_time_is_an_exact_sample(text):
    (pair,) = page_data(text)["pairs"]
    assert pair["contact"] == 0.5
    moving = pair["bodies"][0]
    times, poses = doubles(moving["times"]), doubles(moving["poses"]).reshape(-1, 3, 4)
    (k,) = np.flatnonzero(times == 0.5)
    apex = np.array(moving["elements"][0]["vertices"]) * moving["size"]
    # the page's zero is the contact point
    assert np.array_equal(poses[k] @ [*apex, 1.0], np.zeros(3))


def test_facts_of_a_contact(text):
    (pair,) = page_data(text)["pairs"]
    rows = dict(pair["rows"])
    assert rows["time"] == "0.5"
    assert rows["point"] == "(0.125, 0.25, 0.5)"
    assert rows["in contact"] == "[0.5, 1.0]"
    assert [(e["kind"], e["index"]) for body in pair["bodies"] for e in body["elements"][:1]] == [
        ("vertex", scenes.APEX),
        ("face", scenes.TOP),
    ]
    assert pair["text"] == str(scenes.first_hit())


def test_names_cannot_break_out_of_the_page():
    result = fc.first_contact(*scenes.passing_by())
    text = html.page_text([result])
    outline = Outline(text)
    assert outline.open == []
    assert page_data(text)["pairs"][0]["names"][0] == "<b>mover</b></script>"
    assert "b" not in {tag for tag, _, _ in outline.attributes}


def test_two_results_about_one_pair_share_a_view():
    a, b = scenes.falling_spike()
    text = html.page_text([fc.first_contact(a, b), fc.contact_intervals(a, b), scenes.overlapping_at_start()])
    data = page_data(text)
    assert [pair["names"] for pair in data["pairs"]] == [["spike", "box"], ["mover", "box"]]


def test_a_mesh_is_written_once():
    a, b = scenes.falling_spike()
    results = [fc.first_contact(a, b), fc.first_contact(b.moving(Translation((0, 0, -1))), b)]
    assert len(page_data(html.page_text(results))["meshes"]) == 2


def test_page_of_large_meshes_stays_small():
    a = examples.noisy_sphere(100_000)
    b = examples.torus(100_000)
    result = FirstContact(Status.FREE, free_until=1.0, a=a.moving(Translation((0, 0, -1))), b=b)
    triangles = len(a.triangles) + len(b.triangles)
    assert len(html.page_text([result])) < 700_000 + 21 * triangles


@pytest.mark.parametrize("scale", [2.0**100, 2.0**-100])
def test_page_does_not_depend_on_the_unit(scale):
    def data(s):
        a, b = scenes.spike(), scenes.cube("box")
        big = [body.transformed(np.diag([s, s, s, 1.0])) for body in (a, b)]
        hit = fc.first_contact(big[0].moving(Translation((0, 0, -2 * s))), big[1])
        return page_data(html.page_text([hit]))

    one, other = data(1.0), data(scale)
    assert one["meshes"] == other["meshes"]
    poses = [[body["poses"] for body in d["pairs"][0]["bodies"]] for d in (one, other)]
    assert poses[0] == poses[1]


def test_write_page_returns_its_path(tmp_path):
    hit = scenes.first_hit()
    path = html.write_page(tmp_path / "hit.html", [hit])
    assert path.read_text(encoding="utf-8") == html.page_text([hit])
    assert hit.show(tmp_path / "again.html") == tmp_path / "again.html"


def test_write_page_without_a_path_opens_the_browser(monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    path = html.write_page(None, [scenes.first_hit()])
    try:
        assert opened == [path.as_uri()]
        assert path.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    finally:
        path.unlink()


def test_nothing_to_draw_is_an_input_error():
    with pytest.raises(InputError, match="empty"):
        html.page_text([])
    with pytest.raises(InputError, match="without its two bodies"):
        html.page_text([FirstContact(Status.FREE)])
    with pytest.raises(InputError, match="cannot draw 3"):
        html.page_text([3])


def test_a_solid_has_normals_and_a_mesh_has_none(text):
    assert all("normals" not in mesh for mesh in page_data(text)["meshes"])
    assert page_data(text)["pairs"][0]["shared"] == []
    for mesh in page_data(html.page_text([scenes.plugged()]))["meshes"]:
        vertices, normals = (np.frombuffer(base64.b64decode(mesh[key]), "<f4") for key in ("vertices", "normals"))
        assert len(vertices) == len(normals)


def test_the_contact_curve_of_solids_is_written_about_the_contact_point():
    (pair,) = page_data(html.page_text([scenes.plugged()]))["pairs"]
    shared = np.array(pair["shared"]).reshape(-1, 3)
    unit = np.linalg.norm(shared[0] - shared[45]) / 2  # half the diameter of the circle of radius 1
    assert np.allclose(shared / unit, scenes.plugged().contact_set.points - [1, 0, 0.5], atol=1e-12)
    assert dict(pair["rows"])["they share"] == "a conic arc"
    labels = [body["elements"][0]["label"] for body in pair["bodies"]]
    assert labels == ["plug.side", "plate.hole.rim.top"]


def test_touched_elements_of_solids_lie_at_the_contact():
    (pair,) = page_data(html.page_text([scenes.plugged()]))["pairs"]
    plate = pair["bodies"][1]
    rim = np.array(plate["elements"][0]["vertices"]).reshape(-1, 3) * plate["size"]
    pose = doubles(plate["poses"]).reshape(-1, 3, 4)[0]
    world = rim @ pose[:, :3].T + pose[:, 3]
    assert np.abs(world).min(axis=0)[2] == pytest.approx(0, abs=1e-12)  # the rim is level with the contact point
    assert np.linalg.norm(world, axis=1).min() < 1e-9


def test_an_unbounded_body_is_drawn_anew_for_every_pair():
    result = scenes.tip_on_floor()
    elsewhere = FirstContact(Status.FREE, free_until=1.0, a=scenes.plug().translated((99, 0, 5)), b=result.b)
    data = page_data(html.page_text([result, elsewhere]))
    assert len(data["meshes"]) == 4


@pytest.mark.thorough
def test_an_assembly_of_300_bodies_stays_below_10_mb():
    """Parts of a thousand triangles, one of 400,000; of 302 pairs the page has the two in contact, in order."""
    gears = [fc.examples.spur_gear(1000, teeth=8 + k) for k in range(20)]
    places = [(gear, k, i) for k, gear in enumerate(gears) for i in range(15)]
    copies = [gear.translated((4 * k, 4 * i, 0)).named(f"gear{k}.{i}") for gear, k, i in places]
    large = fc.examples.spur_gear(400_000).translated((0, 0, -9)).named("large")
    a, b = scenes.falling_spike()
    late = fc.first_contact(a.body.translated((0, 0, 1)).moving(a.motion), b)
    free = [fc.FirstContact(fc.Status.FREE, a=large, b=x, span=(0.0, 1.0), free_until=1.0) for x in copies]
    whole = SceneView({x.name: x for x in (large, b, *copies)}, "mm")
    text = html.page_text([*free, late, fc.first_contact(a, b)], whole)
    data = page_data(text)
    assert len(text) < 10_000_000 and data["unit"] == "mm" and len(data["assembly"]["bodies"]) == 302
    assert [pair["contact"] for pair in data["pairs"]] == [0.5, 1.0] and data["assembly"]["members"] == [[-1, 1]] * 2
    assert len(data["meshes"]) < 60  # copies are written once


@pytest.mark.thorough
def test_what_touches_is_written_once_of_bodies_that_are_alike():
    """155 contacts of 300 nuts took 37 MB: each told all of the faces that touch anew."""
    coin = fc.Polyhedron.from_trimesh(trimesh.creation.cylinder(1, 0.5, sections=64))
    bodies = [coin.translated((0, 0, k)).named(f"coin {k}") for k in range(9)]
    found = [fc.first_contact(a.moving(fc.Translation((0, 0, 1))), b) for a, b in pairwise(bodies)]
    text, one = html.page_text(found), html.page_text(found[:1])
    data, alone = (json.loads(Outline(x).texts["script", "data"]) for x in (text, one))
    told = [x for pair in data["pairs"] for body in pair["bodies"] for x in body["elements"]]
    assert len(data["shapes"]) == len(alone["shapes"]) < len(told) / 4
    assert any(x["kind"] == "face" for x in told)


def test_what_touches_is_its_own_where_meshes_are_alike_but_numbered_otherwise():
    """A cube of squares and one of triangles have one mesh, and their faces other numbers."""
    corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    squares = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    cube = fc.Polyhedron(corners, squares)
    found = [
        fc.first_contact(x.moving(Translation((4, 0, 0))), x.translated((4, 0.5, 0.25)))
        for x in (cube, fc.Polyhedron(corners, cube.triangles))
    ]
    both = page_data(html.page_text(found))["pairs"]
    alone = [page_data(html.page_text([x]))["pairs"][0] for x in found]
    for pair, own in zip(both, alone, strict=True):
        for body, same in zip(pair["bodies"], own["bodies"], strict=True):
            told, wanted = ([(x["kind"], x["index"], x["vertices"]) for x in y["elements"]] for y in (body, same))
            assert told == wanted
