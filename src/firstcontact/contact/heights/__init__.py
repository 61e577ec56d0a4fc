"""Bodies whose heights along one direction are known at all times: when they can meet at all, and landings of one on
the level top of another.

ranges     between which heights a body lies, exactly
meeting    when the heights of two bodies in motion have one in common
landing    whether they share a point at an instant at which one is on the other
told       first contacts and all contacts from these, where other ways leave them open
"""
