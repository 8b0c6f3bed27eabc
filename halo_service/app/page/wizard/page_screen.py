"""A `Screen` of the guided projector step: a second page, in the projector's browser."""

from __future__ import annotations

import struct
import threading
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.errors import UserError
from halo_service.web.control_page.client import Message, PageClient
from halo_service.web.control_page.server import PageServer

Picture = NDArray[np.uint8]

SHOW_S = 5.0
"""Patience until the page has drawn a picture."""
LEAST_PX, MOST_PX = 320, 8192
"""Sizes of a projector's picture."""
KIND = "projector"


class PageScreen:
    """Knows the page that shows pictures, and how large it is."""

    changes = True

    def __init__(self, server: PageServer) -> None:
        self._server = server
        self._page: tuple[PageClient, tuple[int, int]] | None = None
        self._number = 0
        self._drawn = threading.Event()

    def take(self, message: Message) -> None:
        """Note what the projector's page reports; in the server's thread."""
        match message.value:
            case {"projector": [int() as width, int() as height]} if (
                min(width, height) >= LEAST_PX and max(width, height) <= MOST_PX
            ):
                self._page = message.client, (width, height)
            case {"drawn": int() as number} if number == self._number:
                self._drawn.set()

    @property
    def is_open(self) -> bool:
        """Whether a page can show pictures."""
        return self._page is not None and self._page[0] in self._server.clients

    @property
    def size_px(self) -> tuple[int, int]:
        """Width and height of the page in the projector's pixels. Raises `UserError`."""
        if self._page is None or not self.is_open:
            raise UserError(
                "no page shows the projector's picture: open the projector page in a browser on "
                "the projector, and make it full screen"
            )
        return self._page[1]

    def show(self, picture: Picture) -> None:
        """Show a (height, width, 3) BGR picture, and wait until it is drawn. Raises `UserError`."""
        width, height = self.size_px
        if picture.shape[:2] != (height, width):
            raise UserError("the projector's page changed its size: start the step again")
        good, data = cv2.imencode(".png", picture)
        assert good  # PNG can hold any picture of bytes
        self._number += 1
        self._drawn.clear()
        header = b'{"kind":"projector","number":%d}' % self._number
        message = struct.pack("<I", len(header)) + header + data.tobytes()
        assert self._page is not None  # `size_px` checked it
        client = self._page[0]
        self._server.post(lambda: client.put_picture(KIND, message))
        if not self._drawn.wait(SHOW_S):
            raise UserError(
                "the projector's page does not draw: bring it to the front, and keep it there"
            )


class BothScreens:
    """The virtual projector, which the camera sees, and a page that shows the same, if open."""

    changes = True

    def __init__(
        self, show: Callable[[Picture], None], size_px: tuple[int, int], page: PageScreen
    ) -> None:
        self._show, self.size_px, self._page = show, size_px, page

    def show(self, picture: Any) -> None:
        """Show a picture with both."""
        self._show(picture)
        if self._page.is_open:
            width, height = self._page.size_px
            fitted = cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA)
            self._page.show(np.asarray(fitted, np.uint8))
