"""The picture of docs/howto/nights-and-schedules.md: a half year with two changes.

python -m tests.campaigns.trend_picture
"""

from __future__ import annotations

from dataclasses import replace

from platform_daemon.features.trends.figure import save_trend_png
from platform_daemon.features.trends.trend import specimen_trend
from tests.campaigns.trend_alarms import BEFORE_DAYS, CASES, half_year
from tests.kit.data import ROOT

SEED, WEAR_FROM, WEAR = 77, 100, 0.06
SHOWN = ("f_nat_hz", "m_r_am2", "tf_over_i_rad_per_s2", "lambda_per_s", "noise_x_v", "nrmse")


def main() -> None:
    """Draw it."""
    lost = next(case for case in CASES if case.name == "lost_magnetisation")
    recordings = []
    for each in half_year(lost, SEED):
        part = max(0.0, (int(each.identifier[1:]) / 4 - WEAR_FROM) / (182 - WEAR_FROM))
        (point,) = each.points
        values = {name: value for name, value in point.values.items() if name in SHOWN}
        values["tf_over_i_rad_per_s2"] *= 1.0 + WEAR * part
        recordings.append(replace(each, points=(replace(point, values=values),)))
    report = specimen_trend(f"J-01 (simulated, changes from day {BEFORE_DAYS} and day {WEAR_FROM} on)", recordings)
    for change in report.changes:
        print(change.name, change.since, change.noticed)
    save_trend_png(report, ROOT / "docs" / "pictures" / "trend.png")


if __name__ == "__main__":
    main()
