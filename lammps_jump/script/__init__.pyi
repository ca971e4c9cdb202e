# SPDX-License-Identifier: GPL-2.0-or-later
from . import job as job
from . import stock as stock
from .assemble import Options as Options
from .assemble import continuation_text as continuation_text
from .assemble import script_text as script_text
from .assemble import write_continuation as write_continuation
from .assemble import write_script as write_script
