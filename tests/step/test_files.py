"""STEP files: trees, places, units and names as the file has them, and one clear line for what is broken."""

import re
import sys

import numpy as np
import pytest

pytest.importorskip("OCP")


import firstcontact as fc  # noqa: E402
import step_shapes as shapes  # noqa: E402
from firstcontact.cli import run  # noqa: E402


@pytest.fixture(scope="module")
def jig(tmp_path_factory):
    return shapes.assembly(tmp_path_factory.mktemp("step") / "jig.stp")


@pytest.fixture(scope="module")
def block(tmp_path_factory):
    return shapes.write(tmp_path_factory.mktemp("step") / "block.stp", shapes.box((2, 3, 4)))


def entities(path, kind):
    return [int(x) for x in re.findall(rf"#(\d+) = {kind}\(", path.read_text())]


def test_the_tree_is_that_of_the_file(jig):
    root = fc.load_step(jig)
    assert [node.path for node in root.walk()] == ["jig", "jig/plate", "jig/pin", "jig/pin.2"]
    assert root["pin.2"] is root["jig/pin.2"] and root["plate"].unit == "mm"
    assert root["pin.2"].colour == pytest.approx((1, 0, 0)) and root["plate"].colour is None
    assert str(root) == "jig\n  plate\n  pin\n  pin.2 (pin)"
    assert root.exact and root.deviation == 0.0
    lo, hi = root["pin.2"].bounds()
    assert np.allclose([lo, hi], [[3, 2, 4], [5, 3, 7]], rtol=0, atol=1e-14)
    assert np.array_equal(root["jig/pin"].bounds(), [[1, 1, 4], [2, 3, 7]])


def test_a_part_that_is_not_there_or_not_the_only_one_is_told(jig):
    root = fc.load_step(jig)
    with pytest.raises(fc.InputError, match=r"jig: no part 'bolt'; there are 'jig/plate', 'jig/pin'"):
        root["bolt"]
    assert root["pin"].path == "jig/pin"


def test_answers_name_the_faces_of_the_file(jig):
    root = fc.load_step(jig)
    hit = fc.first_contact(root["jig/pin"].moving(fc.Translation((0, 0, -6))), root["plate"])
    assert hit.time == 0.5 and hit.model_deviation == 0.0 and hit.unit == "mm"
    assert {hit.element_a.body, hit.element_b.body} == {"pin", "plate"}
    faces, edges, vertices = (entities(jig, kind) for kind in ("ADVANCED_FACE", "EDGE_CURVE", "VERTEX_POINT"))
    known = {"face": faces, "edge": edges, "vertex": vertices}
    for element in (hit.element_a, hit.element_b):
        name, label = element.label.split(" ")
        assert name == element.body and int(label[1:]) in known[element.kind]
    assert "of the bodies with the file's own surfaces, lengths in mm" in str(hit)
    again = fc.from_dict(hit.to_dict())
    assert again == hit and again.model_deviation == 0.0


def test_lengths_are_converted_exactly(block):
    inches = fc.load_step(block, unit="inch")
    lo, hi = inches.bounds()
    assert hi.tolist() == pytest.approx([2 / 25.4, 3 / 25.4, 4 / 25.4], rel=1e-15) and inches.body.unit == "inch"
    piece = inches.body.pieces[0].body
    assert max(float(piece.exact_vertex(k)[0] * 127) for k in range(8)) == 10.0  # 2 mm are 10/127 inches
    with pytest.raises(fc.InputError, match="one is in mm and other in inch; load both with the same unit="):
        fc.first_contact(fc.load_step(block).named("one"), inches.named("other"))
    with pytest.raises(fc.InputError, match="unit is 'ell'; give one of mm, cm"):
        fc.load_step(block, unit="ell")


def test_tilted_planes_meet_in_exact_corners(tmp_path):
    turned = shapes.moved(shapes.cut(shapes.box((4, 4, 4)), shapes.box((2, 2, 2), (1, 1, 3))), turn=((1, 2, 3), 0.7))
    part = fc.load_step(shapes.write(tmp_path / "tilted.stp", turned))
    assert part.exact and 0 < part.deviation < 1e-11
    (piece,) = part.body.pieces
    assert piece.body.n_faces == 11 and len(piece.body.edges) == 24


def test_a_deviation_that_is_asked_for_is_kept(tmp_path):
    path = shapes.write(tmp_path / "torus.stp", shapes.torus(3, 1))
    rough, fine = (fc.load_step(path, deviation=x, surfaces=False) for x in (0.1, "0.01"))
    assert not rough.exact and 0 < fine.deviation <= 0.01 < rough.deviation <= 0.1
    hit = fc.first_contact(fine.moving(fc.Translation((0, 0, -10))), fc.box((9, 9, 1)).translated((0, 0, -5)))
    assert abs(hit.time - 0.35) <= fine.deviation / 10 and hit.model_deviation == fine.deviation
    assert hit.element_a.kind in ("face", "edge") and "within 0.0" in str(hit)  # the seam meets the lowest circle


def broken(path, text, **changes):
    path.write_text(text)
    with pytest.raises(fc.InputError) as caught:
        fc.load_step(path).body  # noqa: B018
    return str(caught.value).replace(str(path), "it")


def test_broken_files_end_in_a_line_that_names_the_entity(tmp_path, block):
    text, path = block.read_text(), tmp_path / "it.stp"
    assert broken(path, "solid x").startswith("it: no STEP file (it does not begin with ISO-10303-21;)")
    assert re.match(r"it: the file ends in or after entity #\d+, without END-ISO", broken(path, text[: len(text) // 2]))
    face = entities(block, "ADVANCED_FACE")[2]
    lost = re.sub(rf"#{face} = ADVANCED_FACE\(.*?\);", "", text, flags=re.S)
    shell = entities(block, "CLOSED_SHELL")[0]
    assert broken(path, lost) == (
        f"it: entity #{shell} (CLOSED_SHELL) refers to #{face}, which is not in the file; export it again"
    )
    opened = re.sub(rf"(#{shell} = CLOSED_SHELL\(.*?),#{face}\b", r"\1", text, flags=re.S)
    told = broken(path, opened)
    assert re.search(r"its shell is open at edge #\d+, which borders face #\d+ alone", told)
    bare = re.sub(rf"(#{shell} = CLOSED_SHELL\('',).*?;", r"\1());", text, flags=re.S)
    assert broken(path, bare) == f"it: entity #{shell} (CLOSED_SHELL) has no faces; export the model again"
    point = entities(block, "CARTESIAN_POINT")[3]
    nan = re.sub(rf"(#{point} = CARTESIAN_POINT\('',\().*?;", r"\1NAN,0.,0.));", text, flags=re.S)
    assert broken(path, nan).startswith(f"it: entity #{point} (CARTESIAN_POINT) has NAN in the place of a number (as")
    for huge in ("1.E400", "-2.5E+0309"):
        beyond = re.sub(rf"(#{point} = CARTESIAN_POINT\('',\().*?;", rf"\g<1>{huge},0.,0.));", text, flags=re.S)
        assert broken(path, beyond).startswith(f"it: entity #{point} (CARTESIAN_POINT) has {huge} in the place of a")
    curves = text[: text.index("#10 = ")] + "ENDSEC;\nEND-ISO-10303-21;\n"
    assert "which is not in the file" in broken(path, curves) or "holds no" in broken(path, curves)


@pytest.fixture
def placed(tmp_path):
    """The text of an assembly, and the number of the point where its second pin stands."""
    text = shapes.assembly(tmp_path / "placed.stp").read_text()
    frames = re.findall(r"ITEM_DEFINED_TRANSFORMATION\('','',#\d+,#(\d+)\)", text)
    return text, int(re.search(rf"#{frames[-1]} = AXIS2_PLACEMENT_3D\('',#(\d+),", text)[1])


@pytest.mark.parametrize("given", [
    "$", "*", "'x'", ".T.", "#1", "", "(1.)", "-", "1E1", "1.D1", "1.E", "1.2.3", "1_0.", "1 0.", "LENGTH_MEASURE(1.)",
    "1.,2.", "1.E46", "-3.0E+101",
])  # fmt: skip
def test_what_is_no_number_is_told(tmp_path, placed, given):
    """OpenCASCADE reads 0, or another number, and the part stands elsewhere."""
    text, point = placed
    changed = re.sub(rf"(#{point} = CARTESIAN_POINT\('',\()[^,]*,", rf"\g<1>{given},", text)
    assert changed != text
    told = broken(tmp_path / "it.stp", changed)
    shown = "nothing" if given in ("", "(1.)", "LENGTH_MEASURE(1.)") else given
    assert told.startswith(f"it: entity #{point} (CARTESIAN_POINT) has {shown}") and "in the place of a" in told


@pytest.mark.parametrize("given", ["10", "10.", "+10.0", "1.E1", "1.0e+01", ".1E2", " 10.", "10. /* across */"])
def test_numbers_as_files_have_them(tmp_path, placed, given):
    text, point = placed
    path = tmp_path / "it.stp"
    path.write_text(re.sub(rf"(#{point} = CARTESIAN_POINT\('',\()[^,]*,", rf"\g<1>{given},", text))
    other = tmp_path / "other.stp"
    other.write_text(re.sub(rf"(#{point} = CARTESIAN_POINT\('',\()[^,]*,", r"\g<1>10.0,", text))
    assert np.array(fc.load_step(path).bounds()).tolist() == np.array(fc.load_step(other).bounds()).tolist()


def test_radii_and_measures_are_numbers(tmp_path):
    text = shapes.write(tmp_path / "pin.stp", shapes.cylinder(2, 3)).read_text()
    for kind in ("CYLINDRICAL_SURFACE", "CIRCLE", "VECTOR"):
        own, number, given = re.search(rf"(#(\d+) = {kind}\('',#\d+,)([^)]*)\)", text).groups()
        changed = text.replace(f"{own}{given})", f"{own}$)")
        assert broken(tmp_path / "it.stp", changed).startswith(f"it: entity #{number} ({kind}) has $ in the place of a")
    changed = re.sub(r"LENGTH_MEASURE\([^)]*\)", "LENGTH_MEASURE(*)", text, count=1)
    assert "has * in the place of a number" in broken(tmp_path / "it.stp", changed)


def test_a_part_without_a_place_is_told(tmp_path, placed):
    text, _ = placed
    places = re.findall(r"#\d+ = CONTEXT_DEPENDENT_SHAPE_REPRESENTATION\([^;]*;", text)
    assert len(places) == 3
    for place in places:
        told = broken(tmp_path / "it.stp", text.replace(place, ""))
        assert re.match(r"it: entity #\d+ \(NEXT_ASSEMBLY_USAGE_OCCURRENCE\) uses a part without telling where", told)


def test_an_assembly_without_a_place_is_told(tmp_path, placed):
    """Nor does it have a shape of its own: its parts have."""
    text, _ = placed
    whole, name = re.search(r"#(\d+) = (PRODUCT_DEFINITION\('design','',#\d+,#\d+\));", text).groups()
    shown = re.search(rf"#(\d+) = PRODUCT_DEFINITION_SHAPE\('[^']*','[^']*',#{whole}\)", text)[1]
    bare = re.sub(rf"#\d+ = SHAPE_DEFINITION_REPRESENTATION\(#{shown},[^;]*;", "", text)
    more = f"#95001={name};\n#95002=NEXT_ASSEMBLY_USAGE_OCCURRENCE('1','','',#95001,#{whole},$);\nENDSEC;\nEND-ISO"
    told = broken(tmp_path / "it.stp", bare.replace("ENDSEC;\nEND-ISO", more))
    assert told.startswith("it: entity #95002 (NEXT_ASSEMBLY_USAGE_OCCURRENCE) uses a part without telling where")


def test_what_represents_nothing_need_have_no_shape(tmp_path, block):
    shell = entities(block, "CLOSED_SHELL")[0]
    path = tmp_path / "it.stp"
    more = f"#95001=MANIFOLD_SOLID_BREP('spare',#{shell});\nENDSEC;\nEND-ISO"
    path.write_text(block.read_text().replace("ENDSEC;\nEND-ISO", more))
    assert len(fc.load_step(path).body.pieces) == 1


def test_knots_are_doubles(tmp_path, block):
    point = entities(block, "CARTESIAN_POINT")[0]
    curve = f"B_SPLINE_CURVE_WITH_KNOTS('',1,(#{point},#{point}),.UNSPECIFIED.,.F.,.F.,(2,2),(0.,1.E400),.UNSPECIFIED.)"
    text = block.read_text().replace("ENDSEC;\nEND-ISO", f"#95001={curve};\nENDSEC;\nEND-ISO")
    assert broken(tmp_path / "it.stp", text).startswith("it: entity #95001 (B_SPLINE_CURVE_WITH_KNOTS) has 1.E400 in")


def test_a_mapped_item_is_a_place(tmp_path, placed):
    """The assembly itself holds the part there."""
    text, _ = placed
    whole = fc.load_step(tmp_path / "placed.stp").bounds()
    related = re.findall(
        r"REPRESENTATION_RELATIONSHIP\('','',#(\d+),#(\d+)\)\s*"
        r"REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION\(#(\d+)\)", text,
    )  # fmt: skip
    part, parent, transformation = related[-1]
    frames = re.search(rf"#{transformation} = ITEM_DEFINED_TRANSFORMATION\('','',(#\d+),(#\d+)\)", text)
    place = re.findall(r"#\d+ = CONTEXT_DEPENDENT_SHAPE_REPRESENTATION\([^;]*;", text)[-1]
    more = f"#91001=REPRESENTATION_MAP({frames[1]},#{part});\n#91002=MAPPED_ITEM('',#91001,{frames[2]});\n"
    text = re.sub(rf"(#{parent} = SHAPE_REPRESENTATION\('',\()", r"\g<1>#91002,", text.replace(place, more))
    path = tmp_path / "it.stp"
    path.write_text(text)
    assert np.array(fc.load_step(path).bounds()) == pytest.approx(np.array(whole), abs=1e-9)


def test_a_solid_that_is_left_out_is_told(tmp_path, block, monkeypatch):
    """Of which OpenCASCADE makes nothing, without a word, as of such numbers."""
    from firstcontact.step.written import text as checks

    monkeypatch.setattr(checks, "check_numbers", lambda *given: None)
    vertex = entities(block, "VERTEX_POINT")[0]
    point = re.search(rf"#{vertex} = VERTEX_POINT\('',#(\d+)\)", block.read_text())[1]
    far = re.sub(rf"(#{point} = CARTESIAN_POINT\('',\().*?;", r"\g<1>1.E101,0.,0.));", block.read_text(), flags=re.S)
    told = broken(tmp_path / "it.stp", far)
    assert re.match(r"it: OpenCASCADE makes nothing of entity #\d+ \(MANIFOLD_SOLID_BREP\)", told)


def test_a_face_that_is_left_out_is_told(tmp_path, block):
    """As one on no surface is."""
    text, face = block.read_text(), entities(block, "ADVANCED_FACE")[1]
    bare = re.sub(rf"(#{face} = ADVANCED_FACE\('',\([^)]*\)),#\d+,", r"\1,$,", text)
    assert bare != text
    told = broken(tmp_path / "it.stp", bare)
    assert told == f"it: OpenCASCADE makes nothing of entity #{face} (ADVANCED_FACE); export the model again"


def test_numbers_that_open_cascade_gives_up_over_are_told(tmp_path):
    path = shapes.write(tmp_path / "pin.stp", shapes.cylinder(1e12, 1e12))
    with pytest.raises(fc.InputError, match=r"OpenCASCADE gives up \(.*nearer the origin or in a larger unit"):
        fc.load_step(path).body  # noqa: B018


def test_an_interrupt_while_open_cascade_is_loaded_is_one(block, monkeypatch):
    import builtins

    plain = builtins.__import__

    def interrupted(name, *given, **more):
        if name == "OCP.STEPCAFControl":
            raise ImportError("initialization failed") from KeyboardInterrupt()
        return plain(name, *given, **more)

    monkeypatch.setattr(builtins, "__import__", interrupted)
    with pytest.raises(KeyboardInterrupt):
        fc.load_step(block)


def test_surfaces_without_a_solid_are_not_left_out(tmp_path):
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer

    face = TopExp_Explorer(shapes.box((1, 1, 1)), TopAbs_ShapeEnum.TopAbs_FACE).Current()
    path = shapes.write(tmp_path / "sheet.stp", face)
    with pytest.raises(fc.InputError, match="shell is open at edge 0|shell is open at edge #"):
        fc.load_step(path).body  # noqa: B018
    with pytest.raises(fc.InputError, match="no such file"):
        fc.load_step(tmp_path / "nowhere.stp")


def test_without_open_cascade_one_line_tells_what_to_install(block, monkeypatch):
    monkeypatch.setitem(sys.modules, "OCP.TopoDS", None)
    for ask in (lambda: fc.load_step(block), lambda: fc.from_shape(object())):
        with pytest.raises(fc.InputError, match=r"python -m pip install 'firstcontact\[step\]'"):
            ask()


class Wrapped:
    """As shapes of build123d and CadQuery are."""

    label = "knob"

    def __init__(self, shape):
        self.wrapped = shape


def test_shapes_of_other_libraries_are_bodies():
    knob = Wrapped(shapes.box((1, 1, 1), (0, 0, 2)))
    hit = fc.first_contact(fc.Moving(knob, fc.Translation((0, 0, -4))), Wrapped(shapes.box((1, 1, 1))))
    assert hit.time == 0.25 and hit.element_a.body == "knob"
    assert fc.from_shape(knob, unit="mm").unit == "mm"
    with pytest.raises(fc.InputError, match="polyhedra do not tell"):
        fc.from_shape(knob).contains([(0, 0, 0)])
    with pytest.raises(fc.InputError, match="is no shape of OpenCASCADE"):
        fc.from_shape("knob")


SCENE = """
[body.pin]
shape = "step"
file = "jig.stp"
part = "jig/pin"
[body.pin.motion]
type = "translation"
vector = [0, 0, -6]
[body.rest]
shape = "step"
file = "jig.stp"
part = "plate"
[[check]]
pair = ["pin", "rest"]
"""


def test_scenes_take_parts_of_files(jig, capfd):
    scene = jig.with_name("jig.toml")
    scene.write_text(SCENE)
    assert run(["check", str(scene)]) == 1
    assert "pin and rest: CONTACT at time 0.5" in capfd.readouterr().out
    assert run(["info", str(scene)]) == 0
    assert "1 piece of a STEP file, with the file's own surfaces" in capfd.readouterr().out
    scene.write_text(SCENE.replace("jig/pin", "bolt"))
    assert run(["check", str(scene)]) == 3
    assert "body.pin: jig: no part 'bolt'" in capfd.readouterr().err


def test_the_whole_file_is_a_body_that_is_written_and_read(jig):
    whole = fc.load_step(jig).body
    assert len(whole.pieces) == 3
    moved = whole.translated((0, 0, "1/3"))
    assert fc.from_dict(moved.to_dict()) == moved
    ball = fc.sphere(1).translated((1.5, 2, 20))
    hit = fc.first_contact(ball.moving(fc.Translation((0, 0, -20))), whole)
    assert hit.time == pytest.approx(0.6, abs=1e-12) and hit.element_b.label.startswith("pin #")


def test_info_tells_parts_faces_unit_and_exactness(jig, capfd):
    assert run(["info", str(jig)]) == 0
    told = capfd.readouterr().out
    assert "3 parts of 2 kinds, lengths in mm" in told
    assert "    pin.2 (pin): 6 faces (6 planes), size 1 x 2 x 3; exact" in told
