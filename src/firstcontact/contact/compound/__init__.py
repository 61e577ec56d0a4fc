"""Bodies of several pieces: parts and assemblies.

first      `first`, the first contact, and `intervals`, all of them: of the pieces, each pair while it may meet
windows    when that is, by boxes around what moves
answer     one answer out of those of the pieces
"""
