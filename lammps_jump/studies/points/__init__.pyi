# SPDX-License-Identifier: GPL-2.0-or-later
from . import find as find
from . import work as work
from .find import load_module as load_module
from .find import source_of as source_of
from .point import FAILED as FAILED
from .point import Found as Found
from .point import Point as Point
from .point import PointStudy as PointStudy
from .study import run_named as run_named
from .study import run_study as run_study
from .study import study_named as study_named
