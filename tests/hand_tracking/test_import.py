"""What the import of the hand tracker loads."""

import subprocess
import sys

CODE = """
import sys
import halo_service.app.service.serve
assert "mediapipe" not in sys.modules and "sklearn" not in sys.modules
import halo_service.hand_tracking.hands
assert "matplotlib" not in sys.modules and "sklearn" not in sys.modules
import matplotlib.pyplot
assert hasattr(matplotlib.pyplot, "plot")
"""


def test_the_service_starts_without_plotting_and_learning_libraries() -> None:
    subprocess.run([sys.executable, "-c", CODE], check=True)
