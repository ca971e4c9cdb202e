from .derived import Derived as Derived
from .fields import CaseFields as CaseFields
from .load import Case as Case
from .load import load_case as load_case
from .load import parse_case as parse_case
from .templates import scene_names as scene_names
from .templates import scene_text as scene_text
