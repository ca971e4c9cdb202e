from .study import Stress as Stress
from .study import stress as stress
