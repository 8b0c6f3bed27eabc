"""One pass through a Matroska file in the layout of the Azure Kinect SDK.

Rule: only this module knows how PyAV reads, and the SDK's names for tracks and tags. Tracks are
titled COLOR, DEPTH and IR, tags are called K4A_*, `calibration.json` is attached; depth and IR are
raw `gray16be` as the SDK writes them, or any lossless codec of 16-bit grey (ours: FFV1). Foreign or
broken files raise one error: `UserError`.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TypeAlias, cast, get_args

import av
import numpy as np
from av.container import InputContainer
from av.error import FFmpegError
from av.packet import Packet
from av.stream import AttachmentStream
from av.video.stream import VideoStream
from numpy.typing import NDArray

from halo_service.errors import UserError
from halo_service.geometry import k4a
from halo_service.geometry.camera import Camera, Lens
from halo_service.sources.ebml import declared_size, open_matroska
from halo_service.sources.pairing import Capture, Pairing, Track
from halo_service.values import BadFrame, Frame

_Packet: TypeAlias = "Packet[VideoStream]"
_BYTE_ORDERS = {"gray16be": ">u2", "gray16le": "<u2"}
_US_PER_S = 1_000_000


class KinectFile:
    """An opened recording: its camera, and its captures from the first to the last."""

    camera: Camera

    def __init__(self, path: Path) -> None:
        """Open and check; raises UserError if the file is not a recording of depth and IR."""
        self._path = path
        self._file = open_matroska(path)
        try:
            self._complete = self._checked_size()
            self._readable = True
            self._container = self._demuxer()
            self._tracks = self._checked_tracks()
            self.camera = self._checked_camera()
        except BaseException:
            self._file.close()
            raise

    def captures(self) -> Iterator[Capture[_Packet]]:
        """Yield the captures in the order of time. To be called once.

        It also ends where the file is cut off or damaged; then `whole` is false.
        """
        delay_ns = self._container.metadata.get("K4A_DEPTH_DELAY_NS", "0")
        pairing: Pairing[_Packet] = Pairing(
            frozenset(self._tracks),
            _US_PER_S / self.camera.fps,
            depth_delay_us=int(delay_ns) / 1000 if delay_ns.lstrip("-").isdigit() else 0.0,
        )
        names = {stream.index: track for track, stream in self._tracks.items()}
        for packet in self._packets(tuple(self._tracks.values())):
            assert packet.pts is not None
            time_us = round(packet.pts * packet.time_base * _US_PER_S)
            yield from pairing.push(names[packet.stream_index], time_us, packet)
        yield from pairing.flush()

    def decode(self, capture: Capture[_Packet]) -> Frame | BadFrame:
        """Decode depth and IR; the colour's JPEG is passed on as it is."""
        if capture.depth is None:
            return BadFrame(capture.time_us, "no depth in this capture")
        if capture.ir is None:
            return BadFrame(capture.time_us, "no IR in this capture")
        depth = self._grey("DEPTH", capture.depth)
        if depth is None:
            return BadFrame(capture.time_us, "the depth cannot be decoded")
        ir = self._grey("IR", capture.ir)
        if ir is None:
            return BadFrame(capture.time_us, "the IR cannot be decoded")
        return Frame(capture.time_us, depth, ir, self._colour(capture.colour))

    @property
    def whole(self) -> bool:
        """Whether the file is complete: closed by its writer, and as long as it states."""
        return self._readable and self._complete

    @property
    def closed_by_writer(self) -> bool:
        """Whether the program that wrote the file has completed it."""
        return self._complete

    def close(self) -> None:
        """May be called twice."""
        self._container.close()
        self._file.close()

    def _checked_size(self) -> bool:
        """Whether the file is as long as it states; False if it was never closed.

        Raises UserError if it is shorter: better now than after the frames that are left.
        """
        declared, size = declared_size(self._file), self._path.stat().st_size
        if declared is not None and size < declared:
            raise UserError(
                f"{self._path} is truncated: it has {size} of its {declared} bytes; "
                "copy or record it again."
            )
        return declared is not None

    def _demuxer(self) -> InputContainer:
        self._file.seek(0)
        try:
            # Tags of a damaged file need not be UTF-8.
            return av.open(self._file, "r", format="matroska", metadata_errors="replace")
        except (FFmpegError, OSError) as error:
            raise UserError(
                f"{self._path} cannot be read: its Matroska header is cut off or damaged; "
                "copy or record it again."
            ) from error

    def _checked_tracks(self) -> dict[Track, VideoStream]:
        tracks: dict[Track, VideoStream] = {}
        for stream in self._container.streams.video:
            title = stream.metadata.get("title")
            if title in get_args(Track):
                tracks.setdefault(cast(Track, title), stream)
        for track in ("DEPTH", "IR"):
            if track not in tracks:
                raise UserError(
                    f"{self._path} has no {track} track; "
                    "record it with an Azure Kinect and with depth and IR switched on."
                )
            pix_fmt = tracks[track].pix_fmt
            if pix_fmt is None:
                raise no_frames(self._path)
            if pix_fmt not in _BYTE_ORDERS:
                raise UserError(
                    f"{self._path}: its {track} track is {pix_fmt}, not 16-bit grey; "
                    "use the recording as the camera wrote it."
                )
        return tracks

    def _checked_camera(self) -> Camera:
        colour = self._tracks.get("COLOR")
        mode = self._tag("DEPTH", "K4A_DEPTH_MODE").upper()
        if mode == "PASSIVE_IR":
            raise UserError(
                f"{self._path} was recorded in PASSIVE_IR, without depth; record it in a depth "
                "mode such as NFOV_UNBINNED."
            )
        try:
            camera = k4a.from_json(
                self._calibration(),
                depth_mode=mode,
                # As in "MJPG_720P".
                colour_resolution=self._tag("COLOR", "K4A_COLOR_MODE").split("_")[-1]
                if colour is not None
                else None,
                # A file that does not state its rate has that of its mode.
                fps=round(self._tracks["DEPTH"].average_rate or 0) or k4a.DEPTH_FPS.get(mode, 0),
            )
        except k4a.CalibrationError as error:
            raise UserError(
                f"{self._path}: {error}; use the recording as the camera wrote it."
            ) from error
        self._check_size("DEPTH", camera.depth)
        self._check_size("IR", camera.depth)
        if camera.colour is not None:
            self._check_size("COLOR", camera.colour)
        return camera

    def _tag(self, track: Track, name: str) -> str:
        """Return a tag of the track, or of the file if a tool moved it there."""
        tags = self._tracks[track].metadata
        return tags.get(name) or self._container.metadata.get(name, "")

    def _calibration(self) -> bytes:
        for stream in self._container.streams:
            if isinstance(stream, AttachmentStream) and stream.name == "calibration.json":
                return stream.data
        raise UserError(
            f"{self._path} has no calibration.json attached; "
            "use the recording as the camera wrote it, attachments included."
        )

    def _check_size(self, track: Track, lens: Lens) -> None:
        stream = self._tracks[track]
        if (stream.width, stream.height) != (lens.width, lens.height):
            raise UserError(
                f"{self._path}: its {track} track is {stream.width} x {stream.height} where its "
                f"mode has {lens.width} x {lens.height}; use the recording as the camera wrote it."
            )

    def _packets(self, streams: tuple[VideoStream, ...]) -> Iterator[_Packet]:
        try:
            for packet in self._container.demux(streams):
                if packet.pts is not None and packet.size > 0:
                    yield packet
        except FFmpegError:
            # Unreadable from here on; the caller decides by `whole` what that means.
            self._readable = False

    def _grey(self, track: Track, packet: _Packet) -> NDArray[np.uint16] | None:
        """(H, W) uint16, or None where the packet is damaged."""
        stream = self._tracks[track]
        if stream.codec_context.name == "rawvideo":
            if packet.size != stream.width * stream.height * 2:
                return None
            order = _BYTE_ORDERS[stream.pix_fmt or ""]
            raw = np.frombuffer(memoryview(packet), dtype=order).astype(np.uint16)
            return raw.reshape(stream.height, stream.width)
        try:
            frames = stream.decode(packet)
        except FFmpegError:
            return None
        if len(frames) != 1 or frames[0].format.name not in _BYTE_ORDERS:
            return None
        return frames[0].to_ndarray().astype(np.uint16, copy=False)

    def _colour(self, packet: _Packet | None) -> NDArray[np.uint8] | bytes | None:
        if packet is None:
            return None
        stream = self._tracks["COLOR"]
        if stream.codec_context.name == "mjpeg":
            return bytes(packet)
        try:
            frames = stream.decode(packet)
        except FFmpegError:
            # The hand tracker continues with IR alone, as it does without colour.
            return None
        return frames[0].to_ndarray(format="bgr24").astype(np.uint8, copy=False) if frames else None


def no_frames(path: Path) -> UserError:
    """Return the error for a recording without a readable frame."""
    return UserError(
        f"{path} holds no readable frame with depth and IR: it is truncated, damaged or was "
        "recorded without; copy or record it again."
    )
