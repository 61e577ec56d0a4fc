"""How often the boxes of one body overlap those of another, told from the sizes of a few."""

from __future__ import annotations

import numpy as np

from firstcontact.kernels.jit import kernel, uncounted

_SAMPLE = 32


@kernel
def crowding(boxes_a, links_a, boxes_b, links_b):
    """The share of all pairs of leaves that would overlap if the leaves of either tree lay anywhere in its box."""
    leaves_a, leaves_b = np.empty(_SAMPLE, np.int64), np.empty(_SAMPLE, np.int64)
    _some_leaves(links_a, leaves_a)
    _some_leaves(links_b, leaves_b)
    total = 0.0
    for i in leaves_a:
        for j in leaves_b:
            share = 1.0
            for k in range(3):
                room = max(boxes_a[0, k + 3] - boxes_a[0, k], boxes_b[0, k + 3] - boxes_b[0, k])
                both = (boxes_a[i, k + 3] - boxes_a[i, k]) + (boxes_b[j, k + 3] - boxes_b[j, k])
                if both < room:
                    share *= both / room
            total += share
    return total / (_SAMPLE * _SAMPLE)


@uncounted
def _some_leaves(links, out):
    """Leaves spread evenly over the rows of a tree; the last row is one."""
    for k in range(_SAMPLE):
        i = k * links.shape[0] // _SAMPLE
        while links[i, 1] >= 0 and i + 1 < links.shape[0]:
            i += 1
        out[k] = i
