"""The smallest of many keys, in time that grows with their number."""

from firstcontact.kernels.jit import uncounted


@uncounted
def select(keys, order, first, last, middle):
    """Rearrange so that the smallest keys of [first, last) stand before `middle` (quickselect, middle pivots)."""
    lo, hi = first, last - 1
    while lo < hi:
        pivot = keys[(lo + hi) // 2]
        i, j = lo, hi
        while i <= j:
            while keys[i] < pivot:
                i += 1
            while pivot < keys[j]:
                j -= 1
            if i <= j:
                keys[i], keys[j] = keys[j], keys[i]
                order[i], order[j] = order[j], order[i]
                i += 1
                j -= 1
        if middle <= j:
            hi = j
        elif middle >= i:
            lo = i
        else:
            return
