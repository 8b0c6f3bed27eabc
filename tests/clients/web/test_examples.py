"""The p5.js and three.js pages draw the fingers of a service, with the real libraries."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.browser import needs_chromium, visit

WEB = Path(__file__).parents[3] / "clients" / "web"
LIBRARIES = Path(__file__).parent / "libraries" / "node_modules"
EXAMPLES = {
    "p5": ["p5/lib/p5.min.js"],
    "three": ["three/build/three.module.js", "three/build/three.core.js"],
}
# Once the page shows fingers: its status, and how many pixels have the colours of touch and hover.
LOOK = """<script>
// After a frame of the page was drawn; later, the picture of WebGL is gone.
const later = () => setTimeout(() => requestAnimationFrame(look), 100);
function look() {
  const text = document.querySelector("#status").textContent;
  const source = document.querySelector("canvas");
  if (!source || !text.includes("fingers: 4")) return later();
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [source.width, source.height];
  const picture = copy.getContext("2d");
  picture.drawImage(source, 0, 0);
  const { data } = picture.getImageData(0, 0, copy.width, copy.height);
  let [orange, blue] = [0, 0];
  for (let i = 0; i < data.length; i += 4) {
    orange += data[i] > 200 && data[i + 2] < 120;
    blue += data[i] < 120 && data[i + 2] > 200;
  }
  if (orange < 100 || blue < 100) return later();
  parent.postMessage({ text, orange, blue });
}
later();
</script></body>"""


def library(path: str) -> str:
    file = LIBRARIES / path
    if not file.is_file():
        sentence = f"{path} is not installed: npm install in {LIBRARIES.parent}"
        if os.environ.get("HALO_CI"):
            pytest.fail(sentence)
        pytest.skip(sentence)
    return file.read_text(encoding="utf-8")


def ours(name: str) -> list[Path]:
    """Our own files of an example; its user puts the library beside them."""
    return [each for each in (WEB / name).iterdir() if not each.name.startswith(name)]


BOTH = """<!doctype html><body><script>
const found = [];
window.onmessage = ({ data }) => { if (found.push(data) === 2) report(found); };
for (const name of ["p5", "three"]) {
  const frame = document.createElement("iframe");
  [frame.src, frame.width, frame.height] = [`${name}/index.html${location.search}`, 440, 290];
  document.body.append(frame);
}
</script></body>"""
"""Both pages in one start of Chromium."""


@pytest.mark.long  # WebGL without a graphics card takes a core for seconds.
@needs_chromium
def test_the_examples_draw_fingers(url: str) -> None:
    files = {each.name: each.read_text() for each in WEB.glob("*.js")} | {"index.html": BOTH}
    for name, paths in EXAMPLES.items():
        files |= {f"{name}/{each.name}": each.read_text() for each in ours(name)}
        files |= {f"{name}/{Path(path).name}": library(path) for path in paths}
        page = f"{name}/index.html"
        files[page] = files[page].replace("</body>", LOOK)
    found = visit(files, f"index.html?{url}", timeout_s=120.0)
    assert [each["text"] for each in found] == ["fingers: 4"] * 2


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_loads_nothing_from_the_internet(name: str) -> None:
    """It names the missing files of its library, and so does the README."""
    text = "".join(each.read_text() for each in ours(name))
    assert "http" not in text
    readme = (WEB / "README.md").read_text()
    for path in EXAMPLES[name]:
        assert f"{Path(path).name} " in text
        assert path in readme
