from .calibration import run_calibration as run_calibration
from .sensitivity import run_sensitivity as run_sensitivity
