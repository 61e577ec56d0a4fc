"""How many random scenes the tests look at: a share by default, all with FIRSTCONTACT_THOROUGH=1.

With FIRSTCONTACT_THOROUGH=rest the tests that are left out by default run, and no others, with the default's scenes.
"""

import os

THOROUGH = os.environ.get("FIRSTCONTACT_THOROUGH") == "1"
REST = os.environ.get("FIRSTCONTACT_THOROUGH") == "rest"


def amount(n: int, share: int = 6) -> int:
    """n, or the share of it that runs by default; seeds start at the same number either way."""
    return n if THOROUGH else max(1, n // share)
