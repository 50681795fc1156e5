"""Diagnoses, as short as can be."""

from platform_daemon.diagnosis.report_schema import DiagnosisReport


def effect(identifier, value, unit="", start=None, end=None, **detail):
    """An effect in its JSON form."""
    places = {"axis": None, "frequency_hz": None, "tau_s": None, "sample": None, "from": start, "to": end}
    return {
        "id": identifier,
        "strength": {"value": value, "std": abs(value) / 50, "unit": unit},
        "detail": {**places, **detail},
        "p_value": 0.0,
        "held_out_gain": 100.0,
        "indistinguishable_from": [],
        "log10_p_value": -40.0,
        "source": "",
    }


def diagnosis(*effects, verdict="explained", model="thread", f_nat_hz=250.0, **parameters):
    """A diagnosis in its JSON form."""
    values = {"f_nat_hz": f_nat_hz, **parameters}
    errors = ("nrmse_before", "nrmse_after", "chi2_per_dof_before", "chi2_per_dof_after")
    return {
        "verdict": verdict,
        "effects": list(effects),
        "held_out": {**dict.fromkeys(errors), "n_shots": 1},
        "parameters_before": {},
        "parameters_after": {n: {"value": v, "std": 0.0} for n, v in values.items()},
        "n50_d30": {},
        "integrity": [],
        "missing_torque": None,
        "next_measurements": [],
        "seconds": 1.0,
        "model": model,
        "scatter": {},
        "ranking": [],
        "left_over": {"gain": None, "p_value": None},
        "notes": [],
    }


def diagnosed(*effects, **keys):
    """The diagnosis itself."""
    return DiagnosisReport.model_validate(diagnosis(*effects, **keys))
