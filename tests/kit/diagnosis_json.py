"""Diagnoses in their JSON form, as short as can be."""


def effect(identifier, value, unit="", start=None, end=None, **detail):
    return {
        "id": identifier,
        "strength": {"value": value, "std": abs(value) / 50, "unit": unit},
        "detail": {"axis": None, "frequency_hz": None, "from": start, "to": end, **detail},
    }


def diagnosis(*effects, verdict="explained", model="thread", f_nat_hz=250.0, **parameters):
    values = {"f_nat_hz": f_nat_hz, **parameters}
    return {
        "verdict": verdict,
        "model": model,
        "effects": list(effects),
        "parameters_after": {n: {"value": v, "std": 0.0} for n, v in values.items()},
    }
