"""Corners at a pole of a face, such as the tip of a cone: one for each triangle there.

OpenCASCADE has one corner for many triangles around a pole.  In space that corner is the same point whatever its
parameter about the axis is; in parameters the triangles lie far across the face, where nothing tells how near they are.
"""

from __future__ import annotations

Corner = tuple[float, float]
Triangle = tuple[int, int, int]
Segment = tuple[int, int]


def spread(
    uv: list[Corner], ids: list[int], triangles: list[Triangle], poles: set[Segment]
) -> tuple[list[Triangle], set[Segment]]:  # fmt: skip
    """The triangles of a face, and its sides that are one point, with new corners at poles added to `uv` and `ids`.

    They cover the same parameters: what is between two neighbours at a pole is a triangle that has no area in space.
    """
    for pole in {ids[i] for i, _ in poles}:
        corners = {k for side in poles for k in side if ids[k] == pole}
        bases = _bases(uv, triangles, corners)
        if bases is None:
            continue
        own = [x for x in triangles if not corners & set(x)]
        ends = sorted(corners, key=lambda k: uv[k])
        if uv[bases[0][0]][0] > uv[bases[-1][1]][0]:
            ends.reverse()
        row = [ends[0]]
        for i, j in bases[1:-1]:
            row.append(len(uv))
            uv.append((0.5 * (uv[i][0] + uv[j][0]), uv[ends[0]][1]))
            ids.append(pole)
        row.append(ends[-1])
        own += [(at, i, j) for at, (i, j) in zip(row, bases, strict=True)]
        own += [(then, at, i) for at, then, (i, _) in zip(row, row[1:], bases[1:], strict=False)]
        sides = {(min(i, j), max(i, j)) for i, j in zip(row, row[1:], strict=False)}
        triangles, poles = own, {x for x in poles if not corners & set(x)} | sides
    return triangles, poles


def _bases(uv: list[Corner], triangles: list[Triangle], corners: set[int]) -> list[Segment] | None:
    """The sides across from the pole of triangles with one corner there, each from where the one before ends; None
    where they are few, leave gaps or go to and fro."""
    after = {}
    for triangle in triangles:
        at = [k for k in range(3) if triangle[k] in corners]
        if len(at) == 1:
            after[triangle[at[0] - 2]] = triangle[at[0] - 1]
    begin = [i for i in after if i not in after.values()]
    if len(after) < 2 or len(begin) != 1 or len({uv[k][1] for k in corners}) != 1:
        return None
    found, (i,) = list[Segment](), begin
    while i in after:
        found.append((i, after[i]))
        i = after[i]
    steps = [uv[j][0] - uv[i][0] for i, j in found]
    is_row = len(found) == len(after) and (min(steps) >= 0.0 or max(steps) <= 0.0)
    return found if is_row else None
