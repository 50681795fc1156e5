"""`platform-daemon certificate`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from platform_daemon.core.command_line.options import CalibrationOption, ForceOption, calibration_in
from platform_daemon.core.command_line.output import must_not_exist, say_note, write_json, write_page
from platform_daemon.features.measurand.command import DEFAULT_FOLDER, FolderOption


def certificate(
    specimen: Annotated[str, typer.Argument(help="Resonator, by name or file.")],
    file: Annotated[Path, typer.Argument(help="Recording of it, of several shots.")],
    *,
    details: Annotated[Path, typer.Option(help="TOML file: number, person, [laboratory], [customer].")],
    out: Annotated[Path, typer.Option(help="Name of the files, without ending.")] = Path("certificate"),
    uncertainty: Annotated[
        Path | None, typer.Option(help="TOML file with [uncertainty], before what the recording declares.")
    ] = None,
    coverage: Annotated[float, typer.Option(help="Probability of the interval value ± U.")] = 0.95,
    calibration: CalibrationOption = None,
    measurand: Annotated[
        str | None, typer.Option(help="Certify it as a sensor, too: KEY or KEY@VERSION of its calibration.")
    ] = None,
    measurands: FolderOption = DEFAULT_FOLDER,
    force: ForceOption = False,
) -> None:
    """Make a calibration certificate of a specimen: HTML, PDF/A, DCC (XML) and JSON."""
    from datetime import UTC, datetime

    from platform_daemon.core.command_line.progress import compile_fit
    from platform_daemon.core.settings import load_specimen
    from platform_daemon.core.state.durable import write_file
    from platform_daemon.features.budget.declared import declared_by
    from platform_daemon.features.fit.fit_request import FitSettings
    from platform_daemon.features.fit.measurement import open_shots_for_fit
    from platform_daemon.features.measurand.library import Measurands

    from .dcc import dcc_xml
    from .page import certificate_page
    from .pdf import certificate_pdf
    from .words import result_row
    from .work import certificate_of, read_details

    ends = (".html", ".pdf", ".xml", ".json")
    html, pdf, xml, json_file = (out.with_name(out.name + end) for end in ends)
    for path, end in zip((html, pdf, xml, json_file), ends, strict=True):
        must_not_exist(path, force, end)
    who = read_details(details)
    declared = None if uncertainty is None else declared_by(uncertainty)
    found, _ = load_specimen(specimen)
    sensor = None if measurand is None else Measurands(measurands).get(measurand)
    measurement, ask = open_shots_for_fit(file, FitSettings(None, "d30", calibration=calibration_in(calibration)))
    say_note(measurement.path, measurement.other_layout)
    compile_fit()
    report = certificate_of(
        found,
        measurement,
        ask,
        who,
        declared=declared,
        sensor=sensor,
        issued=datetime.now(UTC).date(),
        coverage=coverage,
    )
    printed = certificate_pdf(report)  # before anything is written: it may be refused
    write_page(html, certificate_page(report))
    write_file(pdf, printed)
    write_file(xml, dcc_xml(report))
    write_json(json_file, report)
    for each in report.results:
        name, value, expanded, k = result_row(each)
        print(f"{name} = {value}, U = {expanded} (k = {k})")
    print(f"certificate {report.number}: {html}, {pdf}, {xml}, {json_file}; to be signed by {report.person}")
