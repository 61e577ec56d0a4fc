"""How Numba's own is replaced."""

from __future__ import annotations

from contextlib import nullcontext

import numba


def put(place: object, **new: object) -> None:
    for name, value in new.items():
        if name not in vars(place):
            raise AttributeError(f"{place} of Numba {numba.__version__} has no {name}")
        setattr(place, name, value)


def nothing(*_: object, **__: object) -> None:
    pass


_CONTEXT = nullcontext()


def no_context(*_: object, **__: object) -> nullcontext[None]:
    return _CONTEXT
