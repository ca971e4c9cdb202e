# SPDX-License-Identifier: GPL-2.0-or-later
from .history import Force as Force
from .history import Forces as Forces
from .history import analyse_forces as analyse_forces
from .impulse import Identity as Identity
from .impulse import impulse_identity as impulse_identity
from .reflection import ReflectedWave as ReflectedWave
from .reflection import track_reflection as track_reflection
