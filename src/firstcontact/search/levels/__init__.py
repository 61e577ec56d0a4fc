"""Motions composed of several: rounds of linearisation, level by level."""
