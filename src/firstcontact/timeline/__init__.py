"""All contacts in time: contacts that last."""
