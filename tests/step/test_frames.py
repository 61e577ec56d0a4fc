"""Parts stand where the file has them, whatever frames say so: T2 T1^-1 of ISO 10303-43, worked out here by hand."""

import re

import numpy as np
import pytest

pytest.importorskip("OCP")

import firstcontact as fc  # noqa: E402
import step_shapes as shapes  # noqa: E402

CORNERS = np.array([(x, y, z, 1) for x in (0, 1) for y in (0, 2) for z in (0, 3)], float)
PIN = "ADVANCED_BREP_SHAPE_REPRESENTATION"


def frame(number, origin, z, x):
    """(text, (4, 4)) of an axis placement with that entity number and three below it."""
    z = np.array(z) / np.linalg.norm(z)
    x = np.array(x) - (np.array(x) @ z) * z
    x /= np.linalg.norm(x)
    pose = np.eye(4)
    pose[:3] = np.column_stack([x, np.cross(z, x), z, origin])
    vectors = [",".join(f"{float(v):.17E}" for v in w) for w in (origin, z, x)]
    kinds = "CARTESIAN_POINT", "DIRECTION", "DIRECTION"
    lines = [f"#{number - 3 + k}={kind}('a;b',({v}));" for k, (kind, v) in enumerate(zip(kinds, vectors, strict=True))]
    return "\n".join([*lines, f"#{number}=AXIS2_PLACEMENT_3D('',#{number - 3},#{number - 2},#{number - 1});"]), pose


FIRST, T1 = frame(90004, (5, -1, 2), (1, 2, 2), (0, 1, 0))
SECOND, T2 = frame(90008, (-3, 4, 1), (0, 3, 4), (1, 1, 1))
OTHER, T3 = frame(90012, (7, 7, -2), (1, 0, 0), (0, 1, 1))


def box_at(pose):
    at = CORNERS @ pose.T
    return at[:, :3].min(axis=0), at[:, :3].max(axis=0)


def with_more(text, *more):
    head, tail = text.split("ENDSEC;\nEND-ISO", 1)
    return head + "\n".join(more) + "\nENDSEC;\nEND-ISO" + tail


def stands(found, pose):
    """Its box, and the middle of the part is of the body."""
    for told, due in zip(found.bounds(), box_at(pose), strict=True):
        assert told == pytest.approx(due, abs=1e-9)
    middle = fc.Polyhedron([(pose @ (0.5, 1, 1.5, 1))[:3].tolist()], [])
    assert fc.first_contact(middle, found.body).status is fc.Status.INITIAL_CONTACT


@pytest.mark.share(2)
@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize("number", [0, 1])
def test_an_item_defined_transformation(tmp_path, number, swapped):
    """Of the second pin, or the first one; swapped: the frames are named the other way round than the parts."""
    text = shapes.assembly(tmp_path / "jig.stp").read_text()
    given = re.findall(r"#(\d+) = ITEM_DEFINED_TRANSFORMATION\('','',(#\d+),(#\d+)\);", text)
    pins = [x for x in given if re.search(rf"REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION\(#{x[0]}\)", text)][1:]
    own, first, second = pins[number]
    frames = "#90004,#90008" if not swapped else "#90008,#90004"
    text = text.replace(f"#{own} = ITEM_DEFINED_TRANSFORMATION('','',{first},{second})",
                        f"#{own} = ITEM_DEFINED_TRANSFORMATION('','',{frames})")  # fmt: skip
    part, whole = re.search(
        rf"REPRESENTATION_RELATIONSHIP\('','',#(\d+),#(\d+)\)\s*REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION\(#{own}\)",
        text,
    ).groups()
    for representation, item in ((part, 90004), (whole, 90008)):
        text = re.sub(rf"(#{representation} = \w+\('[^']*',\()", rf"\1#{item},", text)
    path = tmp_path / "own.stp"
    path.write_text(with_more(text, FIRST, SECOND))
    root = fc.load_step(path)
    stands(root["pin" if number == 0 else "pin.2"], T2 @ np.linalg.inv(T1))
    lo, hi = root["pin.2" if number == 0 else "pin"].bounds()  # the others stand where they did
    assert hi - lo == pytest.approx((1, 2, 3) if number == 1 else (2, 1, 3))


def mapped(tmp_path, origin, *targets):
    """A file whose only part is in its place by mapped items; numbers of frames."""
    text = shapes.write(tmp_path / "box.stp", shapes.box((1, 2, 3))).read_text()
    own, axis, context = re.search(rf"#(\d+) = {PIN}\('',\((#\d+),#\d+\),\s*(#\d+)\)", text).groups()
    text = re.sub(rf"(= SHAPE_DEFINITION_REPRESENTATION\(#\d+),#{own}\)", r"\1,#91002)", text)
    items = [f"#{91003 + k}=MAPPED_ITEM('',#91001,#{target});" for k, target in enumerate(targets)]
    listed = ",".join(f"#{91003 + k}" for k in range(len(targets)))
    path = tmp_path / "mapped.stp"
    path.write_text(with_more(
        text, FIRST, SECOND, OTHER, f"#91001=REPRESENTATION_MAP({axis if origin is None else f'#{origin}'},#{own});",
        *items, f"#91002=SHAPE_REPRESENTATION('',({listed},{axis}),{context});",
    ))  # fmt: skip
    return fc.load_step(path)


def test_one_mapped_item_places_its_part_once(tmp_path):
    """It was placed twice."""
    stands(mapped(tmp_path, None, 90008), T2)


def test_a_map_with_a_frame_of_its_own(tmp_path):
    stands(mapped(tmp_path, 90004, 90008), T2 @ np.linalg.inv(T1))


def test_items_of_one_map(tmp_path):
    """The second one is read as it is, by itself: it stands on the map's frame."""
    parts = mapped(tmp_path, 90004, 90008, 90004, 90012).parts
    assert len(parts) == 3
    for part, pose in zip(parts, (T2 @ np.linalg.inv(T1), np.eye(4), T3 @ np.linalg.inv(T1)), strict=True):
        stands(part, pose)


@pytest.mark.parametrize(
    ("scale", "third", "fault"),
    [
        ("2.5", (0, 0, 1), "scales what it places by 2.5"),
        ("1.", (0, 0, -1), "mirrors what it places"),
        ("$", (0, 0, 1), ""),
    ],
)
@pytest.mark.parametrize("form", ["simple", "complex"])
def test_operators_with_a_scale_or_a_mirror(tmp_path, form, scale, third, fault):
    """OpenCASCADE leaves them out, or makes them otherwise; a rotation and a shift it takes."""
    text = shapes.assembly(tmp_path / "jig.stp").read_text()
    own = re.findall(r"REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION\(#(\d+)\)", text)[1]
    axes = "#92001,#92002,#92004"
    one = f"#{own} = CARTESIAN_TRANSFORMATION_OPERATOR_3D('','',$,{axes},{scale},#92003);"
    if form == "complex":
        one = (
            f"#{own} = ( CARTESIAN_TRANSFORMATION_OPERATOR({axes},{scale}) "
            "CARTESIAN_TRANSFORMATION_OPERATOR_3D(#92003) FUNCTIONALLY_DEFINED_TRANSFORMATION('','') "
            "GEOMETRIC_REPRESENTATION_ITEM() REPRESENTATION_ITEM('') );"
        )
    text = re.sub(rf"#{own} = ITEM_DEFINED_TRANSFORMATION\([^;]*;", one, text)
    lines = [f"#{92001 + k}=DIRECTION('',({','.join(f'{x}.' for x in v)}));"
             for k, v in enumerate([(0, 1, 0), (-1, 0, 0), third])]  # fmt: skip
    path = tmp_path / "own.stp"
    path.write_text(with_more(text, *lines, "#92004=CARTESIAN_POINT('',(10.,0.,0.));"))
    if fault:
        with pytest.raises(fc.InputError, match=rf"entity #{own} \(CARTESIAN_TRANSFORMATION_OPERATOR_3D\) {fault}; "):
            fc.load_step(path)
        path.write_text(path.read_text().replace(",#92004,", ","))
        with pytest.raises(fc.InputError, match="has not the attributes that it needs"):
            fc.load_step(path)
    elif form == "simple":
        pose = np.array([(0, -1, 0, 10), (1, 0, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)], float)
        stands(fc.load_step(path)["pin"], pose)


TURNED = {  # axes of an operator, None for its own; what becomes of x, y and z
    "all": ((0, 1, 0), (-1, 0, 0), (0, 0, 1)),
    "none": (None, None, None),
    "the third": (None, None, (0, 1, 0)),
    "the third along the first": (None, None, (1, 0, 0)),
    "all but the first": (None, (0, 0, 1), (1, 0, 0)),
    "askew": ((1, 1, 1), (0, 1, 0), (0, 0, 2)),
}
POSES = {
    "all": [(0, -1, 0), (1, 0, 0), (0, 0, 1)],
    "none": np.eye(3),
    "the third": None,
    "the third along the first": None,
    "all but the first": [(0, 0, 1), (1, 0, 0), (0, 1, 0)],
    "askew": [(0.5**0.5, -(0.5**0.5), 0), (0.5**0.5, 0.5**0.5, 0), (0, 0, 1)],
}


@pytest.mark.parametrize("case", TURNED)
def test_an_operator_in_an_item_defined_transformation(tmp_path, case):
    """OpenCASCADE leaves it out: the part stood where it was drawn."""
    text = shapes.assembly(tmp_path / "jig.stp").read_text()
    given = re.findall(r"#(\d+) = ITEM_DEFINED_TRANSFORMATION\('','',(#\d+),#\d+\);", text)
    own, frame_ = next(x for x in given[1:] if re.search(rf"_WITH_TRANSFORMATION\(#{x[0]}\)", text))
    text = re.sub(rf"(#{own} = ITEM_DEFINED_TRANSFORMATION\('','',{frame_}),#\d+\)", r"\1,#92005)", text)
    lines, names = [], []
    for k, axis in enumerate(TURNED[case]):
        names.append("$" if axis is None else f"#{92001 + k}")
        if axis is not None:
            lines.append(f"#{92001 + k}=DIRECTION('',({','.join(f'{x}.' for x in axis)}));")
    lines.append("#92004=CARTESIAN_POINT('',(10.,20.,30.));")
    operator = f"CARTESIAN_TRANSFORMATION_OPERATOR_3D('','',$,{names[0]},{names[1]},#92004,1.,{names[2]});"
    path = tmp_path / "own.stp"
    path.write_text(with_more(text, *lines, f"#92005={operator}"))
    if POSES[case] is None:  # the standard's default for y is along z, or along x
        with pytest.raises(fc.InputError, match="two axes in one direction"):
            fc.load_step(path)
        return
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = POSES[case], (10, 20, 30)
    stands(fc.load_step(path)["pin"], pose)
