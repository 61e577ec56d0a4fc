"""One adapter per tool, all of the same shape.

An adapter is a class with ``name``, ``prepare(scene) -> state`` (builds what the tool builds once) and
``query(state, scene) -> Answer`` (the motion is the scene's; its bodies are those of ``prepare``).  Where
``prepare`` already asks a first query, ``make`` does not.  Making the adapter imports the tool, so that a
missing tool is an ImportError there.
"""

from importlib import import_module
from typing import Any

ADAPTERS = {
    "firstcontact": "firstcontact_adapter.FirstContact",
    "coal": "coal_adapter.Conservative",
    "coal leaping": "coal_adapter.Leaping",
    "ipctk": "ipctk_adapter.TightInclusion",
    "rapier3d": "rapier_adapter.ShapeCast",
    "python-fcl": "fcl_adapter.ContinuousCollide",
}


def make_adapter(name: str) -> Any:
    """The adapter of that name; ImportError when its tool is not installed."""
    module, cls = ADAPTERS[name].split(".")
    return getattr(import_module(f"peers.{module}"), cls)()
