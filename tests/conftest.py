"""One hypothesis profile for all tests: the same examples in every run, no deadline on a busy machine; scene files."""

import hypothesis
import pytest

hypothesis.settings.register_profile("fixed", derandomize=True, deadline=None, database=None, print_blob=True)
hypothesis.settings.load_profile("fixed")


@pytest.fixture
def scene(tmp_path):
    """Write text as a scene file and give its path."""

    def write(text):
        path = tmp_path / "scene.toml"
        path.write_text(text)
        return path

    return write
