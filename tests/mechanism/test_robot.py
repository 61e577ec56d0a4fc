"""Robots of URDF files along trajectories: poses as yourdfpy has them, distances by coal."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.cli import run
from firstcontact.mechanism import tables
from firstcontact.scene.load import load_scene

yourdfpy = pytest.importorskip("yourdfpy")
EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
LAMP, PATH, DESK = (EXAMPLES / name for name in ("lamp.urdf", "lamp.csv", "desk.toml"))
CHECK = ["robot", str(LAMP), "--trajectory", str(PATH), "--scene", str(DESK)]


def by_yourdfpy(path, joints):
    """(4, 4) poses of the links at values of joints."""
    model = yourdfpy.URDF.load(str(path), load_meshes=False)
    model.update_cfg(joints)
    return {link: model.get_transform(link, model.base_link) for link in model.link_map}


def moved(course, link, t, home):
    """Where a link stands then, by its motion and its pose with all joints at 0."""
    motion = course.motion(link)
    return home[link] if motion is None else motion(t) @ home[link]


def test_links_stand_where_yourdfpy_has_them():
    course = fc.Robot.load(LAMP).read_course(PATH)
    home = by_yourdfpy(LAMP, {})
    there = by_yourdfpy(LAMP, {"turn": 0.75, "bend": 0.65, "tilt": -0.15})
    for link in home:
        assert moved(course, link, 1.5, home) == pytest.approx(there[link], abs=1e-14)


def test_the_shade_comes_down_on_the_books(capsys):
    assert run(CHECK) == 1
    told = capsys.readouterr().out
    assert told.startswith("shade and books: CONTACT at time 1.72519350728")
    assert "turn = 0.86259675364 rad" in told and "between waypoints 1 and 2; normal (0.165129," in told
    assert told.endswith("12 pairs, 11 of them FREE from waypoint 0 to 3\n")
    # the sphere's centre is 0.06 from the corner of the books
    home = by_yourdfpy(LAMP, {})
    course = fc.Robot.load(LAMP).read_course(PATH)
    centre = moved(course, "shade", 1.7251935072804971, home)[:3, 3]
    assert np.linalg.norm(centre - (0.15, 0.225, 0.12)) == pytest.approx(0.06, abs=1e-12)


def test_free_and_contact_by_samples():
    coal = pytest.importorskip("coal")
    robot = fc.Robot.load(LAMP)
    course = robot.read_course(PATH)
    home = by_yourdfpy(LAMP, {})
    shapes = {
        "foot": (coal.Cylinder(0.1, 0.04), (0, 0, 0.02)), "lower": (coal.Box(0.03, 0.03, 0.3), (0, 0, 0.2)),
        "upper.1": (coal.Box(0.26, 0.03, 0.03), (0.15, 0, 0)), "shade": (coal.Sphere(0.06), (0, 0, 0)),
        "upper": (coal.Cylinder(0.015, 0.02), (0.2, 0, 0)),
        "books": (coal.Box(0.2, 0.15, 0.12), (0.05, 0.3, 0.06)), "mug": (coal.Cylinder(0.04, 0.1), (-0.3, 0.1, 0.05)),
    }  # fmt: skip

    def gap(hit, t):
        places = []
        for body in (hit.a, hit.b):
            shape, at = shapes[body.name]
            pose = moved(course, body.name.split(".")[0], t, home) if body.name not in ("books", "mug") else np.eye(4)
            places += [shape, coal.Transform3s(pose[:3, :3], pose[:3, :3] @ at + pose[:3, 3])]
        return coal.distance(*places, coal.DistanceRequest(), coal.DistanceResult())

    hits = course.first_contacts(load_scene(DESK).bodies.values())
    for hit in hits:
        if hit.status is fc.Status.FREE:
            assert min(gap(hit, t) for t in np.linspace(0, 3, 100)) > 0
        else:
            assert gap(hit, hit.time - 1e-6) > 0 > gap(hit, hit.time + 1e-6)
    assert sum(hit.status is fc.Status.CONTACT for hit in hits) == 1 and len(hits) == 12


def test_trajectories_of_all_kinds_are_one(tmp_path):
    read = tables.read(PATH)
    rows = np.array([[float(x) for x in column] for column in read.values.values()]).T
    names = list(read.values)
    points = [{"positions": row, "time_from_start": {"sec": k, "nanosec": 0}} for k, row in enumerate(rows.tolist())]
    (tmp_path / "q.json").write_text(json.dumps({"joint_trajectory": {"joint_names": names, "points": points}}))
    np.savez(tmp_path / "q.npz", time=np.arange(4.0), **dict(zip(names, rows.T, strict=True)))
    np.savez(tmp_path / "p.npz", positions=rows, joint_names=names, time=np.arange(4.0))
    robot = fc.Robot.load(LAMP)
    poses = [robot.read_course(tmp_path / name).motion("shade")(1.3) for name in ("q.json", "q.npz", "p.npz")]
    for pose in poses:
        assert pose == pytest.approx(robot.read_course(PATH).motion("shade")(1.3), abs=1e-15)


def test_velocities_of_a_trajectory_make_it_cubic(tmp_path):
    points = [
        {"positions": [0.0], "velocities": [1.0], "time_from_start": 0},
        {"positions": [1.0], "velocities": [0.0], "time_from_start": {"secs": 2, "nsecs": 500000000}},
    ]
    path = tmp_path / "q.json"
    path.write_text(json.dumps({"joint_names": ["turn"], "points": points}))
    pose = fc.Robot.load(LAMP).read_course(path, interpolation="cubic").motion("lower")(1.25)
    assert np.arctan2(pose[1, 0], pose[0, 0]) == pytest.approx(0.5 + 2.5 / 8)


def test_what_is_switched_off_is_not_asked(tmp_path):
    srdf = tmp_path / "lamp.srdf"
    off = [f'<disable_collisions link1="foot" link2="{link}" reason="Never"/>' for link in ("shade", "foot")]
    srdf.write_text(f'<robot name="lamp">{"".join(off)}</robot>')
    pairs = {
        frozenset((a.name, b.name)) for a, b in fc.Robot.load(LAMP, srdf=srdf).course([0, 1], {"bend": [0, 1]}).pairs()
    }
    assert pairs == {frozenset(x) for x in [("foot", "upper"), ("foot", "upper.1"), ("lower", "shade")]}


def test_meshes_of_packages(tmp_path):
    folder = tmp_path / "my_robot" / "meshes"
    folder.mkdir(parents=True)
    fc.examples.box((2, 2, 2)).to_trimesh().export(folder / "part.stl")
    text = """<robot name="r"><link name="a"><collision><origin xyz="0 0 1" rpy="0 0 1.5707963267948966"/><geometry>
    <mesh filename="package://my_robot/meshes/part.stl" scale="0.5 0.25 -1"/></geometry></collision></link></robot>"""
    path = tmp_path / "my_robot" / "urdf" / "r.urdf"
    path.parent.mkdir()
    path.write_text(text)
    (body,) = fc.Robot.load(path).links["a"]
    assert body.solid and np.ptp(body.vertices, axis=0) == pytest.approx((0.5, 1, 2))
    away = tmp_path / "away.urdf"
    away.write_text(text.replace("my_robot/", "robot/"))
    with pytest.raises(fc.InputError, match="package://robot/meshes/part.stl: no folder 'robot'"):
        fc.Robot.load(away)
    assert fc.Robot.load(away, packages={"robot": tmp_path / "my_robot"}).links["a"]


def test_a_mesh_that_was_written_anew_is_read_anew(tmp_path):
    """It was kept by its path: a robot read after its file had changed was FREE where it meets something."""
    shape = '<collision><geometry><mesh filename="part.stl"/></geometry></collision>'
    (tmp_path / "r.urdf").write_text(f'<robot name="r"><link name="a">{shape}</link></robot>')
    for length in (1.0, 10.0):
        fc.examples.box((length, 1, 1)).to_trimesh().export(tmp_path / "part.stl")
        (body,) = fc.Robot.load(tmp_path / "r.urdf").links["a"]
        assert np.ptp(body.vertices[:, 0]) == length


def test_a_mesh_of_two_links_is_read_once(tmp_path, monkeypatch):
    shape = '<collision><geometry><mesh filename="part.stl"/></geometry></collision>'
    links = "".join(f'<link name="{x}">{shape}</link>' for x in "ab")
    joint = '<joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>'
    (tmp_path / "r.urdf").write_text(f'<robot name="r">{links}{joint}</robot>')
    fc.examples.box((2, 1, 1)).to_trimesh().export(tmp_path / "part.stl")
    asked, load = [], fc.Polyhedron.load
    monkeypatch.setattr(fc.Polyhedron, "load", lambda *args, **named: asked.append(args) or load(*args, **named))
    robot = fc.Robot.load(tmp_path / "r.urdf")
    assert len(asked) == 1 and [len(robot.links[x]) for x in "ab"] == [1, 1]


def test_wrong_files_and_links_are_named():
    with pytest.raises(fc.InputError, match="describes links and joints, as URDF does"):
        fc.Robot.load(LAMP, srdf=LAMP)
    with pytest.raises(fc.InputError, match=r"skip\[0\]: no link 'neck'; the links are 'foot'"):
        fc.Robot.load(LAMP, skip=[("foot", "neck")])
    with pytest.raises(fc.InputError, match="path is 5; give that of a URDF file"):
        fc.Robot.load(5)


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        (('type="revolute"', 'type="floating"'), "joint 'turn' is 'floating'"),
        (('<child link="lower"/>', '<child link="ball"/>'), "names the link 'ball', which is not there"),
        (("</robot>", ""), "no XML (no element found"),
        (('<robot name="lamp"', "<robot"), "its first element is <robot>, not <robot name=...>"),
        (('size="0.03 0.03 0.3"', 'size="0.03 0.03"'), "link 'lower': collision 0: size of its box is '0.03 0.03'"),
        (('size="0.03 0.03 0.3"', 'size="0.03"'), "give 3 finite numbers"),
        (('axis xyz="0 0 1"', 'axis xyz="0 0"'), "joint 'turn': xyz of its axis is '0 0'; give 3 finite numbers"),
        (('axis xyz="0 0 1"', 'axis xyz="0 0 0"'), "joint 'turn': its axis is 0 0 0"),
        (('<sphere radius="0.06"/>', "<mesh/>"), "link 'shade': collision 0: its mesh has no filename"),
        (('<sphere radius="0.06"/>', '<mesh filename="a.stl" scale="1 1"/>'), "scale of its mesh is '1 1'"),
        (('<sphere radius="0.06"/>', '<mesh filename="a.stl" scale="0 1 1"/>'), "give numbers other than 0"),
        (('<sphere radius="0.06"/>', '<sphere radius="0.06"/><sphere radius="1"/>'), "2 shapes in one geometry"),
        (('radius="0.1"', 'radius="-0.1"'), "link 'foot': collision 0: the radius of its cylinder is '-0.1'"),
        (('radius="0.1"', 'radius="0,1"'), "radius of its cylinder is '0,1'; give one finite number"),
        (('radius="0.1"', ""), "radius of its cylinder is None; give one finite number"),
        (('radius="0.1"', 'radius="inf"'), "radius of its cylinder is 'inf'; give one finite number"),
        (('<sphere radius="0.06"/>', "<cone/>"), "link 'shade': collision 0 is a cone; give one of box, cylinder"),
        (('<sphere radius="0.06"/>', ""), "link 'shade': collision 0 has no shape"),
        (('<geometry><sphere radius="0.06"/></geometry>', ""), "link 'shade': collision 0 has 0 geometries"),
        (('<sphere radius="0.06"/>', '<mesh filename="no.stl"/>'), "no.stl is not there"),
        (('xyz="0 0 0.2"', 'xyz="0 0 nan"'), "xyz of its origin is '0 0 nan'"),
        (('<link name="shade">', '<link name="foot"/><link name="shade">'), "two links are called 'foot'"),
        (('lower="', 'lower="-1 '), "lower of its limit is '-1 "),
        (('xyz="0 0 0.2"', 'xyz="0 0"'), "xyz of its origin is '0 0'"),
        (('<child link="lower"/>', ""), "joint 'turn' has no child"),
        (('name="tilt"', ""), "a joint has no name"),
    ],
)
def test_faults_of_descriptions(tmp_path, change, fault, capsys):
    path = tmp_path / "lamp.urdf"
    path.write_text(LAMP.read_text().replace(*change, 1))
    assert run(["robot", str(path), "--trajectory", str(PATH)]) == 3
    told = capsys.readouterr().err
    assert fault in told and len(told.strip().splitlines()) == 1


def points(*positions, **more):
    """A JointTrajectory of joint `turn`, as JSON."""
    rows = [{"positions": x, "time_from_start": k, **more} for k, x in enumerate(positions)]
    return json.dumps({"joint_names": ["turn"], "points": rows})


@pytest.mark.parametrize(
    ("name", "text", "fault"),
    [
        ("q.csv", "time,turn\n0,0\n1,x\n", "line 3: turn is 'x'"),
        ("q.csv", "time,turn\n0,0\n1\n", "line 3 has 1 values"),
        ("q.csv", "time,neck\n0,0\n1,1\n", "no joint 'neck' takes a value"),
        ("q.json", "{}", "no JointTrajectory"),
        ("q.json", "[]", "no JointTrajectory"),
        ("q.json", '{"joint_names": ["turn"], "points": []}', "0 points"),
        ("q.json", points([0, 1], [1]), "points[0]: positions are [0, 1]; give 1 numbers"),
        ("q.json", points([0], [1], velocities=[0, 1]), "points[0]: velocities are [0, 1]; give 1 numbers"),
        ("q.json", points([0], [None]), "points[1]: positions of turn is None; give a number"),
        ("q.json", points([0], [1], time_from_start=[]), "points[0]: time_from_start is []; give a number"),
        ("q.csv", "time,turn\n0,0\n1,1\n0.5,2\n", "q.csv: times[2] does not lie after times[1]"),
        ("q.npz", "no", "no archive of plain arrays"),
        ("q.npz", "", "no archive of plain arrays"),
        ("q.txt", "", "suffix '.txt' is unknown"),
    ],
)
def test_faults_of_trajectories(tmp_path, name, text, fault, capsys):
    path = tmp_path / name
    path.write_text(text)
    assert run(["robot", str(LAMP), "--trajectory", str(path)]) == 3
    told = capsys.readouterr().err
    assert fault in told and len(told.strip().splitlines()) == 1


def test_what_links_look_like_does_not_matter(tmp_path):
    """Nor does what else describes them; the parser stops at shapes that it does not know."""
    look = '<visual><geometry><cone/></geometry></visual><inertial><mass value="?"/></inertial>'
    path = tmp_path / "lamp.urdf"
    path.write_text(LAMP.read_text().replace('<link name="shade">', f'<link name="shade">{look}'))
    assert fc.Robot.load(path).links.keys() == fc.Robot.load(LAMP).links.keys()


def test_a_capsule(tmp_path):
    """`length` is that of its cylinder: the ball of its end comes down to a plate."""
    shape = '<collision><origin xyz="1 0 0" rpy="0 1.5707963267948966 0"/><geometry>{}</geometry></collision>'
    link = shape.format('<capsule radius="0.25" length="2"/>')
    (tmp_path / "r.urdf").write_text(f'<robot name="r"><link name="a">{link}</link></robot>')
    (body,) = fc.Robot.load(tmp_path / "r.urdf").links["a"]
    wall = fc.box((1, 4, 4)).translated((6, 0, 0))  # its face at 5.5, the capsule's end at 2.25
    hit = fc.first_contact(body.moving(fc.Translation((10, 0, 0))), wall)
    assert hit.time == pytest.approx(0.325, abs=1e-12)
    assert fc.first_contact(body, fc.box((1, 1, 1)).translated((1.9, 0.7, 0.74))).status is fc.Status.FREE


def test_without_yourdfpy_it_says_what_to_install(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "yourdfpy", None)
    assert run(CHECK) == 3
    assert "pip install 'firstcontact[robot]'" in capsys.readouterr().err


def test_a_real_arm():
    """The Panda with its meshes, and the same arm in primitives: poses by yourdfpy."""
    root = next((Path(p) for p in sys.path if (Path(p) / "cmeel.prefix/share/example-robot-data").is_dir()), None)
    if root is None:
        pytest.skip("example-robot-data is not installed")
    folder = root / "cmeel.prefix/share/example-robot-data/robots/panda_description"
    values = {f"panda_joint{k}": 0.2 * k - 0.9 for k in range(1, 8)}
    for name in ("panda.urdf", "panda_collision.urdf"):
        robot = fc.Robot.load(folder / "urdf" / name, srdf=folder / "srdf/panda.srdf")
        course = robot.course([0, 1], {joint: [0, value] for joint, value in values.items()})
        home, there = (by_yourdfpy(folder / "urdf" / name, x) for x in ({}, values))
        for link in ("panda_link4", "panda_hand", "panda_rightfinger"):
            assert moved(course, link, 1.0, home) == pytest.approx(there[link], abs=1e-13)
