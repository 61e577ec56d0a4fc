"""How one moving body moves beside another.

pieces       stretches of time in which the relative motion is one simple motion
stretches    the same for the searches, with poses at each instant
polynomial, projective   rational motions as polynomials in time
curved       motions that are no polynomials: power series in balls
clocks       turning speeds and their common measure
sweep        bounds on where points pass
cells        sources of the cells that kernels read
"""
