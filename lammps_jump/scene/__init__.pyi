# SPDX-License-Identifier: GPL-2.0-or-later
from .build import handmade_scene as handmade_scene
from .chains import Chain as Chain
from .motion import Motion as Motion
from .motion import MovingWall as MovingWall
from .motion import gate as gate
from .scene import Beginning as Beginning
from .scene import InletRow as InletRow
from .scene import Outlet as Outlet
from .scene import Pour as Pour
from .scene import Scene as Scene
from .scene import Stations as Stations
from .sizes import Sizes as Sizes
from .walls import Block as Block
from .walls import Box as Box
from .walls import Interval as Interval
from .walls import Plane as Plane
from .walls import Wall as Wall
