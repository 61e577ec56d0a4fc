"""All kinds of motions, for annotations: nothing loads them for that."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from firstcontact.motion.linkage import Linkage
    from firstcontact.motion.product import Product
    from firstcontact.motion.rational import RationalMotion
    from firstcontact.motion.rotation import Rotation
    from firstcontact.motion.screw import Screw
    from firstcontact.motion.sequence import Sequence
    from firstcontact.motion.trajectory import Trajectory
    from firstcontact.motion.translation import Translation

Single: TypeAlias = "Translation | Rotation | Screw | RationalMotion | Product"
"""What a step of a motion makes."""
AnyMotion: TypeAlias = "Single | Sequence | Trajectory | Linkage"
