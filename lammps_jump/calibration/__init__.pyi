# SPDX-License-Identifier: GPL-2.0-or-later
from . import page as page
from .calibrate import Calibrated as Calibrated
from .calibrate import calibrate as calibrate
from .calibrate import submit as submit
from .search import SearchProgress as SearchProgress
from .study import all_targets as all_targets
from .study import parse_vary as parse_vary
from .study import read_calibration as read_calibration
from .targets import FEWEST as FEWEST
from .targets import curve_of as curve_of
from .targets import measured_of as measured_of
from .targets import parse_columns as parse_columns
from .targets import parse_target as parse_target
