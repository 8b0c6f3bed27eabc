"""`halo`: one command with a few verbs. Errors of use are one sentence on stderr and exit 2."""

from __future__ import annotations

import argparse
import logging
import os
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from halo_service.app.threads import hold_to_one
from halo_service.errors import UserError

EPILOG = """\
examples:
  halo serve                                a Kinect if one is plugged in, else the virtual one
  halo serve --source recording:take.mkv    a recording, at its own pace
  halo calibrate --profile desk             teach the service your table and your finger
  halo demo drums                           drums (or paint) without a camera
  halo monitor                              what a running service sends, in the terminal
  halo replay take.mkv --profile desk --jsonl take.jsonl
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; return its exit code."""
    arguments = sys.argv[1:] if argv is None else list(argv)
    if arguments[:1] == ["monitor"]:
        from halo_tools.monitor import main as monitor

        return monitor(arguments[1:])
    if arguments[:1] == ["demo"]:
        from halo_service.app.demo import main as demo

        return demo(arguments[1:])
    options = _parser().parse_args(arguments)
    _speak(logging.DEBUG if options.debug else logging.INFO)
    hold_to_one()
    try:
        code = int(options.run(options))
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        # Who reads what we print has had enough, as `head` does: that is a normal end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except UserError as error:
        if options.debug:
            raise
        print(f"halo: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130


def _speak(level: int) -> None:
    """Let our own modules tell what they do, and libraries no more than their warnings."""
    logging.basicConfig(format="halo: %(message)s", stream=sys.stderr)
    for name in ("halo_service", "halo_calibration"):
        logging.getLogger(name).setLevel(level)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="halo",
        description="A depth camera above a table makes it a touch surface.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="COMMAND")
    debug = argparse.ArgumentParser(add_help=False)
    debug.add_argument("--debug", action="store_true", help="say more, and show tracebacks")
    common = argparse.ArgumentParser(add_help=False, parents=[debug])
    common.add_argument("--config", type=Path, metavar="FILE", help="settings (default: halo.toml)")
    common.add_argument(
        "--profile", metavar="P", help="calibration: a path, or a name in your data folder"
    )
    _serve_options(verbs.add_parser("serve", parents=[common], help="run the service"))
    _replay_options(
        verbs.add_parser("replay", parents=[common], help="sense a recording into a file")
    )
    _simulate_options(
        verbs.add_parser("simulate", parents=[debug], help="draw a take of the virtual Kinect")
    )
    _record_options(verbs.add_parser("record", parents=[common], help="record any source"))
    calibration = verbs.add_parser(
        "calibrate", parents=[common], help="teach the service a place and a finger"
    )
    _calibrate_options(calibration)
    _profile_options(verbs.add_parser("profile", help="list, show, copy, export, import profiles"))
    doctor = verbs.add_parser("doctor", parents=[common], help="what is missing, and the remedy")
    doctor.add_argument("--source", metavar="S", help="as for serve")
    doctor.set_defaults(run=_doctor)
    verbs.add_parser("monitor", help="show what a service sends", add_help=False)
    verbs.add_parser("demo", help="play drums or paint, without a camera", add_help=False)
    return parser


def _serve_options(verb: argparse.ArgumentParser) -> None:
    verb.add_argument(
        "--source",
        metavar="S",
        help="azure-kinect, recording:FILE, sim[:SCENARIO] or auto (default)",
    )
    verb.add_argument("--loop", action="store_true", help="start a recording again when it ends")
    verb.add_argument("--fast", action="store_true", help="play a recording as fast as it goes")
    verb.add_argument("--node", metavar="NAME", help="name of this service on the network")
    verb.add_argument(
        "--osc",
        action="append",
        metavar="HOST:PORT",
        help="send OSC here instead of 127.0.0.1:9000; may be repeated",
    )
    verb.add_argument("--no-osc", action="store_true", help="send no OSC")
    verb.add_argument(
        "--zenoh-listen", action="append", metavar="ENDPOINT", help="e.g. tcp/127.0.0.1:7447"
    )
    verb.add_argument(
        "--zenoh-connect", action="append", metavar="ENDPOINT", help="a router or peer to call"
    )
    verb.add_argument("--no-zenoh", action="store_true", help="open no Zenoh peer")
    verb.add_argument("--control-port", type=int, metavar="PORT", help="instead of 9001")
    verb.set_defaults(run=_serve)


def _replay_options(verb: argparse.ArgumentParser) -> None:
    verb.add_argument("recording", type=Path, metavar="RECORDING")
    verb.add_argument("--jsonl", required=True, metavar="OUT", help="file to write; - for stdout")
    verb.set_defaults(run=_replay)


def _simulate_options(verb: argparse.ArgumentParser) -> None:
    verb.add_argument(
        "scenario", nargs="?", metavar="SCENARIO", help="like drumming?seed=3&material=foam"
    )
    verb.add_argument("--out", type=Path, metavar="X.mkv", help="the recording")
    verb.add_argument("--truth", metavar="X.jsonl", help="what really happened, a line a frame")
    verb.add_argument("--script", metavar="X.json", help="the steps of a calibration in it")
    verb.add_argument("--seed", type=int, metavar="N", help="one seed is one user at one place")
    verb.add_argument("--seconds", type=float, metavar="S", help="length, where it has no end")
    verb.add_argument("--no-colour", action="store_true", help="leave colour out")
    verb.add_argument(
        "--gallery", type=Path, metavar="X.png", help="draw materials and states, for your eyes"
    )
    verb.set_defaults(run=_simulate)


def _record_options(verb: argparse.ArgumentParser) -> None:
    verb.add_argument("out", type=Path, metavar="OUT.mkv")
    verb.add_argument("--source", metavar="S", help="as for serve")
    verb.add_argument("--seconds", type=float, metavar="S", help="length; without it, Ctrl-C ends")
    verb.add_argument("--no-colour", action="store_true", help="for privacy: leave colour out")
    verb.set_defaults(run=_record)


def _simulate(options: argparse.Namespace) -> int:
    from halo_service.app.takes import Simulated, simulate

    if options.gallery is not None:
        from halo_service.virtual.gallery import save

        save(options.gallery, 1 if options.seed is None else options.seed)
    elif options.scenario is None or options.out is None:
        raise UserError("simulate needs a SCENARIO and --out X.mkv, or --gallery X.png")
    if options.scenario is not None and options.out is not None:
        asked = Simulated(
            options.scenario,
            options.out,
            options.truth,
            options.script,
            options.seed,
            options.seconds,
            not options.no_colour,
        )
        print(f"halo: {simulate(asked)} frames in {options.out}", file=sys.stderr)
    return 0


def _record(options: argparse.Namespace) -> int:
    from halo_service.app.config import load
    from halo_service.app.takes import record

    settings = load(options.config).source
    settings = replace(settings, name=options.source or settings.name)
    count = record(options.out, settings, options.seconds, not options.no_colour)
    print(f"halo: {count} frames in {options.out}", file=sys.stderr)
    return 0


def _calibrate_options(verb: argparse.ArgumentParser) -> None:
    verb.add_argument(
        "step",
        nargs="?",
        choices=("background", "surface", "touch", "sweep", "pilot"),
        metavar="STEP",
        help="background, surface, touch, sweep, or pilot; without one all that are missing",
    )
    verb.add_argument("--source", metavar="S", help="as for serve")
    verb.add_argument("--script", type=Path, metavar="FILE", help="steps of a recording, by time")
    verb.add_argument("--hover-mm", type=float, metavar="MM", help="height of the hover spacer")
    verb.add_argument("--subtle-mm", type=float, metavar="MM", help="height of the subtle spacer")
    verb.add_argument("--touch-g", type=float, metavar="G", help="force of the relaxed touch")
    verb.add_argument("--press-g", type=float, metavar="G", help="what the kitchen scale shows")
    verb.add_argument("--hand", choices=("left", "right"), help="touch parameters for this hand")
    verb.add_argument("--base", default="auto", metavar="B", help="base model: FILE, none or auto")
    verb.add_argument("--rounds", type=int, default=3, metavar="N", help="of the pilot")
    verb.add_argument("--round-s", type=float, default=60.0, metavar="S", help="of the pilot")
    verb.set_defaults(run=_calibrate)


def _profile_options(verb: argparse.ArgumentParser) -> None:
    verb.set_defaults(run=_profile, debug=False)
    acts = verb.add_subparsers(dest="act", required=True, metavar="ACT")
    acts.add_parser("list", help="those in your data folder")
    acts.add_parser("show", help="one in words").add_argument("name")
    copy = acts.add_parser("copy", help="one under another name")
    copy.add_argument("name")
    copy.add_argument("to")
    export = acts.add_parser("export", help="one into a file")
    export.add_argument("name")
    export.add_argument("out", type=Path)
    taken = acts.add_parser("import", help="one out of such a file")
    taken.add_argument("file", type=Path)
    taken.add_argument("--name", help="instead of its own")


def _profile(options: argparse.Namespace) -> int:
    from halo_service.app import profiles

    if options.act == "list":
        print("\n".join(profiles.list_profiles()))
    elif options.act == "show":
        print("\n".join(profiles.show(options.name)))
    elif options.act == "copy":
        print(profiles.copy(options.name, options.to))
    elif options.act == "export":
        profiles.export(options.name, options.out)
        print(options.out)
    else:
        print(profiles.import_profile(options.file, options.name))
    return 0


def _doctor(options: argparse.Namespace) -> int:
    """Exit code 0: nothing is missing; 1: something is."""
    from halo_service.app.config import load
    from halo_service.app.doctor import examine, told

    settings = load(options.config)
    source = replace(settings.source, name=options.source or settings.source.name)
    findings = examine(
        replace(settings, profile=options.profile or settings.profile, source=source)
    )
    print("\n".join(told(finding) for finding in findings))
    return int(not all(finding.good for finding in findings))


def _calibrate(options: argparse.Namespace) -> int:
    from halo_calibration.touch import Stated
    from halo_service.app.calibrate import Wish, calibrate, pilot
    from halo_service.app.config import load
    from halo_service.values import Side

    settings = load(options.config)
    source = replace(settings.source, name=options.source or settings.source.name)
    stated = Stated(options.hover_mm, options.subtle_mm, options.touch_g, options.press_g)
    side = Side[options.hand.upper()] if options.hand else Side.UNKNOWN
    settings = replace(settings, profile=options.profile or settings.profile, source=source)
    if options.step == "pilot":
        pilot(settings, options.rounds, options.round_s)
        return 0
    calibrate(
        settings,
        Wish(options.step, options.script, stated, side, options.base),
    )
    return 0


def _serve(options: argparse.Namespace) -> int:
    from halo_service.app.config import load
    from halo_service.app.serve import serve

    settings = load(options.config)
    source = replace(
        settings.source,
        name=options.source or settings.source.name,
        loop=options.loop or settings.source.loop,
        fast=options.fast or settings.source.fast,
    )
    osc = replace(
        settings.osc,
        enabled=settings.osc.enabled and not options.no_osc,
        destinations=tuple(options.osc or settings.osc.destinations),
    )
    zenoh = replace(
        settings.zenoh,
        enabled=settings.zenoh.enabled and not options.no_zenoh,
        listen=tuple(options.zenoh_listen or settings.zenoh.listen),
        connect=tuple(options.zenoh_connect or settings.zenoh.connect),
    )
    port = settings.control.port if options.control_port is None else options.control_port
    serve(
        replace(
            settings,
            node=options.node or settings.node,
            profile=options.profile or settings.profile,
            source=source,
            osc=osc,
            zenoh=zenoh,
            control=replace(settings.control, port=port),
        )
    )
    return 0


def _replay(options: argparse.Namespace) -> int:
    from halo_service.app.config import load
    from halo_service.app.replay import replay

    settings = load(options.config)
    profile = options.profile or settings.profile
    count = replay(options.recording, options.jsonl, replace(settings, profile=profile))
    print(f"halo: {count} frames", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
