"""Records frames to a Matroska file in the layout of the Azure Kinect SDK.

Rule: a recording reads back equal: depth and IR pixel for pixel (FFV1), JPEG byte for byte,
the camera, and the time to 1 ms (the time step of Matroska as FFmpeg writes it). The same
frames give the same bytes: no date, no random number. The file gets its name only when it is
complete. Encoding takes about 15 ms of two cores per frame: do it after the packet was sent.
"""

from __future__ import annotations

import os
from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import Self

import av
import cv2
import numpy as np
from av.container import OutputContainer
from av.packet import Packet
from av.stream import Stream
from av.video.stream import VideoStream
from numpy.typing import NDArray

from halo_service.errors import UserError
from halo_service.files import followed, is_special
from halo_service.geometry import k4a
from halo_service.geometry.camera import Camera, Lens
from halo_service.values import Frame

_MICROSECOND = Fraction(1, 1_000_000)
_JPEG_QUALITY = 90
"""Of 100, for colour that comes as an array; the Kinect's own JPEG is about as large."""
_FFV1 = {
    "level": "3",
    "g": "1",  # each frame is a key frame, so a damaged one does not affect others
    "slices": "4",
    "slicecrc": "1",  # a damaged frame is noticed when it is read
}
CORES = 2
"""An image is encoded by so many threads: the infrared takes 20 ms of one core."""


class Recorder:
    """Writes one recording; a context manager that deletes the file when the run fails."""

    def __init__(self, path: Path, camera: Camera, *, fps: int, colour: bool) -> None:
        """Open a temporary file in the folder of `path`; raises UserError if that fails.

        `colour` asks for a COLOR track; ValueError for a camera without a colour lens, KeyError
        or ValueError for one that is in no mode of the Azure Kinect.
        """
        self._path = followed(path)
        self._lens = camera.colour if colour else None
        if colour and self._lens is None:
            raise ValueError("this camera has no colour to record")
        calibration = k4a.to_json(camera)
        if path.is_dir():
            raise UserError(f"{path} is a folder; name the file to record to.")
        if is_special(path):
            raise UserError(
                f"{path} is a pipe or device, and Matroska goes back to its beginning; "
                "name a file to record to."
            )
        self._part = self._path.with_name(f".{self._path.name}.{os.getpid()}.part")
        try:
            self._file = self._part.open("wb")
        except OSError as error:
            raise self._cannot_write(error) from error
        self._last_ms: int | None = None
        self._container: OutputContainer = av.open(
            self._file, "w", format="matroska", container_options={"fflags": "+bitexact"}
        )
        self._container.metadata.update(
            {
                "title": "Azure Kinect layout, by halo-service",
                "K4A_DEPTH_DELAY_NS": "0",
                "K4A_WIRED_SYNC_MODE": "STANDALONE",
                "K4A_START_OFFSET_NS": "0",
                "K4A_DEVICE_SERIAL_NUMBER": camera.serial,
            }
        )
        self._colour = None if self._lens is None else self._add_colour(self._lens, fps)
        self._depth = self._add_grey("DEPTH", camera.depth, fps, camera.depth_mode)
        self._ir = self._add_grey("IR", camera.depth, fps, "ACTIVE")
        self._attach(calibration)

    def write(self, frame: Frame) -> bool:
        """Append `frame`; False if its time is less than 1 ms after the last one.

        Such a frame is not written. Raises UserError if the file cannot be written (it is
        deleted then), ValueError for a frame of another size.
        """
        time_ms = round(frame.time_us / 1000)
        if self._last_ms is not None and time_ms <= self._last_ms:
            return False
        packets = [
            *_encoded(self._depth, frame.depth, time_ms),
            *_encoded(self._ir, frame.ir, time_ms),
        ]
        if self._colour is not None and frame.colour is not None:
            packets.insert(0, _stamped(Packet(self._jpeg(frame.colour)), self._colour, time_ms))
        try:
            self._container.mux(packets)
        except OSError as error:
            self.abort()
            raise self._cannot_write(error) from error
        self._last_ms = time_ms
        return True

    def close(self) -> None:
        """Complete the file and give it its name; raises UserError if that fails.

        A recording without a frame is deleted, with a UserError. May be called twice.
        """
        if self._file.closed:
            return
        if self._last_ms is None:
            self.abort()
            raise UserError(f"no frame came, so {self._path} was not written; check the source.")
        try:
            self._container.close()
            self._file.flush()
            os.fsync(self._file.fileno())
            self._file.close()
            self._part.replace(self._path)
        except OSError as error:
            self.abort()
            raise self._cannot_write(error) from error

    def abort(self) -> None:
        """Delete the file. May be called twice; after `close` it does nothing."""
        try:
            self._file.close()
        except OSError:
            # The disk is full: the file is deleted below anyway.
            assert self._file.closed
        self._container.close()  # writes nothing, because the file is closed
        self._part.unlink(missing_ok=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if kind is None:
            self.close()
        else:
            self.abort()

    def _add_colour(self, lens: Lens, fps: int) -> Stream:
        stream = self._container.add_mux_stream("mjpeg", fps, width=lens.width, height=lens.height)
        _label(stream, "COLOR", f"MJPG_{k4a.colour_resolution_of(lens)}")
        return stream

    def _add_grey(self, title: str, lens: Lens, fps: int, mode: str) -> VideoStream:
        stream = self._container.add_stream("ffv1", fps, options=dict(_FFV1))
        stream.width, stream.height, stream.pix_fmt = lens.width, lens.height, "gray16le"
        stream.codec_context.time_base = _MICROSECOND
        stream.codec_context.thread_count = CORES
        stream.codec_context.thread_type = "SLICE"  # the same bytes as by one thread
        _label(stream, title, mode)
        return stream

    def _attach(self, calibration: bytes) -> None:
        name = "calibration.json"
        attachment = self._container.add_attachment(name, "application/octet-stream", calibration)
        attachment.metadata["K4A_CALIBRATION_FILE"] = name

    def _jpeg(self, colour: NDArray[np.uint8] | bytes) -> bytes:
        if isinstance(colour, bytes):
            return colour
        assert self._lens is not None
        if colour.shape != (self._lens.height, self._lens.width, 3):
            raise ValueError(f"colour of shape {colour.shape} does not fit the camera's lens")
        done, jpeg = cv2.imencode(".jpg", colour, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])
        assert done, "OpenCV encodes any uint8 picture"
        return jpeg.tobytes()

    def _cannot_write(self, error: OSError) -> UserError:
        if isinstance(error, FileNotFoundError):
            return UserError(
                f"{self._path} cannot be written: the folder {self._path.parent} does not exist; "
                "create it, or name another one."
            )
        return UserError(
            f"{self._path} cannot be written ({error.strerror}); "
            "free some space, or record to another folder."
        )


def _label(stream: Stream, title: str, mode: str) -> None:
    """Label a track. The SDK finds tracks by number, which is FFmpeg's index plus 1."""
    stream.metadata["title"] = title
    stream.metadata[f"K4A_{title}_TRACK"] = str(stream.index + 1)
    stream.metadata[f"K4A_{title}_MODE"] = mode


def _encoded(stream: VideoStream, image: NDArray[np.uint16], time_ms: int) -> list[Packet[Stream]]:
    if image.shape != (stream.height, stream.width):
        raise ValueError(f"a picture of shape {image.shape} does not fit the camera's lens")
    picture = av.VideoFrame.from_ndarray(np.ascontiguousarray(image), format="gray16le")
    picture.pts, picture.time_base = time_ms * 1000, _MICROSECOND
    return [_stamped(packet, stream, time_ms) for packet in stream.encode(picture)]


def _stamped(packet: Packet[Stream], stream: Stream, time_ms: int) -> Packet[Stream]:
    packet.stream = stream
    packet.pts = packet.dts = time_ms * 1000
    packet.time_base = _MICROSECOND
    packet.is_keyframe = True
    return packet
