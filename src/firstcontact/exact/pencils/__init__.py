"""Pencils of quadrics and conics, and the classes of contact that their roots tell."""
