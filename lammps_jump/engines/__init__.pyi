from . import accuracy as accuracy
from . import lammps as lammps
from . import native as native
from . import plugin as plugin
