"""What searches for curves tell, for annotations."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Protocol, TypedDict

if TYPE_CHECKING:
    import numpy as np

    from firstcontact.exact.fields.roots import AlgebraicRoot
    from firstcontact.result import Stats
    from firstcontact.result_curve import Branch, CurveGraph, ExactParameter, OpenPlace, SingularPoint


class CurveFields(TypedDict, total=False):
    """Fields of IntersectionCurve."""

    branches: tuple[Branch, ...]
    overlap_lines: np.ndarray
    singular_points: tuple[SingularPoint, ...]
    isolated_points: np.ndarray
    two_dimensional: bool
    graph: CurveGraph
    delta: Mapping[tuple[int, int], int]
    common_rulings: tuple[tuple[ExactParameter, ExactParameter], ...]
    correspondence: Mapping[tuple[int, int], int]
    method: str
    open_places: tuple[OpenPlace, ...]
    box: np.ndarray | None
    stats: Stats


class Where(Protocol):
    """Parameters of a point: those of a node of a graph, or of a ruling."""

    @property
    def u(self) -> AlgebraicRoot | None: ...
    @property
    def v(self) -> AlgebraicRoot | None: ...
