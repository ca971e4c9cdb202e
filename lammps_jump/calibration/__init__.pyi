# SPDX-License-Identifier: GPL-2.0-or-later
from . import page as page
from .calibrate import Calibrated as Calibrated
from .calibrate import calibrate as calibrate
from .calibrate import submit as submit
from .measured import FEWEST as FEWEST
from .measured import curve_of as curve_of
from .measured import measured_of as measured_of
from .measured import parse_columns as parse_columns
from .search import SearchProgress as SearchProgress
from .study import all_targets as all_targets
from .study import parse_vary as parse_vary
from .study import read_calibration as read_calibration
from .targets import parse_target as parse_target
