from .study import cross_validate as cross_validate
from .study import run_command as run_command
