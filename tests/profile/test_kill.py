"""Kill -9 at random moments of saving: whoever reads finds the old profile or the new one."""

from __future__ import annotations

import subprocess
import sys

import pytest

KILLS = 200

DRIVER = """
import os, random, signal, sys, time
from dataclasses import replace
from pathlib import Path
import numpy as np
from halo_service.geometry.camera import Camera, Lens
from halo_service.geometry.surface import Surface
from halo_service.profile import Background, Profile
from halo_service.profile.store import load, save

kills, folder = int(sys.argv[1]), Path(sys.argv[2])
lens = Lens(96, 64, 500.0, 500.0, 48.0, 32.0)
camera = Camera("A1", "NFOV_UNBINNED", 30, lens, None, np.eye(4))
noise = np.random.default_rng(1).normal(500.0, 1.0, (64, 96)).astype(np.float32)


def version(number):
    background = Background(noise + number, np.abs(noise - 500), noise > 0)
    return Profile("p", camera, Surface("table", 300.0, 200.0, np.eye(4)), background, None, number)


save(version(1), folder)
before = time.monotonic()
save(version(1), folder)
longest = max(0.04, 4.0 * (time.monotonic() - before))  # a busy machine saves more slowly
chance = random.Random(7)
last, interrupted = 1, 0
for _ in range(kills):
    child = os.fork()
    if child == 0:
        number = last
        while True:
            number += 1
            save(version(number), folder)
    time.sleep(chance.uniform(0.0, longest))
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    interrupted += any(folder.glob(".*.part"))
    found = load(folder)
    assert found.revision >= last, (found.revision, last)
    np.testing.assert_array_equal(found.background.mean_mm, noise + found.revision)
    last = found.revision
save(version(last + 1), folder)
assert not any(folder.glob(".*.part")), "leftovers of the killed are cleared away"
print(kills, "kills,", interrupted, "in the middle of a file, revision", last)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no fork")
def test_no_kill_while_saving_leaves_an_unreadable_profile(tmp_path: object) -> None:
    done = subprocess.run(
        [sys.executable, "-c", DRIVER, str(KILLS), str(tmp_path)],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    print(done.stdout)
    assert done.returncode == 0, done.stderr
    interrupted, last = (int(done.stdout.split()[n]) for n in (2, -1))
    assert interrupted > 10, "the kills must hit the saving"
    assert last > 20, "and not hit it always"
