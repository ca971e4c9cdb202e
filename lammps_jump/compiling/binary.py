# SPDX-License-Identifier: GPL-2.0-or-later
"""For which system and processor compiled code is, by its first bytes."""

from __future__ import annotations

ELF, MACH, DOS, PE = b"\x7fELF", b"\xcf\xfa\xed\xfe", b"MZ", b"PE\0\0"
"""First bytes of code of Linux, macOS (of 64 bits) and Windows; of Windows' second head."""
MACHINES = {
    ("Linux", 62): "x86_64",
    ("Linux", 183): "aarch64",
    ("Darwin", 0x0100_0007): "x86_64",
    ("Darwin", 0x0100_000C): "arm64",
    ("Windows", 0x8664): "AMD64",
    ("Windows", 0xAA64): "ARM64",
}
"""Words of `platform.machine()` by those of `platform.system()` and the number in the head (ELF e_machine, Mach-O
cputype, PE Machine)."""


def is_code(data: bytes) -> bool:
    """Tells whether a file begins as an object or library does."""
    return data.startswith((ELF, MACH, DOS))


def made_for(code: bytes) -> tuple[str, str] | None:
    """System and machine of an object or library, by the words of `platform`; None where it is neither.

    The object files of Windows have no mark of their own, so that its libraries alone are known.
    """
    if code.startswith(ELF):
        system, number = "Linux", code[18:20]
    elif code.startswith(MACH):
        system, number = "Darwin", code[4:8]
    elif code.startswith(DOS):
        place = int.from_bytes(code[0x3C:0x40], "little")
        system, number = "Windows", code[place + 4 : place + 6] if code[place : place + 4] == PE else b""
    else:
        return None
    machine = MACHINES.get((system, int.from_bytes(number, "little")))
    return (system, machine) if machine else None
