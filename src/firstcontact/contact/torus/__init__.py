"""Tori against all bodies, certified.

between  the pose of one body as seen from another one over a stretch of time, with proved errors
cells    bodies as cells: hulls of few points, halved where that is needed
heights  how far points are from what is to be avoided: a torus, or a model's surfaces
apart    the proof that cells stay out of it
points   points of bodies that meet it alone, exact
passages what is proved of these from a time on
lasting  the torus as what is followed in contact
first    the verbs
"""
