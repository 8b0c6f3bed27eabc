"""What a camera's name says."""

import pytest

from halo_service.errors import UserError
from halo_service.sources.camera_name import CameraOptions, kind_of, parse_camera_name

GOOD = {
    "azure-kinect": ("azure-kinect", CameraOptions()),
    "azure-kinect:000123": ("azure-kinect", CameraOptions(serial="000123")),
    "azure-kinect,serial=000123": ("azure-kinect", CameraOptions(serial="000123")),
    "femto-bolt,serial=CL8,mode=WFOV_2X2BINNED": (
        "femto-bolt",
        CameraOptions(serial="CL8", mode="WFOV_2X2BINNED"),
    ),
    "azure-kinect,mode=WFOV_UNBINNED": ("azure-kinect", CameraOptions(mode="WFOV_UNBINNED")),
    "femto-bolt,exposure_ms=8,gain=70,power_line_hz=50": (
        "femto-bolt",
        CameraOptions(exposure_ms=8.0, gain=70, power_line_hz=50),
    ),
    "femto-mega,address=192.168.1.10,sync=secondary,sync_delay_us=160": (
        "femto-mega",
        CameraOptions(address="192.168.1.10", sync="secondary", sync_delay_us=160),
    ),
}


@pytest.mark.parametrize("name", GOOD)
def test_a_name_is_read(name):
    assert parse_camera_name(name) == GOOD[name]


BAD = {
    "femto-bolt,serail=3": "no option 'serail'; did you mean 'serial'",
    "femto-bolt,address=1.2.3.4": "no option 'address'",
    "femto-bolt,mode=PASSIVE_IR": "choose from: NFOV_UNBINNED",
    "femto-bolt,serial=": "must not be empty",
    "femto-bolt,serial": "give it a value with '='",
    "femto-bolt,exposure_ms=nan": "in range 0.1..100",
    "azure-kinect,gain=loud": "in range 0..1000",
    "azure-kinect,power_line_hz=55": "choose from: 50, 60",
    "azure-kinect,sync=both": "choose from: alone, primary, secondary",
    "azure-kinect,sync_delay_us=160": "works only with sync=secondary",
    "azure-kinect,sync=secondary,sync_delay_us=99999": "in range 0..33333",
    "kinect2": "unknown camera 'kinect2'",
}


@pytest.mark.parametrize("name", BAD)
def test_a_wrong_name_is_one_sentence(name):
    with pytest.raises(UserError, match=BAD[name]):
        parse_camera_name(name)


@pytest.mark.parametrize("name", ["sim", "sim:demo", "auto", "recording:femto-bolt", "femto-boltx"])
def test_other_sources_are_no_cameras(name):
    assert kind_of(name) is None
