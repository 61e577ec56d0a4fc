"""Make the meshes of the example scenes: python examples/make_meshes.py

The files are committed; running this again writes the same meshes (a test holds that true).
"""

from pathlib import Path

from firstcontact import examples
from firstcontact.io.meshes import write_mesh

HERE = Path(__file__).resolve().parent
HINGE = (0.0, 0.0, 0.45)
"""A point of the hinge; its axis runs along y, just above the rim of the box."""


def meshes():
    """File name -> body."""
    lid = examples.lid(1200).translated(HINGE).rotated((0, 1, 0), degrees=-100, point=HINGE)
    return {
        "box.stl": examples.box_with_knob(1000),
        "lid.stl": lid,
        "gear12.ply": examples.spur_gear(1200, teeth=12, pitch_radius=0.6, bore=0.2, backlash=0.15),
        "gear20.ply": examples.spur_gear(2000, teeth=20, pitch_radius=1.0, bore=0.4, backlash=0.15),
    }


def main(folder=HERE):
    for name, body in meshes().items():
        write_mesh(Path(folder) / name, body.vertices, body.triangles)


if __name__ == "__main__":
    main()
