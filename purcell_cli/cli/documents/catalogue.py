"""Every JSON document that a command prints or writes, by the name in its key `schema`."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from purcell_cli.batch.rows import Summary
from purcell_cli.cli.documents.batch import BatchDocument
from purcell_cli.cli.documents.controllability import ControllabilityDocument, MapDocument
from purcell_cli.cli.documents.export import ExportDocument
from purcell_cli.cli.documents.files import (
    FiguresDocument,
    FilmDocument,
    InitDocument,
    PlotDocument,
    SchemaDocument,
    ValidateDocument,
    ViewDocument,
)
from purcell_cli.cli.documents.fit import FitDocument
from purcell_cli.cli.documents.gait import (
    AtlasDocument,
    DesignDocument,
    GaitDocument,
    GaitListDocument,
    LinkRatioDocument,
    SweepDocument,
)
from purcell_cli.cli.documents.plan import PlanDocument, VerifyDocument
from purcell_cli.cli.documents.simulate import SimulateDocument
from purcell_cli.cli.documents.track import TrackDocument

DOCUMENTS: Mapping[str, Any] = MappingProxyType(
    {
        "purcell/plan/1": PlanDocument,
        "purcell/run/1": PlanDocument,
        "purcell/replan/1": PlanDocument,
        "purcell/verify/1": VerifyDocument,
        "purcell/simulate/1": SimulateDocument,
        "purcell/track/1": TrackDocument,
        "purcell/fit/1": FitDocument,
        "purcell/gait/1": GaitDocument,
        "purcell/gait-list/1": GaitListDocument,
        "purcell/atlas/1": AtlasDocument,
        "purcell/sweep/1": SweepDocument,
        "purcell/link-ratio/1": LinkRatioDocument,
        "purcell/design/1": DesignDocument,
        "purcell/controllability/1": ControllabilityDocument,
        "purcell/controllability-map/1": MapDocument,
        "purcell/batch/1": BatchDocument,
        "purcell/batch-summary/1": Summary,
        "purcell/plot/1": PlotDocument,
        "purcell/figures/1": FiguresDocument,
        "purcell/view/1": ViewDocument,
        "purcell/film/1": FilmDocument,
        "purcell/export/1": ExportDocument,
        "purcell/init/1": InitDocument,
        "purcell/validate/1": ValidateDocument,
        "purcell/schema/1": SchemaDocument,
    }
)
"""The type of each document; any command may print a `common.Failure` instead."""
