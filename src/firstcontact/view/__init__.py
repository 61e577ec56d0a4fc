"""Pictures of results: an offline HTML page and a PNG.  Reads results, computes no contact."""
