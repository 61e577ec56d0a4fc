"""Where ruled surfaces have a tangent plane, as far as doubles tell: there are no cusps of curves on them, and no apex.

The plane of X = (1 - s) A + s B in homogeneous coordinates is X ^ X_u ^ X_s = l ^ ((1 - s) A' + s B'), l = A ^ B: its
normal, linear in s, is nowhere zero where its Bernstein coefficients are on one side of a plane.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from firstcontact.curves.certified.bernstein import product
from firstcontact.pairs.ruled_ruled import PAIRS

if TYPE_CHECKING:
    from firstcontact.curves.certified.chains import Chain

# Coefficients that are not told from zero, in parts of the largest one.
ZERO = 1e-9
# Of l ^ C, for x, y and z: components of l, components of C, signs.
OF_LINE = np.array([[3, 4, 5], [1, 2, 5], [0, 2, 4]])
OF_POINT = np.array([[3, 2, 1], [3, 2, 0], [3, 1, 0]])
LINE = np.array(PAIRS).T
SIGNS = np.array([[1.0, -1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, 1.0]])


def irregular_parts(chain: Chain) -> np.ndarray:
    """Numbers of the parts on which the normal may be zero."""
    ends, parts = _about_middle(chain), len(chain.points)
    sides = ends.reshape(parts, 2, 4, -1)
    towards = SIGNS[:, :, None] * (sides[..., 1:] - sides[..., :-1])[:, :, OF_POINT]
    normals = product(_lines(ends)[:, None, OF_LINE], towards).sum(axis=3)
    usual = normals[..., normals.shape[-1] // 2].sum(axis=1)
    along = (usual[:, None, None] @ normals).reshape(parts, -1)
    room = ZERO * np.abs(normals).reshape(parts, -1).max(axis=1) * np.abs(usual).max(axis=1)
    return np.flatnonzero(along.min(axis=1) <= room)


def chain_lines(chain: Chain) -> np.ndarray:
    """(parts, 6, m): Bernstein coefficients of l, about the middle of the chain."""
    return _lines(_about_middle(chain))


def _about_middle(chain: Chain) -> np.ndarray:
    ends = chain.points.copy()
    middle = 0.5 * (chain.box[0] + chain.box[1])[:, None]
    for k in (0, 4):
        ends[:, k : k + 3] -= middle * ends[:, k + 3 : k + 4]
    return ends


def _lines(ends: np.ndarray) -> np.ndarray:
    products = product(ends[:, :4, None], ends[:, None, 4:])
    return (products - products.swapaxes(1, 2))[:, *LINE]  # type: ignore[no-any-return]
