# SPDX-License-Identifier: GPL-2.0-or-later
from .page import verdict_text as verdict_text
from .study import REPORT_FILE as REPORT_FILE
from .study import cross_validate as cross_validate
from .study import default_folder as default_folder
