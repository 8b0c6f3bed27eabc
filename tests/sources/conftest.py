"""Recordings to read: a small one of ours, and foreign ones made piece by piece."""

import struct
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from halo_service.geometry import k4a
from halo_service.geometry.camera import Camera, Lens
from halo_service.outputs.recorder import Recorder
from halo_service.values import Frame

JPEG = b"\xff\xd8 not looked into by anybody here \xff\xd9"


@pytest.fixture(scope="session")
def small_camera() -> Camera:
    return Camera(
        serial="0123",
        depth_mode="NFOV_2X2BINNED",
        fps=30,
        depth=Lens(320, 288, 252.0, 252.0, 160.0, 144.0, (0.5, -0.02, 1e-5, 1e-5, 0, 0.9, 0, 0)),
        colour=Lens(1280, 720, 612.0, 612.0, 640.0, 360.0),
        colour_from_depth=np.eye(4),
    )


@pytest.fixture(scope="session")
def small_frames(small_camera) -> list[Frame]:
    return frames_of(small_camera)


@pytest.fixture(scope="session")
def small_recording(tmp_path_factory, small_camera, small_frames) -> Path:
    return recorded(tmp_path_factory.mktemp("recording"), small_camera, small_frames)


@pytest.fixture(scope="session")
def wide_camera(small_camera) -> Camera:
    """The same device in the mode with most pixels, at half the rate."""
    data, mode = k4a.to_json(small_camera), "WFOV_UNBINNED"
    return k4a.from_json(data, depth_mode=mode, colour_resolution="720P", fps=k4a.DEPTH_FPS[mode])


@pytest.fixture(scope="session")
def wide_frames(wide_camera) -> list[Frame]:
    return frames_of(wide_camera)


@pytest.fixture(scope="session")
def wide_recording(tmp_path_factory, wide_camera, wide_frames) -> Path:
    return recorded(tmp_path_factory.mktemp("recording"), wide_camera, wide_frames)


def frames_of(camera: Camera) -> list[Frame]:
    rng = np.random.default_rng(1)
    flat = np.full((camera.depth.height, camera.depth.width), 700, np.uint16)
    return [
        Frame(
            463_000 + n * 1_000_000 // camera.fps,
            flat + rng.integers(0, 4, flat.shape, np.uint16),
            flat * 2 + rng.integers(0, 9, flat.shape, np.uint16),
            JPEG + bytes([n]),
        )
        for n in range(6)
    ]


def recorded(folder: Path, camera: Camera, frames: list[Frame]) -> Path:
    path = folder / "recording.mkv"
    with Recorder(path, camera, fps=camera.fps, colour=True) as recorder:
        for frame in frames:
            assert recorder.write(frame)
    return path


RAW_COLOURS = {"NV12": "nv12", "YUY2": "yuyv422", "BGRA": "bgra"}
"""The SDK's uncompressed formats of colour, and FFmpeg's names for them."""


@pytest.fixture
def foreign(tmp_path, small_camera):
    """Write a Matroska file of three images a track; `missing`, `spoilt`: (track, ms) pairs."""

    def write(
        tracks=("DEPTH", "IR"),
        *,
        pix_fmt="gray16le",
        codec="ffv1",
        size=(320, 288),
        depth_mode="NFOV_2X2BINNED",
        calibration: bytes | None = k4a.to_json(small_camera),
        times_ms=(0, 33, 66),
        missing=(),
        spoilt=(),
    ) -> Path:
        path = tmp_path / "foreign.mkv"
        with av.open(path, "w", container_options={"allow_raw_vfw": "1"}) as container:
            streams = []
            for title in tracks:
                raw_colour = title in RAW_COLOURS
                stream = container.add_stream("rawvideo" if raw_colour else codec, 30)
                stream.width, stream.height = (1280, 720) if raw_colour else size
                stream.pix_fmt = RAW_COLOURS.get(title, pix_fmt)
                stream.codec_context.time_base = Fraction(1, 1000)
                stream.metadata.update(
                    title="COLOR" if raw_colour else title,
                    K4A_DEPTH_MODE=depth_mode,
                    K4A_COLOR_MODE=f"{title}_720P",
                )
                streams.append(stream)
            if calibration is not None:
                container.add_attachment("calibration.json", "text/plain", calibration)
            for time_ms in times_ms:
                for title, stream in zip(tracks, streams, strict=True):
                    for packet in stream.encode(picture(stream, time_ms)):
                        if (title, time_ms) in spoilt:
                            packet = rubbish_instead_of(packet)
                        if (title, time_ms) not in missing:
                            container.mux(packet)
        if codec == "rawvideo" and pix_fmt == "gray16be":
            name_as_the_sdk_does(path)
        return path

    return write


def picture(stream, time_ms) -> av.VideoFrame:
    width, height = stream.width, stream.height
    grey = np.arange(width * height, dtype=np.uint32).astype(np.uint16).reshape(height, width)
    frame = av.VideoFrame.from_ndarray(grey + np.uint16(time_ms % 65_536), format="gray16le")
    frame = frame.reformat(format=stream.pix_fmt)
    frame.pts, frame.time_base = time_ms, Fraction(1, 1000)
    return frame


def rubbish_instead_of(packet: av.Packet) -> av.Packet:
    rubbish = av.Packet(b"rubbish" * 99)
    rubbish.stream, rubbish.time_base = packet.stream, packet.time_base
    rubbish.pts, rubbish.dts = packet.pts, packet.dts
    return rubbish


def name_as_the_sdk_does(path: Path) -> None:
    """FFmpeg writes 16-bit images without a name; the SDK calls its big-endian grey b16g."""
    unnamed, named = (struct.pack("<HH4s", 1, 16, name) for name in (b"\0" * 4, b"b16g"))
    data = path.read_bytes()
    assert unnamed in data
    path.write_bytes(data.replace(unnamed, named))
