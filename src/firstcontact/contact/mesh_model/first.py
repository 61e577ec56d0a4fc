"""`first_contact` and `contact_intervals` of a polyhedron of any shape and a solid of planes and quadrics."""

from firstcontact.contact.mesh_model.by_triangles import first as first
from firstcontact.contact.mesh_model.mesh_intervals import intervals as intervals
