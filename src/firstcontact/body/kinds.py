"""All kinds of bodies, for annotations: nothing loads them for that."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, TypeAlias

if TYPE_CHECKING:
    import numpy as np

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


class MeshLike(Protocol):
    """A mesh of trimesh, or what looks like one."""

    @property
    def vertices(self) -> np.ndarray: ...
    @property
    def faces(self) -> np.ndarray: ...


class CadShape(Protocol):
    """A shape of build123d or CadQuery."""

    @property
    def wrapped(self) -> object: ...


class Part(Protocol):
    """A part or an assembly of a STEP file."""

    def as_body(self) -> Shape: ...


AnyBody: TypeAlias = "Body | MeshLike | CadShape | Part"
"""What verbs take for a body."""
