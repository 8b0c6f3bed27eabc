"""`halo import-dataset`: a public data set's files to our recordings and truth."""

from __future__ import annotations

import argparse
import sys
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

from halo_service.app.options import add_debug
from halo_service.errors import UserError

if TYPE_CHECKING:
    from halo_service.app.datasets.depth_touch import Placement

SUMMARY = "turn files of a public data set into a recording and its truth"
EXAMPLE = (
    "halo import-dataset ego-pressure out --data egopressure_data --participant p_001 "
    "--sequence p_001_index_press_high_x5_right --camera 4"
)

NAMES = ("depth-touch", "ego-pressure")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_debug(parser)
    parser.add_argument("name", choices=NAMES, metavar="NAME", help=" or ".join(NAMES))
    parser.add_argument("out", type=Path, metavar="OUT", help="files OUT.mkv, OUT.truth.jsonl")
    touch = parser.add_argument_group("depth-touch (UBC-X-Lab/DepthTouchSensing)")
    touch.add_argument("--video", type=Path, metavar="FILE", help="its .mkv")
    touch.add_argument("--labels", type=Path, metavar="FILE", help="its label file")
    touch.add_argument(
        "--corners",
        metavar="X,Y,...",
        help="the screen's corners in the depth image: far left, far right, near right, near left",
    )
    touch.add_argument(
        "--screen", default="1024x768", metavar="WxH", help="its points (default: 1024x768)"
    )
    touch.add_argument(
        "--first-touch-s", type=float, metavar="S", help="when the first touch is in the video"
    )
    ego = parser.add_argument_group("ego-pressure (eth-siplab/EgoPressure)")
    ego.add_argument("--data", type=Path, metavar="DIR", help="its download")
    ego.add_argument("--participant", metavar="P", help="e.g. p_001")
    ego.add_argument("--sequence", metavar="S", help="name of the sequence")
    ego.add_argument(
        "--camera", type=int, choices=range(1, 8), metavar="N", help="static camera, 1 to 7"
    )


def run(options: argparse.Namespace) -> int:
    """Convert, and print what was written."""
    truth = options.out.with_name(f"{options.out.name}.truth.jsonl")
    if options.name == "depth-touch":
        _depth_touch(options, truth)
    else:
        _ego_pressure(options, truth)
    print(truth)
    print(
        "next: halo evaluate RECORDING --truth TRUTH --profile P, with a profile of that camera",
        file=sys.stderr,
    )
    return 0


def _depth_touch(options: argparse.Namespace, truth: Path) -> None:
    from halo_service.app.datasets.depth_touch import convert
    from halo_service.app.datasets.truth_lines import write_lines
    from halo_service.sources.recording import Recording

    _require(options, "video", "labels", "corners", "first_touch_s")
    placement = _placement(options)
    with closing(Recording(options.video, realtime=False, loop=False)) as source:
        write_lines(convert(source, options.labels, placement), truth)


def _ego_pressure(options: argparse.Namespace, out: Path) -> None:
    from halo_service.app.datasets.ego_pressure import SequenceRequest, frames, read_rig, truth
    from halo_service.app.datasets.truth_lines import write_lines
    from halo_service.outputs.recorder import Recorder

    _require(options, "data", "participant", "sequence", "camera")
    request = SequenceRequest(options.data, options.participant, options.sequence, options.camera)
    rig = read_rig(request)
    lines = truth(request, rig)
    recording = options.out.with_name(f"{options.out.name}.mkv")
    with Recorder(recording, rig.camera, fps=rig.camera.fps, colour=True) as recorder:
        for frame in frames(request, rig):
            recorder.write(frame)
    write_lines(lines, out)
    print(recording)


def _placement(options: argparse.Namespace) -> Placement:
    from halo_service.app.datasets.depth_touch import Placement

    try:
        numbers = [float(each) for each in options.corners.split(",")]
        width, height = map(int, options.screen.split("x"))
        corners = tuple(zip(numbers[::2], numbers[1::2], strict=True))
        if len(corners) != 4 or min(width, height) < 1:
            raise ValueError("wrong count")
    except ValueError as error:
        raise UserError(
            "import-dataset: --corners needs 8 numbers with commas between, --screen two with an x"
        ) from error
    return Placement(corners, (width, height), options.first_touch_s)


def _require(options: argparse.Namespace, *names: str) -> None:
    missing = [f"--{name.replace('_', '-')}" for name in names if getattr(options, name) is None]
    if missing:
        raise UserError(f"import-dataset {options.name}: give {', '.join(missing)}")
