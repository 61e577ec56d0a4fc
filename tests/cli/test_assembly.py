"""Scenes that answer as a whole: what is asked, what may touch, what is printed of many, and meshes without a scene."""

import csv
import json
import math

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.io.meshes import write_mesh

from .conftest import CUBE

ALLOW = "[[allow]]\n"
MOVES = '[body.{}.motion]\ntype = "translation"\nvector = [{}, 0, 0]\n'


def cube(name, x, z=0):
    return f'[body.{name}]{CUBE}at = ["{x}", 0, "{z}"]\n'


STAND = cube("sled", 0) + MOVES.format("sled", 4) + cube("floor", 0, -1) + cube("wall", 3)
"""The sled stands on the floor, which is as wide as it is, and strikes the wall at half its way."""


def test_a_start_that_touches_is_contact_unless_it_is_allowed(command, scene):
    code, out, _ = command("check", scene(STAND))
    assert code == 1 and "sled and floor: INITIAL_CONTACT (touching)" in out
    code, out, _ = command("check", scene(STAND + ALLOW + 'touching = true\nwhy = "it slides"\n'))
    assert code == 1 and "sled and floor: FREE" in out
    assert "allowed: touching at the start (touching = true: it slides)" in out
    assert "sled and wall: CONTACT at time 0.5" in out and "sled has moved 2 of 4: time is the share" in out


RULES = ['pair = ["sl*", "floor"]', 'pair = ["floor", "sled"]', 'body = "fl??r"', "touching = true"]


@pytest.mark.parametrize("rule", RULES)
def test_what_is_allowed_does_not_count(command, scene, rule):
    path = scene(STAND.replace('at = ["3"', 'at = ["30"') + ALLOW + rule + "\n")
    code, out, _ = command("check", path, "--json", "-")
    checks = {(x["a"], x["b"]): x for x in json.loads(out)["checks"]}
    assert code == 0 and checks["sled", "floor"]["status"] == "FREE"
    assert checks["sled", "floor"]["allowed"].startswith("touching at the start (")
    assert checks["sled", "wall"]["allowed"] is None


def test_bodies_that_overlap_are_let_pass_by_name_alone(command, scene):
    pressed = STAND.replace('"-1"', '"-1/2"').replace('at = ["3"', 'at = ["30"')
    assert command("check", scene(pressed + ALLOW + "touching = true\n")).code == 1
    code, out, _ = command("check", scene(pressed + ALLOW + 'pair = ["sled", "floor"]\nwhy = "press fit"\n'))
    assert code == 0 and "allowed: overlapping at the start, so not looked at further (sled / floor: press fit)" in out


@pytest.mark.parametrize(
    ("rule", "says"),
    [
        ('pair = ["bolt*", "floor"]', "allow[0]: no body 'bolt*'; the bodies are 'sled', 'floor', 'wall'"),
        ('pair = ["sled", "floor"]\ntouching = true', "allow[0]: give one of pair"),
        ('why = "never"', "allow[0]: give one of pair"),
        ('patern = "x"', "unknown key 'patern'"),
    ],
)
def test_rules_that_say_nothing_are_refused(command, scene, rule, says):
    code, out, err = command("check", scene(STAND + ALLOW + rule + "\n"))
    assert code == 3 and out == "" and says in err and err.count("\n") == 1


def test_pairs_at_rest_with_each_other_are_left_out(command, scene):
    train = STAND + cube("car", -3) + MOVES.format("car", 4)
    code, out, _ = command("check", scene(train))
    assert "floor and car" in out and "sled and car" not in out and "floor and wall" not in out
    assert "2 pairs at rest with each other left out (rest = true asks for them)" in out
    out = command("check", scene("rest = true\n" + train)).out
    assert "sled and car: FREE" in out and "floor and wall: FREE" in out and "left out" not in out
    asked = train + '[[check]]\npair = ["sled", "car"]\n'
    assert "sled and car: FREE" in command("check", scene(asked)).out
    one = scene(cube("sled", 0) + MOVES.format("sled", 1) + cube("car", 2) + MOVES.format("car", 1))
    assert "sled and car: FREE" in command("check", one).out  # where no two bodies move to each other all are asked


def test_scale_and_unit(command, scene):
    text = 'unit = "mm"\n' + STAND.replace('at = ["3"', 'scale = "1/2"\nat = ["3"')
    code, out, _ = command("check", scene(text), "--json", "-")
    document = json.loads(out)
    assert document["unit"] == "mm" and document["at_rest"] == 1
    assert "sled has moved 2 of 4 mm" in command("check", scene(text)).out
    lo, hi = fc.Scene.load(scene(text)).bodies["wall"].bounds()
    assert (hi - lo).tolist() == [0.5] * 3 and lo[0] == 3.0
    assert "scale" in command("check", scene(text.replace('"1/2"', "0"))).err


def many(n):
    """A sled among n posts, at 2 and then every 3: it strikes the k-th at (1 + 3 k) / 100."""
    return cube("sled", 0) + MOVES.format("sled", 100) + "".join(cube(f"post{k}", 2 + 3 * k, "1/2") for k in range(n))


def test_of_many_pairs_the_contacts_alone_are_printed_earliest_first(command, scene):
    code, out, _ = command("check", scene(many(40)))
    lines = out.splitlines()
    assert code == 1 and len(lines) == 24
    assert lines[0] == "41 bodies, 40 pairs asked: 34 in contact, 6 free"
    assert lines[1] == "780 pairs at rest with each other left out (rest = true asks for them)"
    assert lines[2] == "time is the share of the motion that is done, from 0 to 1"
    assert [float(line.split()[0]) for line in lines[3:-1]] == [(1 + 3 * k) / 100 for k in range(20)]
    assert lines[3].split("; ")[:2] == ["  0.01         sled / post0", "sled has moved 1 of 100"]
    assert lines[-1] == "  and 14 more contacts: --all"
    everything = command("check", scene(many(40)), "--all").out
    assert everything.count("FREE") == 6 and everything.count("CONTACT at time") == 34


def test_info_of_many_bodies_is_short(command, scene):
    lines = command("info", scene('unit = "mm"\n' + many(40))).out.splitlines()
    assert lines[0].endswith("41 bodies, 40 checks, lengths in mm, 780 pairs at rest with each other left out")
    assert lines[1:4] == [
        "  41 of meshes, closed, a solid: sled, post0, post1, post2, ...",
        "  1 Translation((100.0, 0.0, 0.0)): sled",
        "  40 at rest: post0, post1, post2, post3, ...",
    ]
    assert lines[4] == "  from (0, 0, 0) to (120, 1, 1.5)"
    assert command("info", scene(many(40)), "--all").out.count("8 vertices") == 41


def test_the_page_of_a_scene(command, scene, tmp_path):
    path = scene(many(40))
    assert command("check", path, "--html", tmp_path / "a.html").code == 1
    loaded = fc.Scene.load(path)
    page = loaded.show(loaded.first_contacts(), tmp_path / "b.html")
    texts = [p.read_text(encoding="utf-8") for p in (page, tmp_path / "a.html")]
    assert texts[0] == texts[1] and '"name": "post39", "mesh"' in texts[0]


def test_rows_are_written_as_they_come(command, scene, tmp_path):
    path, table, lines = scene(STAND + ALLOW + "touching = true\n"), tmp_path / "t.csv", tmp_path / "t.jsonl"
    assert command("check", path, "--csv", table, "--jsonl", lines).code == 1
    first, second = list(csv.DictReader(table.open()))
    assert first["status"] == "FREE" and first["allowed"] and first["time"] == ""
    assert (second["a"], second["b"], float(second["time"])) == ("sled", "wall", 0.5) and float(second["x"]) == 3.0
    assert second["moved"] == "sled has moved 2 of 4" and second["element_b"].startswith("wall ")
    found = [json.loads(line) for line in lines.read_text().splitlines()]
    assert [x["status"] for x in found] == ["FREE", "CONTACT"]
    out = command("check", path, "--jsonl", "-").out
    assert [json.loads(line)["time"] for line in out.splitlines()] == [None, 0.5]
    assert command("check", path, "--jsonl", "-", "--csv", "-").code == 3
    rows = command("intervals", path, "--csv", "-").out.splitlines()
    assert rows[0] == "a,b,status,start,end,free_until,reason" and rows[2].startswith("sled,wall,CONTACT,0.5,1.0")


@pytest.fixture
def meshes(tmp_path):
    box = fc.examples.box((1.0, 1.0, 1.0))
    for name, shift in (("top", 3.0), ("base", 0.0), ("side", 40.0)):
        write_mesh(tmp_path / f"{name}.stl", np.asarray(box.vertices) + [0, 0, shift], box.triangles)
    return [tmp_path / f"{name}.stl" for name in ("top", "base", "side")]


def test_meshes_without_a_scene(command, meshes):
    code, out, _ = command("check", *meshes[:2], "--move", "0 0 -10")
    assert code == 1 and "top and base: CONTACT at time 0.2 " in out and "top has moved 2 of 10" in out
    code, out, _ = command("check", *meshes, "--move", "0,0,-1.5")
    assert code == 0 and out.count("FREE") == 2
    turn = "--turn", "1 0 0", "--about", "0 10 1.5", "--degrees", "360"
    code, out, _ = command("check", *meshes[:2], *turn, "--json", "-")
    assert code == 1 and 0 < json.loads(out)["checks"][0]["time"] < 1
    code, out, _ = command("intervals", *meshes[:2], "--move", "0 0 -10")
    assert code == 1 and "[0.2, 0.4]" in out
    with pytest.warns(UserWarning, match="give --move or --turn"):
        assert command("check", *meshes[:2]).code == 0  # as they stand


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--move", "0 0"], "three numbers"),
        (["--move", "0 0 x"], "--move: 'x' is not a number"),
        (["--move", "0 0 1", "--turn", "0 0 1"], "choose one"),
        (["--turn", "0 0 1"], "--degrees"),
        (["--degrees", "5"], "--turn"),
        (["--turn", "0 0 0", "--degrees", "5"], "axis is zero"),
    ],
)
def test_motions_that_are_none(command, meshes, options, says):
    code, out, err = command("check", *meshes[:2], *options)
    assert code == 3 and out == "" and says in err and err.count("\n") == 1


def test_a_scene_moves_by_its_own_words(command, scene):
    code, _, err = command("check", scene(STAND), "--move", "1 0 0")
    assert code == 3 and "--move and --turn are for mesh and STEP files" in err


def test_python_says_what_the_command_says(scene, command):
    path = scene(STAND + ALLOW + "touching = true\n")
    hits = fc.Scene.load(path).first_contacts()
    told = json.loads(command("check", path, "--json", "-").out)["checks"]
    assert [(x.a.name, x.b.name, x.status.name, x.time, x.allowed) for x in hits] == [
        (x["a"], x["b"], x["status"], x["time"], x["allowed"]) for x in told
    ]
    assert all(fc.FirstContact.from_json(x.to_json()) == x for x in hits)


def test_terms_of_every_motion():
    from firstcontact.assembly.words import _done, reading

    turn, shift = fc.Rotation((0, 0, 1), degrees=90), fc.Translation((3, 4, 0))
    assert _done(turn, 0.5, "mm") == "has turned 45 of 90 degrees"
    assert _done(fc.Rotation((0, 0, 1), radians=math.pi), 0.5, "") == "has turned 90 of 180 degrees"
    assert _done(shift, 0.5, "mm") == "has moved 2.5 of 5 mm"
    screw = fc.Screw((0, 0, 1), turns=2, advance=3)
    assert _done(screw, 0.25, "mm") == "has turned 180 of 720 degrees, 0.75 of 3 mm ahead"
    steps = fc.Sequence([shift, turn], durations=[1, 3])
    assert _done(steps, 2.5, "") == "in step 2 of 2 has turned 45 of 90 degrees"
    path = fc.Trajectory([0, 1, 5], [np.eye(4)] * 3)
    assert _done(path, 2.0, "") == "is between poses 2 and 3 of 3"
    body = fc.sphere(1)
    assert reading([body.moving(steps)]) == "time is that of the steps' durations, from 0 to 4"
    assert reading([body.moving(path), body]) == "time is that of the trajectory"
