"""What `purcell gait` shows of many strokes: the atlas, and sweeps of amplitudes and of link ratios."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from purcell_cli.cli.documents.gait import AtlasDocument, LinkRatioDocument, SweepDocument
from purcell_cli.cli.reports import atlas as reports
from purcell_cli.files.atomic_file import whole_file
from purcell_cli.gaits.atlas import atlas as every_entry
from purcell_cli.gaits.atlas import ratio_sweep, steps, sweep
from purcell_cli.gaits.gait import Gait
from purcell_cli.mechanics.swimmer import Swimmer


def _write(rows: Sequence[Mapping[str, object]], out: Path | None) -> None:
    if out is not None:
        with whole_file(out) as file:
            file.write(reports.as_csv(rows))


def atlas(gaits: Mapping[str, Gait], swimmer: Swimmer, out: Path | None) -> AtlasDocument:
    """Make the atlas of all gaits, and write it as CSV where a file is named."""
    entries, left_out = every_entry(gaits, swimmer)
    document = reports.atlas_document(entries, left_out, swimmer, None if out is None else str(out))
    _write(document["gaits"], out)
    return document


def amplitudes(gait: Gait, swimmer: Swimmer, text: str, out: Path | None) -> SweepDocument:
    """Sweep a gait's amplitude over A:B:STEP, and write the table as CSV where a file is named."""
    found = sweep(gait, swimmer, steps(text, "--sweep"))
    document = reports.sweep_document(found, swimmer, None if out is None else str(out))
    _write(document["rows"], out)
    return document


def ratios(gait: Gait, swimmer: Swimmer, amplitude: float | None, text: str, out: Path | None) -> LinkRatioDocument:
    """Sweep the ratio of middle to outer link over A:B:STEP, and write the table as CSV where a file is named."""
    along, rows = ratio_sweep(gait, swimmer, amplitude, steps(text, "--link-ratio"))
    document = reports.ratio_document(gait, along, rows, swimmer, None if out is None else str(out))
    _write(document["rows"], out)
    return document
