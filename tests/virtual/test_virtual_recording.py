"""A virtual recording, read by ffmpeg: it gets the rendered frames."""

import subprocess

import numpy as np

from halo_service.outputs.recorder import Recorder
from halo_service.virtual.offline import SimulatedRecording
from halo_service.virtual.sim_url import parse_sim_url


def test_ffmpeg_reads_equal_frames(external_program, tmp_path):
    ffmpeg = external_program("ffmpeg")
    path = tmp_path / "demo.mkv"
    recording = SimulatedRecording(parse_sim_url("sim:demo?seed=2"), 0.4)
    drawn = []
    with Recorder(path, recording.camera, fps=recording.camera.fps, colour=True) as recorder:
        for frame, _ in recording:
            if frame is not None:
                recorder.write(frame)
                drawn.append(frame)
    for stream, images in ((1, [f.depth for f in drawn]), (2, [f.ir for f in drawn])):
        raw = subprocess.run(
            [ffmpeg, "-v", "error", "-i", path, "-map", f"0:{stream}", "-f", "rawvideo",
             "-pix_fmt", "gray16le", "-fps_mode", "passthrough", "-"],
            check=True, capture_output=True,
        ).stdout  # fmt: skip
        read = np.frombuffer(raw, "<u2").reshape(-1, 576, 640)
        assert np.array_equal(read, np.array(images))
