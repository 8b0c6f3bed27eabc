"""The control page of one service: its server, what it shows and what it can do."""

from __future__ import annotations

import logging
import sys
import webbrowser

import segno

from halo_service.app.page.camera_calls import CameraCalls
from halo_service.app.page.node_calls import NodeCalls
from halo_service.app.page.observer import PageObserver
from halo_service.app.page.output_calls import OutputCalls
from halo_service.app.page.parts import PageRequest, Parts
from halo_service.app.page.picture_thread import PictureThread
from halo_service.app.page.profile_calls import ProfileCalls
from halo_service.app.page.record_calls import RecordCalls
from halo_service.app.page.settings_calls import SettingsCalls
from halo_service.app.page.wizard.wizard import Wizard
from halo_service.runtime.live import Publisher
from halo_service.web.addresses import own_addresses
from halo_service.web.control_page.server import PageServer

log = logging.getLogger(__name__)


class ControlPage:
    """Runs until it is closed."""

    def __init__(self, parts: Parts, request: PageRequest, inner: Publisher) -> None:
        """Open the server. Raises `UserError` for a host that is not of this machine."""
        settings, source = parts.settings, parts.source
        self.server = PageServer(settings.page, own_addresses())
        self.observer = PageObserver(
            inner, self.server, source.camera, parts.fit, lambda: self._outputs.counts()
        )
        self._outputs = OutputCalls(settings, parts.osc, parts.web, parts.zenoh, self.observer)
        reloader = parts.reloader
        changes = SettingsCalls(settings, request.config, parts.osc, self.observer.request)
        profiles = ProfileCalls(
            reloader,
            lambda: reloader.profile.name if reloader.profile else "",
            changes.profile_at_start,
        )
        self._wizard = Wizard(
            settings,
            source,
            self.observer,
            reloader,
            self.server,
            parts.paused,
            changes.profile_at_start,
        )
        records = RecordCalls(source, self.observer, lambda: self._wizard.running)
        self._records = records
        self._nodes = NodeCalls(settings.zenoh)
        self.observer.about_source = lambda: {
            "source": source.kind,
            "recording": records.replayed,
        }
        self.observer.about = {
            "source_name": settings.source.name,
            "serial": source.camera.serial,
            "depth_mode": source.camera.depth_mode,
            "fps": source.camera.fps,
            "colour": source.camera.colour is not None,
            "node": settings.node,
        }
        self.server.calls = {
            **self._outputs.table(),
            **self._records.table(),
            **profiles.table(),
            **changes.table(),
            **self._wizard.table(),
            **CameraCalls().table(),
            **self._nodes.table(),
        }
        self.server.on_join = self.observer.greet
        self.server.on_message = self._wizard.screen.take
        self._pictures = PictureThread(self.server, lambda: self.observer.newest)

    def announce(self, opens: bool) -> None:
        """Say where the page is, and open it where that is asked for."""
        for token, role in self.server.tokens.items():
            for address in sorted(own_addresses()):
                url = f"http://{address}:{self.server.port}/?token={token}"
                log.info("page for other machines (%s): %s", role, url)
                if role == "operator" and sys.stderr.isatty():
                    segno.make(url).terminal(sys.stderr, compact=True)
        token = next(iter(self.server.tokens), "")
        url = self.server.url + (f"?token={token}" if token else "")
        log.info("page: %s", url)
        if opens and not webbrowser.open(url):
            log.warning("page: no browser was found; open %s", url)

    def close(self) -> None:
        """End threads and connections."""
        self._wizard.close()
        self._pictures.close()
        self._records.close()
        self._outputs.close()
        self._nodes.close()
        self.server.close()
        self.observer.close()
