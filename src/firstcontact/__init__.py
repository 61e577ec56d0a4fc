"""When, where and with which faces do two moving shapes first touch?  Exact answers, with proof.

>>> import firstcontact as fc
>>> cube = fc.examples.box((1, 1, 1))
>>> hit = fc.first_contact(cube.translated((-3, 0, 0)).moving(fc.Translation((4, 0, 0))), cube)
>>> hit.status.name, hit.time
('CONTACT', 0.5)
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from firstcontact import brackets as brackets
    from firstcontact import examples as examples
    from firstcontact.assembly.new_contact import first_new_contact as first_new_contact
    from firstcontact.batch.questions import columns as columns
    from firstcontact.batch.verb import first_contacts as first_contacts
    from firstcontact.batch.verb import many_contact_intervals as many_contact_intervals
    from firstcontact.body.compound.compound import Compound as Compound
    from firstcontact.body.polyhedron.polyhedron import Polyhedron as Polyhedron
    from firstcontact.body.ruled.rational_curve import RationalCurve as RationalCurve
    from firstcontact.body.ruled.surface import RuledSurface as RuledSurface
    from firstcontact.body.solid.composite_quadric import CompositeQuadric as CompositeQuadric
    from firstcontact.body.solid.primitives import box as box
    from firstcontact.body.solid.primitives import cone as cone
    from firstcontact.body.solid.primitives import cylinder as cylinder
    from firstcontact.body.solid.primitives import ellipsoid as ellipsoid
    from firstcontact.body.solid.primitives import frustum as frustum
    from firstcontact.body.solid.primitives import half_space as half_space
    from firstcontact.body.solid.primitives import hyperboloid as hyperboloid
    from firstcontact.body.solid.primitives import paraboloid as paraboloid
    from firstcontact.body.solid.primitives import quadric as quadric
    from firstcontact.body.solid.primitives import sphere as sphere
    from firstcontact.body.torus.torus import Torus as Torus
    from firstcontact.body.torus.torus import torus as torus
    from firstcontact.errors import FirstContactError as FirstContactError
    from firstcontact.errors import InputError as InputError
    from firstcontact.errors import UnsupportedPair as UnsupportedPair
    from firstcontact.mechanism.joints import Joint as Joint
    from firstcontact.mechanism.mechanism import Mechanism as Mechanism
    from firstcontact.motion.arrays import Poses as Poses
    from firstcontact.motion.arrays import Rotations as Rotations
    from firstcontact.motion.arrays import Translations as Translations
    from firstcontact.motion.moving import Moving as Moving
    from firstcontact.motion.rational import RationalMotion as RationalMotion
    from firstcontact.motion.rotation import Rotation as Rotation
    from firstcontact.motion.screw import Screw as Screw
    from firstcontact.motion.sequence import Sequence as Sequence
    from firstcontact.motion.trajectory import Trajectory as Trajectory
    from firstcontact.motion.translation import Translation as Translation
    from firstcontact.query import contact_intervals as contact_intervals
    from firstcontact.query import contact_pairs as contact_pairs
    from firstcontact.query import first_contact as first_contact
    from firstcontact.query import intersection_curve as intersection_curve
    from firstcontact.result import AlgebraicNumber as AlgebraicNumber
    from firstcontact.result import ContactInterval as ContactInterval
    from firstcontact.result import ContactIntervals as ContactIntervals
    from firstcontact.result import ContactPairs as ContactPairs
    from firstcontact.result import Element as Element
    from firstcontact.result import ExactAngle as ExactAngle
    from firstcontact.result import FirstContact as FirstContact
    from firstcontact.result import JointValue as JointValue
    from firstcontact.result import Status as Status
    from firstcontact.result_curve import IntersectionCurve as IntersectionCurve
    from firstcontact.result_table import ContactIntervalTable as ContactIntervalTable
    from firstcontact.result_table import ContactTable as ContactTable
    from firstcontact.robot.robot import Robot as Robot
    from firstcontact.scene.load import Scene as Scene
    from firstcontact.scene.written import from_dict as from_dict
    from firstcontact.step.assembly import Assembly as Assembly
    from firstcontact.step.assembly import from_shape as from_shape
    from firstcontact.step.assembly import load_step as load_step
    from firstcontact.toolpath.program import ToolPath as ToolPath
    from firstcontact.toolpath.tool import Tool as Tool

__version__ = "0.1.0"

_HOME = {
    "CompositeQuadric": "body.solid.composite_quadric",
    "Moving": "motion.moving",
    "Polyhedron": "body.polyhedron.polyhedron",
    "RationalCurve": "body.ruled.rational_curve",
    "RuledSurface": "body.ruled.surface",
    "box": "body.solid.primitives",
    "cone": "body.solid.primitives",
    "cylinder": "body.solid.primitives",
    "ellipsoid": "body.solid.primitives",
    "frustum": "body.solid.primitives",
    "half_space": "body.solid.primitives",
    "hyperboloid": "body.solid.primitives",
    "paraboloid": "body.solid.primitives",
    "quadric": "body.solid.primitives",
    "sphere": "body.solid.primitives",
    "Torus": "body.torus.torus",
    "torus": "body.torus.torus",
    "IntersectionCurve": "result_curve",
    "FirstContactError": "errors",
    "InputError": "errors",
    "UnsupportedPair": "errors",
    "Joint": "mechanism.joints",
    "Mechanism": "mechanism.mechanism",
    "Poses": "motion.arrays",
    "Robot": "robot.robot",
    "Rotations": "motion.arrays",
    "Translations": "motion.arrays",
    "RationalMotion": "motion.rational",
    "Rotation": "motion.rotation",
    "Screw": "motion.screw",
    "Sequence": "motion.sequence",
    "Trajectory": "motion.trajectory",
    "Translation": "motion.translation",
    "columns": "batch.questions",
    "contact_condition": "contact.ruled.contact_condition",
    "contact_intervals": "query",
    "contact_pairs": "query",
    "first_contact": "query",
    "first_contacts": "batch.verb",
    "first_new_contact": "assembly.new_contact",
    "many_contact_intervals": "batch.verb",
    "Scene": "scene.load",
    "from_dict": "scene.written",
    "intersection_curve": "query",
    "AlgebraicNumber": "result",
    "ContactInterval": "result",
    "ContactIntervals": "result",
    "ContactPairs": "result",
    "Element": "result",
    "ExactAngle": "result",
    "FirstContact": "result",
    "JointValue": "result",
    "Status": "result",
    "Assembly": "step.assembly",
    "from_shape": "step.assembly",
    "load_step": "step.assembly",
    "Tool": "toolpath.tool",
    "ToolPath": "toolpath.program",
    "Compound": "body.compound.compound",
    "ContactIntervalTable": "result_table",
    "ContactTable": "result_table",
}
_MODULES = ("brackets", "examples")
__all__ = [*_HOME, *_MODULES, "__version__"]  # noqa: PLE0604


def __getattr__(name: str) -> object:
    if name in _HOME:
        value = getattr(import_module(f"firstcontact.{_HOME[name]}"), name)
    elif name in _MODULES:
        value = import_module(f"firstcontact.{name}")
    else:
        raise AttributeError(f"module 'firstcontact' has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
