"""Moving rulings: models of events, boxes and their search."""
