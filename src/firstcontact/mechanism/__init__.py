"""Mechanisms: links, the joints between them, and the values of these over one clock.

joints      a joint: what it lets its child do
values      joint values over the time, as polynomials between given times
tables      joint values from files
mechanism   the tree of links and joints
course      a mechanism at work: its bodies as they move, and what they meet
sweep       each joint driven over its limits
"""
