"""Entities in the text of a STEP file, and what they refer to."""

from __future__ import annotations

import re

DEFINED = re.compile(rb"(?:^|[;\s])#(\d+)\s*=\s*(\(|[A-Z_0-9]+)")
"""An entity: its number and its kind."""
USED = re.compile(rb"#(\d+)")
REPRESENTATION = re.compile(rb"#(\d+)\s*=\s*[A-Z_]*SHAPE_REPRESENTATION\s*\(([^;]*);")
"""What represents a shape: its number, and its items with what else follows."""
