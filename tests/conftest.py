"""One hypothesis profile for all tests: the same examples in every run, no deadline on a busy machine."""

import hypothesis

hypothesis.settings.register_profile("fixed", derandomize=True, deadline=None, database=None, print_blob=True)
hypothesis.settings.load_profile("fixed")
