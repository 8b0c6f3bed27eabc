"""The settings of the service: one model of `halo.toml`, and how the file is read."""

from halo_service.settings.file import load, settings_path
from halo_service.settings.model import Settings, SourceSettings, TrackingSettings, default_node

__all__ = [
    "Settings",
    "SourceSettings",
    "TrackingSettings",
    "default_node",
    "load",
    "settings_path",
]
