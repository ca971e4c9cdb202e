# SPDX-License-Identifier: GPL-2.0-or-later
from .case import ReadCase as ReadCase
from .case import load_case as load_case
from .case import parse_case as parse_case
from .case import scene_names as scene_names
from .case import scene_text as scene_text
from .derived import Derived as Derived
from .fields import CaseFields as CaseFields
