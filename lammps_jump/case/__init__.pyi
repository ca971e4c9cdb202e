# SPDX-License-Identifier: GPL-2.0-or-later
from .case import ReadCase as ReadCase
from .case import load_case as load_case
from .case import parse_case as parse_case
from .derived import Derived as Derived
from .fields import CaseFields as CaseFields
from .templates import scene_names as scene_names
from .templates import scene_text as scene_text
