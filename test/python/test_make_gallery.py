"""scripts/make_gallery draws the pictures of doc/gallery.md. Needs the programs built."""
import os
import pathlib
import re
import subprocess

import pytest
from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAMS = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build")) / "devel/lib/raven2_trainer"


def configured(name):
    """Names in config/render.yaml's list of cameras, or of overlays."""
    text = (ROOT / "config/render.yaml").read_text()
    if name == "cameras":
        return set(re.findall(r"\{name: (\w+)", text))
    return set(re.search(r"video: \[(.*)\]", text).group(1).split(", "))


def test_the_page_shows_every_camera_and_overlay():
    shown = re.findall(r"images/gallery/(\w+)\.png", (ROOT / "doc/gallery.md").read_text())
    assert configured("cameras") | configured("overlays") <= set(shown)
    files = {path.stem for path in (ROOT / "doc/images/gallery").glob("*.png")}
    assert files == set(shown) and len(shown) == len(files)


def test_a_name_of_no_picture_is_an_error(tmp_path):
    done = subprocess.run([ROOT / "scripts/make_gallery", "--only", "top,gost", "--output", tmp_path / "new"],
                          capture_output=True, text=True, check=False)
    assert done.returncode == 1 and done.stderr == "make_gallery: no camera or overlay is called gost\n"
    assert not (tmp_path / "new").exists()


@pytest.mark.skipif(not (PROGRAMS / "render_session").exists(), reason="render_session is not built")
def test_pictures_are_drawn_at_their_moment(tmp_path):
    done = subprocess.run([ROOT / "scripts/make_gallery", "--only", "top,workspace", "--size", "128x72", "--output",
                           tmp_path], capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr
    pictures = {path.stem: Image.open(path).convert("RGB") for path in (tmp_path / "images/gallery").glob("*.png")}
    assert set(pictures) == {"top", "workspace"} and all(p.size == (128, 72) for p in pictures.values())
    amber = sum(r > 150 and 90 < g < 190 and b < 90 for r, g, b in pictures["workspace"].getdata())
    assert amber > 200, "the amber wall at the limit is drawn"
    assert not (tmp_path / "gallery.md").exists()
