"""The two pages of first light: what works on this table, and the figures that say so. Pure."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from importlib.resources import files

import numpy as np

from halo_calibration.steps.camera import (
    DARK_COUNTS,
    HIGHEST_MM,
    LEAST_MEASURED,
    LOWEST_MM,
    STEEP_DEG,
    CameraReport,
)
from halo_service.app.calibration_ui.verdict import QUIET_MM
from halo_service.evaluation.metrics.result import Result
from halo_service.evaluation.report import level_plots, touch_plots
from halo_service.evaluation.report.figures import ValuesOf
from halo_service.evaluation.report.select import pooled
from halo_service.profile import Profile

VIRTUAL = (
    "A rehearsal: the camera, the hand and the table were virtual. These figures say nothing about "
    "a real camera."
)
REAL = (
    "Compared with what the prompts requested, so your own errors are in every figure: people miss "
    "a cross by some millimetres, and a kitchen scale swings."
)


@dataclass(frozen=True, slots=True)
class Row:
    """One figure, and whether it is in its good range."""

    what: str
    value: float
    unit: str
    least: float = -math.inf
    most: float = math.inf
    digits: int = 0
    remedy: str = ""

    @property
    def good(self) -> bool | None:
        """None: it was not measured."""
        return None if math.isnan(self.value) else self.least <= self.value <= self.most

    @property
    def cells(self) -> tuple[str, str, str]:
        """The figure, its value with unit, and its good range with unit."""
        shown = "not measured" if self.good is None else self._number(self.value)
        return self.what, shown, self._range()

    def _number(self, value: float) -> str:
        return f"{value:.{self.digits}f} {self.unit}".strip()

    def _range(self) -> str:
        if math.isinf(self.least):
            return f"up to {self._number(self.most)}"
        if math.isinf(self.most):
            return f"{self._number(self.least)} or more"
        return f"{self.least:.{self.digits}f} to {self._number(self.most)}"


@dataclass(frozen=True, slots=True)
class Account:
    """All that the report shows."""

    facts: Mapping[str, str]
    camera: CameraReport
    profile: Profile
    results: Sequence[Result]
    missed: Sequence[str] = ()
    """The tasks that were not felt."""
    lost_share: float = 0.0
    """Of the frames."""
    coins: bool = False
    virtual: bool = False
    files: Mapping[str, str] = field(default_factory=dict)
    """What is in the folder: name and meaning."""


def placement_rows(account: Account) -> list[Row]:
    """Return the figures of camera and table."""
    camera, background = account.camera, account.profile.background
    noise_mm = float(np.median(background.noise_mm[background.valid]))
    closer = "move the camera to 45 to 70 cm above the table"
    return [
        Row("camera above the table", camera.height_mm / 10, "cm", LOWEST_MM / 10,
            HIGHEST_MM / 10, remedy=closer),
        Row("tilt of the camera", camera.tilt_deg, "°", most=STEEP_DEG,
            remedy="let it look down more steeply"),
        Row("middle of the image with depth", 100 * camera.measured_share, "%",
            100 * LEAST_MEASURED, remedy="remove glass and mirrors; keep sunlight off the table"),
        Row("infrared of the table", camera.infrared, "counts", DARK_COUNTS,
            remedy="put a lighter, matt cloth or paper there"),
        Row("noise of the depth, one frame", noise_mm, "mm", most=QUIET_MM, digits=1,
            remedy=closer),
        Row("frames lost", 100 * account.lost_share, "%", most=1.0, digits=1,
            remedy="use another USB 3 port, close other programs"),
    ]  # fmt: skip


def touch_rows(account: Account) -> list[Row]:
    """Return the figures of the session."""
    scores = pooled([each for each in account.results if each.scores is not None])
    values = ValuesOf(scores)
    touches = values["touches"]
    again = "repeat 'halo calibrate touch' and 'sweep', the finger as you use it"
    hover_mm = 4.0 if account.coins else 2.8
    return [
        Row("touches reported, of those requested", 100 * (1 - values["missed"] / touches)
            if touches else math.nan, "%", 99.0, digits=1, remedy=again),
        Row("touches reported twice", _known(values["doubled"], touches), "", most=0, remedy=again),
        Row("touches where none was requested", _known(values["outside_and_ghosts"], touches), "",
            most=0, remedy="keep the other fingers away from the table; " + again),
        Row("place, from the cross", values["spatial_paper_method_mm"], "mm", most=6.0, digits=1,
            remedy="lay the surface sheet exactly on the crosses and calibrate the surface again"),
        Row("height of the fingertip, error", values["hover_error_mm"], "mm", most=hover_mm,
            digits=1, remedy="calibrate 'touch' with pegs: --hover-mm 10 --subtle-mm 1"),
        Row("pressure, error in % of 385 g", values["pressure_error_percent"], "%", most=19.0,
            digits=1, remedy="calibrate 'touch' with a scale: --press-g 200 --hard-g 400"),
    ]  # fmt: skip


def _known(value: float, touches: float) -> float:
    return float(value) if touches else math.nan


def verdicts(account: Account) -> list[tuple[str, str]]:
    """Return what works on this table: touch, hover, pressure and placement, in words."""
    rows = touch_rows(account)
    groups = {
        "Camera and table": placement_rows(account),
        "Touch": rows[:4],
        "Hover": rows[4:5],
        "Pressure": rows[5:],
    }
    return [(name, _verdict(group)) for name, group in groups.items()]


def _verdict(rows: Sequence[Row]) -> str:
    measured = [row for row in rows if row.good is not None]
    if not measured:
        return "not measured"
    bad = [row.what for row in measured if not row.good]
    if not bad:
        return "works"
    return ("partly: " if len(bad) < len(measured) else "does not work yet: ") + ", ".join(bad)


def report_page(account: Account) -> str:
    """Return the whole report: an HTML page that prints on two sheets."""
    first = [
        "<h1>First light: what works on this table</h1>",
        f"<p class='lead'>{escape(VIRTUAL if account.virtual else REAL)}</p>",
        _facts(account.facts),
        "<h2>In short</h2>",
        "<dl>"
        + "".join(f"<dt>{a}</dt><dd>{escape(b)}</dd>" for a, b in verdicts(account))
        + "</dl>",
        "<h2>Touches</h2>",
        _table(touch_rows(account)),
        "<h2>Camera and table</h2>",
        _table(placement_rows(account)),
        "<h2>Calibration</h2>",
        _steps(account.profile),
    ]
    second = [
        "<h2>What to do next</h2>",
        _advice(account),
        f"<div class='plots'>{''.join(_plots(account.results))}</div>",
        "<h2>Files of this folder</h2>",
        "<dl>"
        + "".join(
            f"<dt>{escape(name)}</dt><dd>{escape(words)}</dd>"
            for name, words in account.files.items()
        )
        + "</dl>",
    ]
    return _document(first, second)


def _facts(facts: Mapping[str, str]) -> str:
    return (
        "<dl>"
        + "".join(
            f"<dt>{escape(name)}</dt><dd>{escape(words)}</dd>" for name, words in facts.items()
        )
        + "</dl>"
    )


def _table(rows: Sequence[Row]) -> str:
    body = "".join(
        "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row.cells) + _mark(row) + "</tr>"
        for row in rows
    )
    head = "<tr><th>figure</th><th>here</th><th>good range</th><th></th></tr>"
    return f"<table>{head}{body}</table>"


def _mark(row: Row) -> str:
    if row.good is None:
        return "<td></td>"
    kind, word = ("pass", "good") if row.good else ("fail", "not good")
    return f"<td><b class='{kind}'>{word}</b></td>"


def _steps(profile: Profile) -> str:
    rows = "".join(
        f"<tr><td>{escape(name)}</td><td>{record.quality}</td><td>{escape(record.note)}</td></tr>"
        for name, record in profile.steps.items()
    )
    return f"<table><tr><th>step</th><th>rated</th><th>note</th></tr>{rows}</table>"


def _advice(account: Account) -> str:
    bad = [row for row in (*placement_rows(account), *touch_rows(account)) if row.good is False]
    words = [f"{row.what}: {row.remedy}" for row in bad if row.remedy]
    words += list(account.camera.advice)
    if account.missed:
        words.append(
            f"Tasks that were not felt or not held still: {len(account.missed)}, the first is: "
            f"{account.missed[0]}"
        )
    if account.coins:
        words.append(
            "Heights by coins: a finger that is tilted by 3 degrees is 1.3 mm higher or lower at "
            "its tip, 25 mm beyond the coins. So the range for height is 4 mm instead of 2.8 mm."
        )
    if not words:
        words = ["Nothing: all that was measured is in its good range."]
    return "<ul>" + "".join(f"<li>{escape(each)}</li>" for each in words) + "</ul>"


def _plots(results: Sequence[Result]) -> list[str]:
    drawn = [
        ("Touches around their crosses", touch_plots.targets(results, "ours")),
        ("Heights: requested and reported", level_plots.levels(results, "hover", "requested")),
        ("Pressure: requested and reported", level_plots.levels(results, "pressure", "requested")),
    ]
    return [
        f"<figure><figcaption>{title}</figcaption>"
        f"<div class='row'>{''.join(drawings)}</div></figure>"
        for title, drawings in drawn
        if drawings
    ]


_PRINT = """
main { max-width: 800px; padding: 24px; }
h1 { font-size: 22px; } h2 { font-size: 16px; margin: 14px 0 4px; }
.lead { font-size: 13px; margin: 0 0 8px; }
.sheet { break-after: page; } .sheet:last-child { break-after: auto; }
.plots { display: flex; flex-wrap: wrap; gap: 8px 14px; }
figure { margin: 4px 0 0; } figcaption { font-weight: 600; font-size: 13px; }
figure svg { max-height: 300px; width: auto; }
ul { font-size: 13px; padding-left: 18px; margin: 4px 0; }
th, td { padding: 3px 18px 3px 0; }
@page { size: A4; margin: 12mm; }
@media print { main { max-width: none; padding: 0; } body { background: #fff; color: #111; } }
"""


def _document(first: Sequence[str], second: Sequence[str]) -> str:
    style = files("halo_service.evaluation.report").joinpath("page.css").read_text(encoding="utf-8")
    sheets = "".join(f"<div class='sheet'>{''.join(parts)}</div>" for parts in (first, second))
    return (
        "<!doctype html>\n<html lang='en'><head><meta charset='utf-8'>"
        "<meta name='viewport' content='width=device-width, initial-scale=1'>"
        f"<title>halo first light</title><style>\n{style}{_PRINT}</style></head>\n"
        f"<body><main>{sheets}</main></body></html>\n"
    )
