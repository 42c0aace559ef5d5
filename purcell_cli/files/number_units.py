"""Numbers with a unit, which no document has: the message says what the key's unit is, and the number in it."""

from __future__ import annotations

import math
import re

from purcell_cli.files.place import Place, kind

_SCALES = {
    "m": {"nm": 1e-9, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "mm": 1e-3, "cm": 1e-2, "dm": 0.1, "m": 1.0, "km": 1e3},
    "deg": {"deg": 1.0, "degree": 1.0, "degrees": 1.0, "°": 1.0, "rad": math.degrees(1.0)},
    "rad": {"rad": 1.0, "deg": math.radians(1.0), "degree": math.radians(1.0), "degrees": math.radians(1.0),
            "°": math.radians(1.0)},
    "s": {"us": 1e-6, "µs": 1e-6, "ms": 1e-3, "s": 1.0, "sec": 1.0, "min": 60.0, "h": 3600.0},
    "Pa s": {"Pa s": 1.0, "Pa.s": 1.0, "Pa*s": 1.0, "mPa s": 1e-3, "mPa.s": 1e-3, "cP": 1e-3, "P": 0.1},
    "rad/s": {"rad/s": 1.0, "deg/s": math.radians(1.0), "°/s": math.radians(1.0), "rpm": math.tau / 60.0},
}  # fmt: skip
"""What units there are for the unit of a key, and how many of the key's they are."""

_ENDINGS = {
    "pa_s": "Pa s", "rad_s": "rad/s", "rad_s2": "rad/s^2", "m": "m", "deg": "deg", "rad": "rad", "s": "s",
    "n_s_per_m": "N s/m", "n_m_s": "N m s",
}  # fmt: skip
"""The units that keys end in, the longer before the shorter."""

_WITH_UNIT = re.compile(r"([-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?) ?([^\W\d_°][^\d_]{0,9}|°(?:/s)?)")


def unit_hint(place: Place) -> str:
    """Return what to say of a text that is a number with a unit; nothing of any other."""
    found = _WITH_UNIT.fullmatch(str(place.node.value)) if kind(place.node) == "str" else None
    if found is None:
        return ""
    unit = unit_of(place.key)
    if unit is None:
        return " (a number alone is wanted, without a unit)"
    scale = _SCALES.get(unit, {}).get(found[2].strip())
    told = f"the unit is {unit}, as the key says"
    return f" ({told}: write {float(found[1]) * scale:.12g})" if scale else f" ({told}; write the number alone)"


def unit_of(key: str) -> str | None:
    """Return the unit of a key path's last key, None for a number without one."""
    names = [name for name in re.split(r"[.\[\]]+", key) if name and not name.isdigit()]
    for name in reversed(names):
        for ending, unit in _ENDINGS.items():
            if name.endswith(f"_{ending}"):
                return unit
        if name in {"min", "max"}:
            continue
        return None
    return None
