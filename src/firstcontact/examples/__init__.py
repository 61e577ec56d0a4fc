"""Bodies to try things on, and encounters of bodies that are hard for trees of boxes.

Solids (`examples.solids`): ``box``, ``box_with_knob``, ``noisy_sphere``, ``torus``, ``spur_gear``, ``lid``, ``arm``,
``post``.  Encounters, each of two bodies and a motion: of rods (`examples.rods`) and of facets (`examples.layers`).

>>> import firstcontact as fc
>>> noisy_sphere(1000)
<Polyhedron 'noisy_sphere': solid, 492 vertices, 1470 edges, 980 faces>
>>> reguli = layered_reguli(50)
>>> fc.first_contact(reguli.moving, reguli.resting).status.name
'CONTACT'
"""

from firstcontact.examples.encounter import Encounter
from firstcontact.examples.layers import convex_pair, nested_shells, slats_over_points, tangent_plates
from firstcontact.examples.rods import layered_reguli, near_miss_combs, nested_hyperboloids, woven_reguli, woven_rods
from firstcontact.examples.solids import arm, box, box_with_knob, lid, noisy_sphere, post, spur_gear, torus

__all__ = [
    "Encounter",
    "arm",
    "box",
    "box_with_knob",
    "convex_pair",
    "layered_reguli",
    "lid",
    "near_miss_combs",
    "nested_hyperboloids",
    "nested_shells",
    "noisy_sphere",
    "post",
    "slats_over_points",
    "spur_gear",
    "tangent_plates",
    "torus",
    "woven_reguli",
    "woven_rods",
]
