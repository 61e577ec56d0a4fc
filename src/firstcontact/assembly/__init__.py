"""Scenes that answer as a whole: which pairs are asked, what may touch, and the first new contact of what does.

new_contact  the verb for bodies that touch at the start
faces        its answer for polyhedra
parts        its answer for solids of planes and quadrics
kept         planes and surfaces that motions carry into themselves
allowed      what a scene lets touch
resting      pairs that are at rest with each other
together     all pairs of a scene
words        answers in the terms of the motions
"""
