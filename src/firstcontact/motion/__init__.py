"""Motions: one file each; `relative` turns two moving bodies into one."""
