"""Makes door.stp and frame.stp by OpenCASCADE (extra "step"): two parts on a hinge, for hinge.toml.

python examples/make_hinge.py
"""

from pathlib import Path

from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut, BRepAlgoAPI_Fuse
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt
from OCP.Interface import Interface_Static
from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer

HERE = Path(__file__).parent


def box(at, size):
    return BRepPrimAPI_MakeBox(gp_Pnt(*at), *size).Shape()


def cylinder(at, direction, radius, height):
    return BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(*at), gp_Dir(*direction)), radius, height).Shape()


def write(name, shape):
    writer = STEPControl_Writer()
    Interface_Static.SetCVal_s("write.step.product.name", name)
    writer.Transfer(shape, STEPControl_StepModelType.STEPControl_AsIs)
    writer.Write(str(HERE / f"{name}.stp"))


def main():
    up = (0, 0, 1)
    door = BRepAlgoAPI_Fuse(box((3, -2, 0), (60, 4, 80)), cylinder((0, 0, 0), up, 4, 80)).Shape()
    door = BRepAlgoAPI_Cut(door, cylinder((0, 0, -1), up, 2, 82)).Shape()
    door = BRepAlgoAPI_Fuse(door, cylinder((54, 2, 40), (0, 1, 0), 3, 8)).Shape()  # the knob
    write("door", door)
    frame = BRepAlgoAPI_Fuse(box((-43, 8, -2), (30, 60, 84)), cylinder((0, 0, -2), up, 1.9, 84)).Shape()
    frame = BRepAlgoAPI_Fuse(frame, box((-15, -1.5, -6), (17, 20, 4))).Shape()
    write("frame", frame)


if __name__ == "__main__":
    main()
