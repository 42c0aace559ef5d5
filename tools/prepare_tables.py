"""Makes what the package keeps ready so that a command starts sooner: the stored gaits as JSON.

python tools/prepare_tables.py

It is run when a gait changes; a test says when that was forgotten.
"""

from __future__ import annotations

from purcell_cli.files import gaits_as_json
from purcell_cli.files.builtin import data_folder, own_gaits


def main() -> None:
    """Write them."""
    folder = data_folder("gaits")
    text = gaits_as_json.json_text(own_gaits(folder), folder)
    (folder / gaits_as_json.NAME).write_text(text, encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
