"""Case files: YAML to a validated, frozen `Case`, and on to a `Scene`."""

from .load import LoadedCase, case_hash, load_case, parse_case, resolved_yaml
from .models import Case

__all__ = ["Case", "LoadedCase", "case_hash", "load_case", "parse_case", "resolved_yaml"]
