from . import doctor as doctor
from . import live as live
from . import progress as progress
