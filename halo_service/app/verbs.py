"""What each verb of `halo` does with its options; each imports what it needs, and no more.

Rule: a verb returns its exit code. The command line wins over the settings file.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace

from halo_service.errors import UserError


def serve(options: argparse.Namespace) -> int:
    """Run the service."""
    from halo_service.app.serve import serve as run
    from halo_service.settings import load

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
    run(
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


def replay(options: argparse.Namespace) -> int:
    """Sense a recording into a file."""
    from halo_service.app.replay import replay as sense
    from halo_service.settings import load

    settings = load(options.config)
    profile = options.profile or settings.profile
    settings = replace(settings, profile=profile)
    count = sense(options.recording, options.jsonl, settings, options.method)
    print(f"halo: {count} frames", file=sys.stderr)
    return 0


def simulate(options: argparse.Namespace) -> int:
    """Draw a take of the virtual Kinect, or its gallery."""
    from halo_service.app.takes import Simulated
    from halo_service.app.takes import simulate as draw

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
        print(f"halo: {draw(asked)} frames in {options.out}", file=sys.stderr)
    return 0


def record(options: argparse.Namespace) -> int:
    """Record any source."""
    from halo_service.app.takes import record as take
    from halo_service.settings import load

    settings = load(options.config).source
    settings = replace(settings, name=options.source or settings.name)
    count = take(options.out, settings, options.seconds, not options.no_colour)
    print(f"halo: {count} frames in {options.out}", file=sys.stderr)
    return 0


def evaluate(options: argparse.Namespace) -> int:
    """Run the study or judge a recording, and tell what came of it."""
    from halo_service.app import evaluate as bench
    from halo_service.app.evaluate_options import refuse_idle
    from halo_service.app.evaluate_told import Telling, telling
    from halo_service.app.first_light import first_light
    from halo_service.settings import load

    refuse_idle(options)
    bench.known_methods(options.method)  # before --live asks for four minutes of anybody
    settings = load(options.config)
    settings = replace(settings, profile=options.profile or settings.profile)
    with telling(Telling(options.csv, options.each, options.markdown, options.report)) as tell:
        if options.live is not None:
            source = replace(settings.source, name=options.source or settings.source.name)
            settings = replace(settings, source=source)
            recording, script = first_light(settings, options.live, not options.no_colour)
            recorded = bench.Recorded(recording, None, script, options.method)
            tell(bench.evaluate_recording(settings, recorded))
        elif options.recording is None:
            asked = bench.Asked(
                options.quick,
                options.method,
                options.users,
                options.materials,
                options.tasks,
                options.labels,
                options.keep,
                options.kept_only,
                options.jobs,
            )
            tell(bench.evaluate(settings, asked))
        else:
            recorded = bench.Recorded(
                options.recording, options.truth, options.script, options.method
            )
            tell(bench.evaluate_recording(settings, recorded))
    return 0


def profile(options: argparse.Namespace) -> int:
    """Look after the profiles."""
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


def bench(options: argparse.Namespace) -> int:
    """Measure how soon packets leave."""
    from halo_service.app.bench import Asked
    from halo_service.app.bench import bench as measure
    from halo_service.settings import load

    settings = load(options.config)
    # A real table's profile does not fit the virtual room, which is calibrated by itself.
    profile = options.profile or (settings.profile if options.source else "")
    asked = Asked(options.hands, options.seconds, options.source, profile, options.json)
    measure(asked, settings)
    return 0


def doctor(options: argparse.Namespace) -> int:
    """Exit code 0: nothing is missing; 1: something is."""
    from halo_service.app.doctor import examine, told
    from halo_service.settings import load

    settings = load(options.config)
    source = replace(settings.source, name=options.source or settings.source.name)
    findings = examine(
        replace(settings, profile=options.profile or settings.profile, source=source)
    )
    print("\n".join(told(finding) for finding in findings))
    return int(not all(finding.good for finding in findings))
