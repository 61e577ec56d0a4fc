"""Products of polynomials in Bernstein form."""

from __future__ import annotations

from functools import lru_cache
from math import comb

import numpy as np


@lru_cache(maxsize=64)
def product_table(m: int, n: int) -> np.ndarray:
    """(m + 1, n + 1): what coefficients a and b, of polynomials of these degrees, add to number a + b of the product.
    """
    return np.array([[comb(m, a) * comb(n, b) / comb(m + n, a + b) for b in range(n + 1)] for a in range(m + 1)])


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Of polynomials along the last axis."""
    pairs: np.ndarray = a[..., :, None] * b[..., None, :]
    table = _gathering(*pairs.shape[-2:])
    return pairs.reshape(*pairs.shape[:-2], len(table)) @ table


@lru_cache(maxsize=64)
def _gathering(m: int, n: int) -> np.ndarray:
    """(m n, m + n - 1): what products of one of m coefficients and one of n add to those of the product."""
    table = np.zeros((m, n, m + n - 1))
    a, b = np.indices((m, n))
    table[a, b, a + b] = product_table(m - 1, n - 1)
    return table.reshape(m * n, m + n - 1)
