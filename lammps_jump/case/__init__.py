"""Case files: YAML to a validated, frozen `Case`, and on to a `Scene`."""

from .fields import Case
from .load import LoadedCase, case_hash, load_case, parse_case, resolved_yaml

__all__ = ["Case", "LoadedCase", "case_hash", "load_case", "parse_case", "resolved_yaml"]
