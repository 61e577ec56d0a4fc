"""The still picture: what is on it, and what is said when it cannot be drawn."""

import ctypes.util
import importlib.util
import sys

import numpy as np
import pytest

from firstcontact.errors import InputError
from firstcontact.view import png
from view import scenes

DRAWS = importlib.util.find_spec("pyvista") is not None and (
    not sys.platform.startswith("linux") or all(ctypes.util.find_library(name) for name in ("EGL", "GL"))
)


@pytest.mark.skipif(not DRAWS, reason="needs the extra view, libEGL and libGL")
@pytest.mark.parametrize(
    "make, touching",
    [(scenes.first_hit, 400), (scenes.undecided, 0), (scenes.plugged, 1000), (scenes.tip_on_floor, 10)],
)
def test_both_bodies_and_the_contact_are_drawn(make, touching, tmp_path):
    from PIL import Image

    path = png.write_png(tmp_path / "hit.png", make(), size=(400, 300))
    with Image.open(path) as image:
        assert image.size == (400, 300)
        pixels = np.asarray(image.convert("RGB"), int)
    red, green, blue = np.moveaxis(pixels, 2, 0)
    assert np.sum(blue > red + 35) > 1200  # body a
    assert np.sum((red > blue + 35) & (green > blue + 15)) > 2000  # body b
    accent = np.sum((red > 150) & (green < 90) & (blue < 110))
    assert accent > touching if touching else accent == 0  # marker, arrow, shared curve, touched elements


def test_missing_pyvista_is_one_line(monkeypatch, tmp_path):
    monkeypatch.setattr(png, "find_spec", lambda name: None)
    with pytest.raises(InputError) as error:
        png.write_png(tmp_path / "hit.png", scenes.undecided())
    how = "pip install 'firstcontact[view]', or '.[view]' in a checkout"
    assert str(error.value) == f"drawing a PNG needs pyvista: {how}"


def test_missing_libraries_are_one_line(monkeypatch, tmp_path):
    monkeypatch.setattr(png, "find_spec", lambda name: object())
    monkeypatch.setattr(png.sys, "platform", "linux")
    monkeypatch.setattr(png.ctypes.util, "find_library", lambda name: None)
    with pytest.raises(InputError) as error:
        png.write_png(tmp_path / "hit.png", scenes.undecided())
    assert str(error.value) == "drawing a PNG needs libEGL and libGL: apt-get install libegl1 libgl1"
    assert not (tmp_path / "hit.png").exists()
