"""All kinds of bodies, for annotations: nothing loads them for that."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from firstcontact.body.compound.compound import Compound
    from firstcontact.body.polyhedron.polyhedron import Polyhedron
    from firstcontact.body.ruled.strip import RuledStrip
    from firstcontact.body.ruled.surface import RuledSurface
    from firstcontact.body.solid.composite_quadric import CompositeQuadric
    from firstcontact.body.torus.torus import Torus
    from firstcontact.motion.moving import Moving

Ruled: TypeAlias = "RuledSurface | RuledStrip"
RuledBody: TypeAlias = "RuledSurface | RuledStrip | Moving"
Model: TypeAlias = "CompositeQuadric | Moving"
"""A solid of planes and quadrics, at rest or moving."""
Shape: TypeAlias = "Polyhedron | CompositeQuadric | RuledSurface | RuledStrip | Torus | Compound"
"""A body at rest."""
Body: TypeAlias = "Shape | Moving"
