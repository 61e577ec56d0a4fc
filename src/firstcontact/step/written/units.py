"""Units of length: as files call them, and how many millimetres they are, exactly."""

from __future__ import annotations

from flint import fmpq

from firstcontact.errors import InputError

MILLIMETRES = {
    "mm": fmpq(1), "cm": fmpq(10), "m": fmpq(1000), "km": fmpq(10**6), "um": fmpq(1, 1000), "nm": fmpq(1, 10**6),
    "inch": fmpq(127, 5), "foot": fmpq(1524, 5), "mil": fmpq(127, 5000),
}  # fmt: skip
_NAMES = {
    "millimetre": "mm", "millimeter": "mm", "centimetre": "cm", "centimeter": "cm", "metre": "m", "meter": "m",
    "kilometre": "km", "kilometer": "km", "micrometre": "um", "micrometer": "um", "nanometre": "nm",
    "nanometer": "nm", "in": "inch", "inches": "inch", "ft": "foot", "feet": "foot", "thou": "mil",
}  # fmt: skip


def unit_of(name: str) -> str | None:
    """The unit by any of its names."""
    lower = name.strip().lower()
    found = _NAMES.get(lower, lower)
    return found if found in MILLIMETRES else None


def checked(unit: str) -> str:
    found = unit_of(unit) if isinstance(unit, str) else None
    if found is None:
        raise InputError(f"unit is {unit!r}; give one of {', '.join(MILLIMETRES)}")
    return found
