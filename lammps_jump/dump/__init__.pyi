# SPDX-License-Identifier: GPL-2.0-or-later
from .check import FrameCheck as FrameCheck
from .check import force_troubles as force_troubles
from .exports import export as export
from .exports import read_netcdf as read_netcdf
from .find import ForceHistory as ForceHistory
from .find import find_dump as find_dump
from .find import read_dump as read_dump
from .find import read_forces as read_forces
from .frame import Frame as Frame
from .frame import make_frame as make_frame
from .read import Dump as Dump
from .read import open_dump as open_dump
from .tail import Tail as Tail
from .write import DumpWriter as DumpWriter
