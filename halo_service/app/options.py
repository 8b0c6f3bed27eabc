"""What `halo` can be told on the command line. Nothing heavy is imported to read it."""

from __future__ import annotations

import argparse
from importlib.metadata import version
from pathlib import Path

import halo_protocol as wire
from halo_service.app import calibrate_options, evaluate_options, verbs

EPILOG = """\
examples:
  halo serve                                a Kinect if one is plugged in, else the virtual one
  halo serve --source recording:take.mkv    a recording, at its own pace
  halo calibrate --profile desk             teach the service your table and your finger
  halo demo drums                           drums (or paint) without a camera
  halo monitor                              what a running service sends, in the terminal
  halo replay take.mkv --profile desk --jsonl take.jsonl
  halo evaluate --quick                     how good the sensing is, on virtual people
"""


def parser() -> argparse.ArgumentParser:
    """Make the parser; the options of a verb name the function that runs it as `run`."""
    halo = argparse.ArgumentParser(
        prog="halo",
        description="A depth camera above a table makes it a touch surface.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    halo.add_argument(
        "--version",
        action="version",
        version=f"halo-service {version('halo-service')}, protocol {wire.VERSION}",
    )
    commands = halo.add_subparsers(dest="verb", required=True, metavar="COMMAND")
    debug = argparse.ArgumentParser(add_help=False)
    debug.add_argument("--debug", action="store_true", help="say more, and show tracebacks")
    configured = argparse.ArgumentParser(add_help=False, parents=[debug])
    configured.add_argument(
        "--config", type=Path, metavar="FILE", help="settings (default: halo.toml)"
    )
    common = argparse.ArgumentParser(add_help=False, parents=[configured])
    common.add_argument(
        "--profile", metavar="P", help="calibration: a path, or a name in your data folder"
    )
    _serve_options(commands.add_parser("serve", parents=[common], help="run the service"))
    _replay_options(
        commands.add_parser("replay", parents=[common], help="sense a recording into a file")
    )
    _simulate_options(
        commands.add_parser("simulate", parents=[debug], help="draw a take of the virtual Kinect")
    )
    _record_options(commands.add_parser("record", parents=[configured], help="record any source"))
    calibrate_options.add_calibrate(
        commands.add_parser(
            "calibrate", parents=[common], help="teach the service a place and a finger"
        )
    )
    calibrate_options.add_verify(
        commands.add_parser(
            "verify", parents=[common], help="touch a projected grid, and see how far off it is"
        )
    )
    evaluate_options.add_to(
        commands.add_parser("evaluate", parents=[common], help="how good the sensing is")
    )
    _profile_options(
        commands.add_parser("profile", help="list, show, copy, export, import profiles")
    )
    calibrate_options.add_targets(
        commands.add_parser(
            "targets", parents=[debug], help="write the sheets to print: surface and anchor, as PDF"
        )
    )
    _bench_options(
        commands.add_parser("bench", parents=[common], help="how soon touches leave this machine")
    )
    doctor = commands.add_parser("doctor", parents=[common], help="what is missing, and the remedy")
    doctor.add_argument("--source", metavar="S", help="as for serve")
    doctor.set_defaults(run=verbs.doctor)
    commands.add_parser("monitor", help="show what a service sends", add_help=False)
    commands.add_parser("demo", help="play drums or paint, without a camera", add_help=False)
    return halo


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
    verb.set_defaults(run=verbs.serve)


def _replay_options(verb: argparse.ArgumentParser) -> None:
    verb.add_argument("recording", type=Path, metavar="RECORDING")
    verb.add_argument("--jsonl", required=True, metavar="OUT", help="file to write; - for stdout")
    verb.add_argument(
        "--method", default="ours", metavar="M", help="ours (default), paper, direct or wilson"
    )
    verb.set_defaults(run=verbs.replay)


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
    verb.set_defaults(run=verbs.simulate)


def _record_options(verb: argparse.ArgumentParser) -> None:
    verb.add_argument("out", type=Path, metavar="OUT.mkv")
    verb.add_argument("--source", metavar="S", help="as for serve")
    verb.add_argument("--seconds", type=float, metavar="S", help="length; without it, Ctrl-C ends")
    verb.add_argument("--no-colour", action="store_true", help="for privacy: leave colour out")
    verb.set_defaults(run=verbs.record)


def _bench_options(verb: argparse.ArgumentParser) -> None:
    verb.add_argument(
        "--hands", type=int, choices=(1, 2), help="look for so many (default: both by turns)"
    )
    verb.add_argument(
        "--seconds", type=float, default=15.0, metavar="N", help="length of a take (default 15)"
    )
    verb.add_argument("--source", metavar="S", help="recording:FILE or sim[:SCENARIO]")
    verb.add_argument("--json", metavar="FILE", help="write all figures; - for stdout")
    verb.set_defaults(run=verbs.bench)


def _profile_options(verb: argparse.ArgumentParser) -> None:
    verb.set_defaults(run=verbs.profile, debug=False)
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
