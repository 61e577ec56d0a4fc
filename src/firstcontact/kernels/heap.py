"""A binary heap of node pairs keyed by the earliest possible contact, in caller's arrays."""

from __future__ import annotations

from firstcontact.kernels.jit import uncounted


@uncounted
def heap_push(keys, pairs, n, key, a, b):
    """Add (key, a, b) to the first n entries; the caller has checked the room.  Returns n + 1."""
    i = n
    while i > 0:
        parent = (i - 1) >> 1
        if keys[parent] <= key:
            break
        keys[i] = keys[parent]
        pairs[i, 0], pairs[i, 1] = pairs[parent, 0], pairs[parent, 1]
        i = parent
    keys[i] = key
    pairs[i, 0], pairs[i, 1] = a, b
    return n + 1


@uncounted
def heap_pop(keys, pairs, n):
    """Remove the first of n entries (the caller has read it).  Returns n - 1."""
    n -= 1
    key, a, b = keys[n], pairs[n, 0], pairs[n, 1]
    i = 0
    while True:
        child = 2 * i + 1
        if child >= n:
            break
        if child + 1 < n and keys[child + 1] < keys[child]:
            child += 1
        if keys[child] >= key:
            break
        keys[i] = keys[child]
        pairs[i, 0], pairs[i, 1] = pairs[child, 0], pairs[child, 1]
        i = child
    keys[i] = key
    pairs[i, 0], pairs[i, 1] = a, b
    return n
