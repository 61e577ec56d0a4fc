"""All contacts in time; by now those that last."""
