"""The walk comes back for more room before its heap or its stack is full, whichever it works on."""

import numpy as np

from firstcontact import examples, first_contact
from firstcontact.contact.polyhedra import earliest
from firstcontact.search.trees import state


def test_the_heap_fills_while_pairs_wait_on_the_stack(monkeypatch):
    used = []

    class Narrow(state.WalkState):
        """Little room at the front of large arrays, so that a walk that overruns it does no harm."""

        __slots__ = ()

        def __init__(self):
            super().__init__()
            self.keys, self.pairs = np.empty(1 << 16)[:16], np.empty((1 << 16, 2), np.int32)[:16]

        def grow(self):
            used.append(int(self.integers[state.HEAP]) / len(self.keys))
            return super().grow()

    monkeypatch.setattr(earliest, "borrow_state", Narrow)
    monkeypatch.setattr(earliest, "return_state", lambda state: None)
    rods = examples.nested_hyperboloids(200)
    hit = first_contact(rods.moving, rods.resting, engine="boxes")
    assert (hit.element_a.index, hit.element_b.index) == rods.first
    assert used and max(used) <= 1.0
