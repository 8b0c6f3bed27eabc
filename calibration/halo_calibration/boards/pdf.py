"""Pages of rectangles, lines and text at true scale, as PDF.

Rule: values in, bytes out; same values, same bytes. A page of black squares and Helvetica is a
few lines of text in that format, so no library is needed.
Places are mm from the page's top left corner, y down.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

PT_PER_MM = 72.0 / 25.4


@dataclass(frozen=True, slots=True)
class Page:
    """One page with its drawing commands."""

    width_mm: float
    height_mm: float
    _drawn: list[str] = field(default_factory=list)

    def box(self, x: float, y: float, width: float, height: float) -> None:
        """Draw a black rectangle from its top left corner."""
        self._drawn.append(f"{self._at(x, y + height)} {_pt(width)} {_pt(height)} re f")

    def line(self, x: float, y: float, to_x: float, to_y: float, width: float = 0.2) -> None:
        """Draw a black line."""
        self._drawn.append(f"{_pt(width)} w {self._at(x, y)} m {self._at(to_x, to_y)} l S")

    def text(self, x: float, y: float, words: str, size_mm: float = 3.5) -> None:
        """Write words of Latin letters from the left, their feet at y."""
        escaped = "".join(f"\\{sign}" if sign in "()\\" else sign for sign in words)
        self._drawn.append(f"BT /F {_pt(size_mm)} Tf {self._at(x, y)} Td ({escaped}) Tj ET")

    def _at(self, x: float, y: float) -> str:
        return f"{_pt(x)} {_pt(self.height_mm - y)}"

    def objects(self, number: int) -> tuple[str, str]:
        """Return the page and its content as PDF objects, the page's being `number`."""
        content = "\n".join(self._drawn)
        page = (
            f"<< /Type /Page /Parent 2 0 R /Resources << /Font << /F 3 0 R >> >> "
            f"/MediaBox [0 0 {_pt(self.width_mm)} {_pt(self.height_mm)}] "
            f"/Contents {number + 1} 0 R >>"
        )
        length = len(content.encode("cp1252"))
        return page, f"<< /Length {length} >>\nstream\n{content}\nendstream"


def document(title: str, pages: Sequence[Page]) -> bytes:
    """Bind pages. They ask viewers to print at 100 %."""
    first = 5
    kids = " ".join(f"{first + 2 * n} 0 R" for n in range(len(pages)))
    objects = [
        "<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
        f"<< /Type /Pages /Kids [{kids}] /Count {len(pages)} >>",
        "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding >>",
        f"<< /Title ({title}) >>",
    ]
    for n, page in enumerate(pages):
        objects += page.objects(first + 2 * n)
    written = b"%PDF-1.4\n"
    places = []
    for number, content in enumerate(objects, start=1):
        places.append(len(written))
        written += f"{number} 0 obj\n{content}\nendobj\n".encode("cp1252")
    table = "".join(f"{place:010d} 00000 n \n" for place in places)
    count = len(objects) + 1
    end = (
        f"xref\n0 {count}\n0000000000 65535 f \n{table}"
        f"trailer\n<< /Size {count} /Root 1 0 R /Info 4 0 R >>\nstartxref\n{len(written)}\n%%EOF\n"
    )
    return written + end.encode("ascii")


def _pt(mm: float) -> str:
    """PDF's points; a hundredth of a micrometre is fine enough."""
    return f"{mm * PT_PER_MM:.5f}".rstrip("0").rstrip(".")
