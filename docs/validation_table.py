# SPDX-License-Identifier: GPL-2.0-or-later
"""Put the table of a validation into docs/validation.md: ``python docs/validation_table.py validation.json``."""

import json
import re
import sys
from pathlib import Path

from lammps_jump.studies.validation import summary_text

BEGIN, END = "<!-- made by docs/validation_table.py -->", "<!-- end -->"


def main(source: Path, page: Path) -> None:
    """Replace what stands between the two comments."""
    report = json.loads(source.read_text(encoding="utf-8"))
    about = f"Full form on {report['machine']['processor']}, lammps-jump {report['versions']['lammps_jump']}:"
    if report["quick"]:
        raise SystemExit(f"{source}: is of the short form; run `lammps-jump validate` without --quick")
    text = f"{BEGIN}\n## What was found\n\n{about}\n\n{summary_text(report)}\n{END}"
    old = page.read_text(encoding="utf-8")
    page.write_text(re.sub(f"{BEGIN}.*{END}", lambda _: text, old, flags=re.DOTALL), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(__file__).with_name("validation.md"))
