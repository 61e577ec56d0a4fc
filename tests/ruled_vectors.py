"""The known answers of `data/ruled_vectors.json`.

Points, curves and times come from closed forms put into implicit equations, from multi-start Newton iterations and
from distance minimisation, not from brackets.  All numbers are strings: rationals, decimals or closed forms.
"""

from __future__ import annotations

import json
from pathlib import Path

DATA = Path(__file__).parent / "data" / "ruled_vectors.json"


def cases(*kinds: str) -> list[dict]:
    """The cases of these kinds ("segments", "static_full", "static_box", "moving"), all without kinds."""
    found = json.loads(DATA.read_text())["cases"]
    return [case for case in found if not kinds or case["kind"] in kinds]
