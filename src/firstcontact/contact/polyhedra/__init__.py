"""Two polyhedra.

problems               what each kind of motion gives to a search; `engines` chooses among the ways to search
earliest, intervals, overlap   the first contact, all of them, and how bodies lie at an instant
standstill, planar, generic_turns   motions that stand still, stay in a plane, or turn by irrational angles
after_start            flush faces that part, or go on, from a moment after the start on
prisms                 flat parts that move in one plane, or advance across it
answers                results out of what was found
"""
